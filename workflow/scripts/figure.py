"""A figure of a campaign."""

from importlib import import_module

from freerock.jobs.figure import make_figure
from freerock.jobs.log import log_to

log_to(snakemake.log[0])
figure = import_module(f"freerock.figures.{snakemake.params.module}")
target = snakemake.wildcards.get("target", "double_column")
stem = snakemake.output.pdf.removesuffix(".pdf")
make_figure(figure, dict(snakemake.input.items()), snakemake.params.settings, stem, target)
