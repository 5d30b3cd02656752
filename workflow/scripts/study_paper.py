"""Study: the published tables, re-identified."""

from freerock.jobs.log import log_to
from freerock.studies.paper import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
