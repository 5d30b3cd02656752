"""Study: time of a run against its error, every method."""

from freerock.studies.speed_accuracy import speed_accuracy
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(speed_accuracy(snakemake.params.size), snakemake.output.csv)
