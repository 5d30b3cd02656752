"""Quality control of a record, a page per run."""

from freerock.jobs.log import log_to, make_or_give_up
from freerock.jobs.make_quality import make_quality

log_to(snakemake.log[0])
files = snakemake.input.record, snakemake.input.fits, snakemake.output.pdf.removesuffix(".pdf")
make_or_give_up(
    lambda: make_quality(*files, snakemake.params.labels),
    lambda reason: make_quality(*files, snakemake.params.labels, reason),
)
