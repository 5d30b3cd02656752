"""Study: blocks that are not quite what the law says."""

from freerock.studies.identification import model_error
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(model_error(snakemake.params.size), snakemake.output.csv)
