"""Figure of a study, or a page of one."""

from importlib import import_module
from pathlib import Path

from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.tables.csvfile import read_csv

log_to(snakemake.log[0])
name = Path(snakemake.input.csv).stem
figure = import_module(f"freerock_bench.figures.{name}")
drawn = figure.draw(read_csv(snakemake.input.csv), *snakemake.params.page)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"))
