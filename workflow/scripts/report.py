"""The report of a campaign, and what its products were made from."""

from pathlib import Path

from freerock.jobs.log import log_to
from freerock.jobs.make_report import make_report

log_to(snakemake.log[0])
inputs, params = snakemake.input, snakemake.params
make_report(
    {"campaign": params.campaign},
    {Path(pair[0]).stem: pair for pair in zip(inputs.records, inputs.fits, strict=True)},
    {Path(path).stem: path for path in inputs.tables},
    list(zip(inputs.captions, inputs.figures, strict=True)),
    {Path(page).stem.removeprefix("qc_"): page for page in inputs.pages},
    dict(snakemake.output.items()),
    products=[path for path in snakemake.input if path not in inputs.changes],
    changes=next(iter(inputs.changes), None),
)
