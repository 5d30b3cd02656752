"""Study: where each method converges and where it fails."""

from freerock.studies.stability import stability
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(stability(snakemake.params.size), snakemake.output.csv)
