"""The end of a campaign: fails, with a line for each record that has no usable run."""

from freerock.jobs.complete import complete
from freerock.jobs.ledger import at_work

with at_work(snakemake):
    complete(snakemake.wildcards.campaign, snakemake.input.runs, snakemake.output.complete)
