"""Figure of a study."""

from freerock.figures import faults, identification, paper, studies
from freerock.figures.style import save
from freerock.jobs.log import log_to
from freerock.tables.tidy import read_csv

log_to(snakemake.log[0])
study = snakemake.wildcards.study
modules = (studies, paper, identification, faults)
draw = next(getattr(module, study) for module in modules if hasattr(module, study))
save(*draw(read_csv(snakemake.input.csv)), snakemake.output.pdf.removesuffix(".pdf"))
