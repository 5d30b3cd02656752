"""Study: blocks that are not quite what the law says."""

from freerock.jobs.log import log_to
from freerock.studies.model_error import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
