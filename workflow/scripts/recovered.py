"""Table of a simulated campaign: identified values beside the true ones."""

from freerock.tables import SIMULATED_NOTE, read_csv, recovered_table, recovered_text, write_table
from freerock.truth import read_truth
from freerock.workflow import log_to

log_to(snakemake.log[0])
truth = read_truth(snakemake.input.truth)
frame = recovered_table(read_csv(snakemake.input.parameters), truth)
write_table(
    snakemake.output.csv.removesuffix(".csv"),
    frame.assign(origin="simulated"),
    recovered_text(frame),
    caption="Identified values and those the records were simulated with",
    notes=[SIMULATED_NOTE],
)
