"""Table of a simulated campaign: identified values beside the true ones."""

import json
from pathlib import Path

from freerock.datasets import open_fits
from freerock.models import MODELS
from freerock.tables import SIMULATED_NOTE, parameters_table, recovered_table, recovered_text, write_table
from freerock.workflow import log_to

log_to(snakemake.log[0])
records = json.loads(Path(snakemake.input.truth).read_text(encoding="utf-8"))
truth = {
    (test, number, parameter): run[parameter]
    for test, record in records.items()
    for number, run in enumerate(record["runs"], 1)
    for parameter in MODELS[record["model"]]
}
frame = recovered_table(parameters_table(map(open_fits, snakemake.input.fits)), truth)
write_table(
    snakemake.output.csv.removesuffix(".csv"),
    frame.assign(origin="simulated"),
    recovered_text(frame),
    caption="Identified values and those the records were simulated with",
    notes=[SIMULATED_NOTE],
)
