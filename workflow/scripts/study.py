"""A study of the methods."""

from importlib import import_module

from freerock.jobs.ledger import at_work

if __name__ != "__mp_main__":  # the processes of a study import the script that started them
    with at_work(snakemake, __file__, f"freerock_bench.{snakemake.wildcards.study}"):
        from freerock.tables.csvfile import write_csv

        study = import_module(f"freerock_bench.{snakemake.wildcards.study}")
        write_csv(study.run(snakemake.params.size), snakemake.output.csv)
