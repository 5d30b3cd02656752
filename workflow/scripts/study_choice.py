"""Study: does the choice of model name the true law?"""

from freerock.jobs.log import log_to
from freerock.studies.choice import run
from freerock.tables.csvfile import write_csv

log_to(snakemake.log[0])
write_csv(run(snakemake.params.size), snakemake.output.csv)
