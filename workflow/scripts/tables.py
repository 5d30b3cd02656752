"""Tables of a campaign: tidy ones for other programs, printed ones for a paper."""

from pathlib import Path

from freerock.datasets import open_fits, open_record
from freerock.models.block import Block
from freerock.predict import predictions, shared_foundation
from freerock.tables import printed_tables, tidy_tables, write_csv, write_table
from freerock.workflow import log_to

log_to(snakemake.log[0])
options, folder = dict(snakemake.params.items()), Path(snakemake.output.tidy[0]).parent
records = [open_record(path) for path in snakemake.input.records]
fits = [open_fits(path) for path in snakemake.input.fits]
options["blocks"] = {name: Block(**block) for name, block in options["blocks"].items()}

tidy = tidy_tables(records, fits)
tidy["predictions"] = predictions(fits, options["blocks"], options.pop("debonding"))
tidy["foundations"] = shared_foundation(fits)
for name, frame in tidy.items():
    write_csv(frame, folder / f"{name}.csv")
for name, table in printed_tables(tidy, records, **options).items():
    write_table(folder / name, **table)
