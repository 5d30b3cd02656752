"""The end of a campaign: fails, with a line for each record that has no usable run."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.finish_campaign import complete

    complete(snakemake.wildcards.campaign, snakemake.input.runs, snakemake.output.complete)
