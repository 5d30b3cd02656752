"""The figures of a campaign."""

from pathlib import Path

from freerock.jobs.log import log_to
from freerock.jobs.make_figures import make_figures

log_to(snakemake.log[0])
inputs = snakemake.input
folder = Path(snakemake.output[0]).parent
make_figures(snakemake.params.settings, inputs.records, inputs.fits, inputs.tables, folder)
