"""Figure of a study."""

from importlib import import_module

from freerock.figures.style import save
from freerock.jobs.ledger import at_work
from freerock.tables.csvfile import read_csv

with at_work(snakemake):
    figure = import_module(f"freerock.figures.studies.{snakemake.wildcards.study}")
    save(*figure.draw(read_csv(snakemake.input.csv)), snakemake.output.pdf.removesuffix(".pdf"))
