"""A record file to θ(t), runs and impacts."""

from freerock.jobs.descriptions import described
from freerock.jobs.log import log_to, make_or_give_up
from freerock.jobs.make_record import give_up_record, make_record

log_to(snakemake.log[0])
settings = described(snakemake.params.settings, snakemake.config["descriptions"])
output = snakemake.output.record
make_or_give_up(
    lambda: make_record(settings, output),
    lambda reason: give_up_record(settings, output, reason),
)
