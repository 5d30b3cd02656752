"""Study: what each model costs and reaches."""

from freerock.jobs.log import log_to
from freerock.studies.model_choice import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
