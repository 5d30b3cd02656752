"""Table of a simulated campaign: identified values beside the true ones."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.print_tables import print_recovered
    from freerock.virtual_lab.truth import read_truth

    inputs = snakemake.input
    print_recovered(inputs.parameters, read_truth(inputs.truth), snakemake.output.csv.removesuffix(".csv"))
