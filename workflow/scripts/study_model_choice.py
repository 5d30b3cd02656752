"""Study: what each model costs and reaches."""

from freerock.studies.speed_accuracy import model_choice
from freerock.tables import write_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
write_csv(model_choice(snakemake.params.size), snakemake.output.csv)
