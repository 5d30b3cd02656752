"""Study: does the choice of model name the true law?"""

from freerock.studies.identification import choice
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(choice(snakemake.params.size), snakemake.output.csv)
