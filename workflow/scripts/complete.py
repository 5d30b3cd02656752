"""The end of a campaign: fails, with a line for each record that has no usable run."""

from freerock.jobs.finish_campaign import complete
from freerock.jobs.log import log_to

log_to(snakemake.log[0])
complete(snakemake.wildcards.campaign, snakemake.input.runs, snakemake.output.complete)
