"""Study: the published tables, re-identified."""

from freerock.studies.paper import paper
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(paper(snakemake.params.size), snakemake.output.csv)
