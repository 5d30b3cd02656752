"""A figure of a campaign."""

from importlib import import_module

from freerock.jobs.log import log_to
from freerock.jobs.make_figure import make_figure

log_to(snakemake.log[0])
figure = import_module(f"freerock.figures.{snakemake.wildcards.figure}")
stem = snakemake.output.pdf.removesuffix(".pdf")
make_figure(figure, dict(snakemake.input.items()), snakemake.params.settings, stem)
