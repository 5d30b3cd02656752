"""Figure: how well other runs and blocks predict a run."""

from freerock.figures.predictions import draw
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.tables.csvfile import read_csv

log_to(snakemake.log[0])
target, params = snakemake.wildcards.get("target", "double_column"), snakemake.params
tables = map(read_csv, (snakemake.input.predictions, snakemake.input.epsilon))
drawn = draw(*tables, params.origin, params.labels, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), params.origin, target=target)
