"""Study: does the identification reach the global minimum?"""

from freerock.jobs.log import log_to
from freerock.studies.success import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
