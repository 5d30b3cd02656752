"""The models identified on each run of some records."""

from freerock.jobs.describe import described
from freerock.jobs.each import make_each
from freerock.jobs.fit import make_fits
from freerock.jobs.log import log_to
from freerock.products.groups import NotFitted
from freerock.products.netcdf import write_fits
from freerock.runs.verdict import Reason

log_to(snakemake.log[0])
records = described(snakemake.params.records, snakemake.config["descriptions"])
shared = snakemake.params.shared
inputs = dict(zip(records, snakemake.input.records, strict=True))
outputs = dict(zip(records, snakemake.output.fits, strict=True))


def make(test):
    make_fits(records[test] | shared, inputs[test], outputs[test])


def give_up(test, reason):
    outcome = {"verdict": "fail", "reasons": [Reason("fail", "not_processed", reason)]}
    outcome["not_fitted"] = [NotFitted(None, reason)]
    write_fits(outputs[test], {}, {}, records[test]["attributes"] | outcome)


make_each(list(records), make, give_up)
