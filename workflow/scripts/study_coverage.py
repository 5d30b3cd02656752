"""Study: scatter against the Cramér-Rao bound, and coverage of the intervals."""

from freerock.jobs.log import log_to
from freerock.studies.coverage import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
