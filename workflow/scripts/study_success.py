"""Study: does the identification reach the global minimum?"""

from freerock.jobs.log import log_to
from freerock.studies.identification import success
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(success(snakemake.params.size), snakemake.output.csv)
