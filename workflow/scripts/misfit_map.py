"""Misfit maps around the identified parameters."""

from freerock.jobs.log import log_to
from freerock.jobs.misfit import make_misfit_maps

log_to(snakemake.log[0])
params = snakemake.params
settings = {"blocks": params.blocks, "debonding": params.debonding}
make_misfit_maps(settings, snakemake.input.fits, params.scenes, snakemake.output.maps)
