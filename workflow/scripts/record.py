"""Record files to θ(t), runs and impacts."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.descriptions import described
    from freerock.jobs.each_record import make_each
    from freerock.jobs.make_record import give_up_record, make_record

    records = described(snakemake.params.records, snakemake.config["descriptions"])
    outputs = dict(zip(records, snakemake.output.records, strict=True))
    make_each(
        list(records),
        lambda test: make_record(records[test] | snakemake.params.shared, outputs[test]),
        lambda test, reason: give_up_record(records[test], outputs[test], reason),
    )
