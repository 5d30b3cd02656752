"""Tables of a campaign: tidy ones for other programs, printed ones for a paper."""

from pathlib import Path

from freerock.files import write_text
from freerock.identification.population import shared_foundation
from freerock.identification.predict import predictions
from freerock.jobs.log import log_to
from freerock.models.block import Block
from freerock.products.estimates import estimates_of
from freerock.products.netcdf import open_fits, open_record
from freerock.products.runs import motions_in
from freerock.tables.tidy import numbers_tex, printed_tables, tidy_tables, write_csv, write_table

log_to(snakemake.log[0])
inputs, params = snakemake.input, snakemake.params
records = [open_record(path, samples=False) for path in inputs.records]
fits = [open_fits(path, samples=False) for path in inputs.fits]
blocks = {name: Block(**block) for name, block in params.blocks.items()}
files = {Path(path).stem: path for path in inputs.records}
folder = Path(snakemake.output.tidy[0]).parent


def motions(test):
    return motions_in(open_record(files[test]))


tidy = tidy_tables(records, fits)
estimates = estimates_of(fits)
tidy["predictions"] = predictions(estimates, motions, blocks, params.debonding)
tidy["foundations"] = shared_foundation(estimates)
for name, frame in tidy.items():
    write_csv(frame, folder / f"{name}.csv")
printed = printed_tables(
    tidy,
    records,
    blocks,
    release_angles_deg=params.release_angles_deg,
    published=params.published,
    labels=params.labels,
)
for name, table in printed.items():
    write_table(folder / name, **table)
write_text(snakemake.output.numbers, numbers_tex(tidy))
