"""A figure of a campaign, with its caption and the numbers that it shows."""

from importlib import import_module
from pathlib import Path

from freerock.jobs.log import log_to
from freerock.jobs.make_figure import make_figure

log_to(snakemake.log[0])
figure = import_module(f"freerock.figures.{snakemake.wildcards.figure}")
files = {kind: snakemake.input.get(kind, []) for kind in ("records", "fits", "tables")}
make_figure(figure, snakemake.params.settings, files, Path(snakemake.output.png).with_suffix(""))
