"""Figure of a study."""

from freerock.figures import paper, studies
from freerock.figures.style import save
from freerock.tables import read_csv
from freerock.workflow import log_to

log_to(snakemake.log[0])
study = snakemake.wildcards.study
draw = getattr(paper if study == "paper" else studies, study)
save(*draw(read_csv(snakemake.input.csv)), snakemake.output.pdf.removesuffix(".pdf"))
