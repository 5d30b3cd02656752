"""Study: does the identification reach the global minimum?"""

from freerock.studies.identification import success
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(success(snakemake.params.size), snakemake.output.csv)
