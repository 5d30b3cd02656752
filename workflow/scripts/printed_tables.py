"""Tables of a campaign as they are printed, and the numbers of a paper's text."""

from pathlib import Path

from freerock.jobs.log import log_to
from freerock.jobs.print_tables import print_tables

log_to(snakemake.log[0])
params = snakemake.params
files = {Path(path).stem: path for path in snakemake.input.tables}
folder = Path(snakemake.output.numbers).parent
print_tables(files, folder, origin=params.origin, doi=params.doi, labels=params.labels)
