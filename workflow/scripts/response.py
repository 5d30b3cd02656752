"""Responses of the identified laws of a campaign to some ground motions."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.make_responses import make_batch

    inputs, params = snakemake.input, snakemake.params
    tables = {"choice": inputs.choice, "populations": inputs.populations}
    settings = {"blocks": params.blocks, "debonding": params.debonding, **params.ensemble}
    make_batch(settings, tables, inputs.motions, snakemake.output.responses)
