"""The models identified on each run of some records."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.descriptions import described
    from freerock.jobs.each_record import make_each
    from freerock.jobs.make_fits import give_up_fits, make_fits

    records = described(snakemake.params.records, snakemake.config["descriptions"])
    inputs = dict(zip(records, snakemake.input.records, strict=True))
    outputs = dict(zip(records, snakemake.output.fits, strict=True))
    make_each(
        list(records),
        lambda test: make_fits(records[test] | snakemake.params.shared, inputs[test], outputs[test]),
        lambda test, reason: give_up_fits(records[test], outputs[test], reason),
    )
