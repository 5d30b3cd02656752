"""A figure of a campaign."""

from importlib import import_module

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__, f"freerock.figures.{snakemake.params.module}"):
    from freerock.jobs.figure import make_figure

    figure = import_module(f"freerock.figures.{snakemake.params.module}")
    target = snakemake.wildcards.get("target", "double_column")
    stem = snakemake.output.pdf.removesuffix(".pdf")
    files = {name: each for name, each in snakemake.input.items() if name != "again"}
    make_figure(figure, files, snakemake.params.settings, stem, target)
