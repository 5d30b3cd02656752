"""Table of a simulated campaign: identified values beside the true ones."""

from freerock.datasets import open_fits
from freerock.tables import SIMULATED_NOTE, parameters_table, recovered_table, recovered_text, write_table
from freerock.truth import read_truth
from freerock.workflow import log_to

log_to(snakemake.log[0])
truth = read_truth(snakemake.input.truth)
frame = recovered_table(parameters_table(map(open_fits, snakemake.input.fits)), truth)
write_table(
    snakemake.output.csv.removesuffix(".csv"),
    frame.assign(origin="simulated"),
    recovered_text(frame),
    caption="Identified values and those the records were simulated with",
    notes=[SIMULATED_NOTE],
)
