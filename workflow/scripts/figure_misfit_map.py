"""Figure: misfit maps around the identified parameters."""

from freerock.figures.misfit_map import draw, has_map
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.models.block import Block
from freerock.products.groups import one_of_each
from freerock.products.netcdf import open_fits

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
params = snakemake.params
fits = one_of_each(snakemake.input.fits, params.scenes, open_fits, has_map)
blocks = {name: Block(**block) for name, block in params.blocks.items()}
origin = fits[0].attrs["origin"]
drawn = draw(fits, blocks, origin, params.labels, params.debonding, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), origin, target=target)
