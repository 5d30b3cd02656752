"""Misfit maps around the identified parameters."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.make_misfit_maps import make_misfit_maps

    params = snakemake.params
    settings = {"blocks": params.blocks, "debonding": params.debonding}
    make_misfit_maps(settings, snakemake.input.fits, params.scenes, snakemake.output.maps)
