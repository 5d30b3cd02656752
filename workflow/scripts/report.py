"""The report of a campaign and its provenance."""

from pathlib import Path

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.make_report import make_report

    inputs, params = snakemake.input, snakemake.params
    pairs = zip(inputs.records, inputs.fits, strict=True)
    make_report(
        {"campaign": params.campaign, "blocks": params.blocks},
        {Path(record).stem: (record, fits) for record, fits in pairs},
        {Path(path).stem: path for path in inputs.tables},
        list(zip(inputs.captions, inputs.figures, strict=True)),
        {Path(page).stem.removeprefix("qc_"): page for page in inputs.pages},
        dict(snakemake.output.items()),
        next(iter(inputs.changes), None),
    )
