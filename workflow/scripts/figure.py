"""A figure of a campaign."""

from importlib import import_module

from freerock.jobs.ledger import at_work

with at_work(snakemake):
    from freerock.jobs.figure import make_figure

    figure = import_module(f"freerock.figures.{snakemake.params.module}")
    target = snakemake.wildcards.get("target", "double_column")
    stem = snakemake.output.pdf.removesuffix(".pdf")
    make_figure(figure, dict(snakemake.input.items()), snakemake.params.settings, stem, target)
