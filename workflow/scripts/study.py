"""A study of the methods."""

from importlib import import_module

from freerock.jobs.log import log_to
from freerock.tables.csvfile import write_csv

if __name__ != "__mp_main__":  # the processes of a study import the script that started them
    log_to(snakemake.log[0])
    study = import_module(f"freerock_bench.{snakemake.wildcards.study}")
    write_csv(study.run(snakemake.params.size), snakemake.output.csv)
