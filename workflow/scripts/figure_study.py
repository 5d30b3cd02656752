"""Figure of a study."""

from importlib import import_module

from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.tables.csvfile import read_csv

log_to(snakemake.log[0])
figure = import_module(f"freerock.figures.studies.{snakemake.wildcards.study}")
save(*figure.draw(read_csv(snakemake.input.csv)), snakemake.output.pdf.removesuffix(".pdf"))
