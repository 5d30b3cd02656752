"""Record files to θ(t), runs and impacts."""

from freerock.jobs.describe import described
from freerock.jobs.each import make_each
from freerock.jobs.log import log_to
from freerock.jobs.record import make_record
from freerock.products.netcdf import write_failure
from freerock.runs.verdict import Reason

log_to(snakemake.log[0])
records = described(snakemake.params.records, snakemake.config["descriptions"])
shared = snakemake.params.shared
outputs = dict(zip(records, snakemake.output.records, strict=True))


def make(test):
    make_record(records[test] | shared, outputs[test])


def give_up(test, reason):
    write_failure(outputs[test], Reason("fail", "not_processed", reason), records[test]["attributes"])


make_each(list(records), make, give_up)
