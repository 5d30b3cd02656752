"""Figure of a study."""

from freerock.figures.studies import (
    choice,
    coverage,
    faults,
    model_choice,
    model_error,
    paper,
    speed_accuracy,
    stability,
    success,
)
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.tables.csvfile import read_csv

log_to(snakemake.log[0])
modules = choice, coverage, faults, model_choice, model_error, paper, speed_accuracy, stability, success
draw = {module.__name__.rpartition(".")[2]: module.draw for module in modules}[snakemake.wildcards.study]
save(*draw(read_csv(snakemake.input.csv)), snakemake.output.pdf.removesuffix(".pdf"))
