"""Figure: the effect of the foundation on each block."""

from freerock.figures.foundation_effect import draw
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.products.groups import one_of_each, usable_runs
from freerock.products.netcdf import open_record

log_to(snakemake.log[0])
target = snakemake.wildcards.get("target", "double_column")
records = one_of_each(snakemake.input.records, snakemake.params.scenes, open_record, usable_runs)
origin = records[0].attrs["origin"]
drawn = draw(records, origin, snakemake.params.labels, target=target)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), origin, target=target)
