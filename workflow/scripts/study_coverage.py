"""Study: scatter against the Cramér-Rao bound, and coverage of the intervals."""

from freerock.studies.identification import coverage
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(coverage(snakemake.params.size), snakemake.output.csv)
