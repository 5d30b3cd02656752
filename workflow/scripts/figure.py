"""Figures of a campaign."""

from importlib import import_module

from freerock.jobs.ledger import at_work

modules = [f"freerock.figures.{name}" for name in snakemake.params.figures]
with at_work(snakemake, __file__, *modules):
    from freerock.jobs.make_figures import make_figures

    files = {name: each for name, each in snakemake.input.items() if name != "again"}
    folder = snakemake.output[0].rpartition("/")[0]
    make_figures(map(import_module, modules), files, snakemake.params.figures, folder)
