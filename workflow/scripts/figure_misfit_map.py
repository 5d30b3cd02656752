"""Figure: misfit maps around the identified parameters."""

from freerock.figures.misfit_map import draw
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.products.misfit_maps import open_misfit_maps

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
maps, origin = open_misfit_maps(snakemake.input.maps)
drawn = draw(maps, origin, snakemake.params.labels, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), origin, target=target)
