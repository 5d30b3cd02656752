"""Quality control of one record, a page per run."""

from freerock.datasets import open_fits, open_record
from freerock.figures.qc import qc
from freerock.figures.style import save
from freerock.workflow import log_to

log_to(snakemake.log[0])
record, fits = open_record(snakemake.input.record), open_fits(snakemake.input.fits)
drawn = qc(record, fits, snakemake.params.labels)
save(*drawn, snakemake.output.pdf.removesuffix(".pdf"), record.attrs["origin"])
