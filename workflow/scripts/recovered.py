"""Table of a simulated campaign: identified values beside the true ones."""

from freerock.jobs.log import log_to
from freerock.jobs.print_tables import print_recovered
from freerock.virtual_lab.truth import read_truth

log_to(snakemake.log[0])
inputs = snakemake.input
print_recovered(inputs.parameters, read_truth(inputs.truth), snakemake.output.csv.removesuffix(".csv"))
