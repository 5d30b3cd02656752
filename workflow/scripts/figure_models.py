"""Figure: measured against modelled rotation of one block."""

from freerock.figures.models import draw
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.products.groups import one_of_each, runs_of
from freerock.products.netcdf import open_fits

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
fits = one_of_each(snakemake.input.fits, snakemake.params.scenes, open_fits, runs_of)
origin = fits[0].attrs["origin"]
drawn = draw(fits, origin, snakemake.params.labels, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), origin, target=target)
