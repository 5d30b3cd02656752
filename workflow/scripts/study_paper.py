"""Study: the published tables, re-identified."""

from freerock.jobs.log import log_to
from freerock.studies.paper import paper
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(paper(snakemake.params.size), snakemake.output.csv)
