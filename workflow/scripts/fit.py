"""The models identified on each run of a record."""

from freerock.jobs.descriptions import described
from freerock.jobs.log import log_to, make_or_give_up
from freerock.jobs.make_fits import give_up_fits, make_fits

log_to(snakemake.log[0])
settings = described(snakemake.params.settings, snakemake.config["descriptions"])
output = snakemake.output.fits
make_or_give_up(
    lambda: make_fits(settings, snakemake.input.record, output),
    lambda reason: give_up_fits(settings, output, reason),
)
