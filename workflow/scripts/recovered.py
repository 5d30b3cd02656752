"""Table of a simulated campaign: identified values beside the true ones."""

from freerock.jobs.log import log_to
from freerock.tables.tidy import SIMULATED_NOTE, read_csv, recovered_table, recovered_text, write_table
from freerock.virtual_lab.truth import read_truth

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
