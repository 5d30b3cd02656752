"""Tables of a campaign as numbers: tidy ones for other programs, those of a paper."""

from pathlib import Path

from freerock.jobs.log import log_to
from freerock.jobs.make_tables import make_tables

log_to(snakemake.log[0])
inputs = snakemake.input
make_tables(snakemake.params, inputs.records, inputs.fits, Path(snakemake.output[0]).parent)
