"""Study: how surely each fault of a signal is named."""

from freerock.studies.faults import faults
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(faults(snakemake.params.size), snakemake.output.csv)
