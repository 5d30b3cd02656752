"""Figure: restitution of each impact."""

from freerock.datasets import open_fits, open_record
from freerock.figures.restitution import restitution
from freerock.figures.style import save
from freerock.models.block import Block
from freerock.workflow import log_to

log_to(snakemake.log[0])
records = [open_record(path) for path in snakemake.input.records]
fits = [open_fits(path) for path in snakemake.input.fits]
blocks = {name: Block(**block) for name, block in snakemake.params.blocks.items()}
drawn = restitution(records, fits, blocks, snakemake.params.labels)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), records[0].attrs["origin"])
