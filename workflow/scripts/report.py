"""The report of a campaign and its provenance."""

from freerock.datasets import open_fits, open_record, provenance, write_json
from freerock.models.block import Block
from freerock.report import write_report
from freerock.tables import printed_tables, tidy_tables
from freerock.workflow import log_to

log_to(snakemake.log[0])
inputs, params = snakemake.input, snakemake.params
records = [open_record(path) for path in inputs.records]
fits = [open_fits(path) for path in inputs.fits]
blocks = {name: Block(**block) for name, block in params.blocks.items()}
tidy = tidy_tables(records, fits)
printed = printed_tables(
    tidy,
    records,
    blocks,
    release_angles_deg=params.release_angles_deg,
    published=params.published,
    labels=params.labels,
)
figures = [
    ("Effect of the foundation on the measured rotation", inputs.foundation_effect),
    *(("Measured rotation and the models fitted to it", path) for path in inputs.models),
    ("Restitution of each impact", inputs.restitution),
    ("Valleys of the discrepancy around the identified parameters", inputs.valley),
]
made_by = provenance(inputs.raw, params.campaign)
write_json(snakemake.output.provenance, made_by)
write_report(
    snakemake.output.html,
    title=params.campaign["title"],
    summary=params.campaign["summary"],
    origin=params.campaign["origin"],
    **tidy,
    fits=fits,
    blocks=blocks,
    tables=[(table["caption"], table["text"], table["notes"]) for table in printed.values()],
    figures=figures,
    pages=dict(zip((record.attrs["test"] for record in records), inputs.pages, strict=True)),
    labels=params.labels,
    debonding=params.campaign["fits"]["debonding"],
    provenance=made_by,
)
