"""Figure: valleys of the discrepancy around the identified parameters."""

from freerock.figures.style import save
from freerock.figures.valley import has_valley, valley
from freerock.jobs.log import log_to
from freerock.models.block import Block
from freerock.products.groups import one_of_each
from freerock.products.netcdf import open_fits

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
params = snakemake.params
fits = one_of_each(snakemake.input.fits, params.scenes, open_fits, has_valley)
blocks = {name: Block(**block) for name, block in params.blocks.items()}
drawn = valley(fits, blocks, params.labels, params.debonding, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), fits[0].attrs["origin"], target=target)
