"""Tables of a campaign as numbers: tidy ones for other programs, those of a paper."""

from pathlib import Path

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.make_tables import make_tables

    inputs = snakemake.input
    make_tables(snakemake.params, inputs.records, inputs.fits, Path(snakemake.output[0]).parent)
