"""Figure: restitution of each impact."""

from freerock.figures.restitution import draw
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
inputs = snakemake.input
runs, impacts, epsilon = map(read_csv, (inputs.runs, inputs.restitution, inputs.epsilon))
blocks = {name: Block(**block) for name, block in snakemake.params.blocks.items()}
origin = runs["origin"].iloc[0]
drawn = draw(runs, impacts, epsilon, blocks, origin, snakemake.params.labels, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), origin, target=target)
