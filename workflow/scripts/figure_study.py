"""Figure of a study."""

from importlib import import_module

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__, f"freerock_bench.figures.{snakemake.params.figure}"):
    from freerock.figures.style import save
    from freerock.tables.csvfile import read_csv

    figure = import_module(f"freerock_bench.figures.{snakemake.params.figure}")
    drawn = figure.draw(read_csv(snakemake.input.csv), *snakemake.params.get("page", []))
    save(*drawn, snakemake.output.pdf.removesuffix(".pdf"))
