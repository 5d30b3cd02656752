"""Probability of overturning from the responses of a campaign."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.make_responses import make_fragility

    make_fragility(snakemake.input.responses, snakemake.params.records, snakemake.output.curves)
