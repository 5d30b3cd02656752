"""The report of a campaign and its provenance."""

from pathlib import Path

from freerock.files import write_json
from freerock.jobs.log import log_to
from freerock.models.block import Block
from freerock.products.netcdf import open_fits, open_record
from freerock.products.provenance import inputs_of, provenance
from freerock.report.page import write_report
from freerock.tables.tidy import read_csv

log_to(snakemake.log[0])
inputs, params = snakemake.input, snakemake.params
sections = params.campaign["blocks"]
models = [(sections[Path(path).stem.removeprefix("models_")]["label"], path) for path in inputs.models]
figures = [
    ("Effect of the foundation on the measured rotation", inputs.foundation_effect),
    *((f"Measured rotation of {block} and the models fitted to it", path) for block, path in models),
    ("Restitution of each impact", inputs.restitution),
    ("Misfit maps around the identified parameters", inputs.misfit_map),
    ("Discrepancy with parameters of the run itself, of other runs, and of other blocks", inputs.predictions),
]
records, fits = ({Path(path).stem: path for path in paths} for paths in (inputs.records, inputs.fits))


def opened(test, samples):
    return open_record(records[test]), open_fits(fits[test], samples)


raw = {}
for path in inputs.records:
    raw |= inputs_of(open_record(path, samples=False))
made_by = provenance([], params.campaign) | {"inputs": raw}
write_json(snakemake.output.provenance, made_by)
write_report(
    snakemake.output.html,
    provenance=made_by,
    tables={Path(path).stem: read_csv(path) for path in inputs.tables},
    blocks={name: Block(**block) for name, block in params.blocks.items()},
    opened=opened,
    figures=figures,
    pages={Path(page).stem.removeprefix("qc_"): page for page in inputs.pages},
)
