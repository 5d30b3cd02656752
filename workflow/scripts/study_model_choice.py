"""Study: what each model costs and reaches."""

from freerock.jobs.log import log_to
from freerock.studies.speed_accuracy import model_choice
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(model_choice(snakemake.params.size), snakemake.output.csv)
