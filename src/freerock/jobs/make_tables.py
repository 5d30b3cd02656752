"""The tables of a campaign as numbers: tidy ones, predictions, and tables 1 to 3."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from freerock.columns import columns_of
from freerock.models.block import Block
from freerock.populations.band import bands
from freerock.products.netcdf import open_record
from freerock.products.runs import motions_in
from freerock.runs.motion import Motion
from freerock.tables.campaign_tables import read_campaign
from freerock.tables.csvfile import write_csv
from freerock.tables.paper import summary_table, table1, table2, table3
from freerock.tables.populations import foundations_table
from freerock.tables.swings import measured_swings


def make_tables(
    settings: Mapping[str, Any],
    record_files: Sequence[str | Path],
    fit_files: Sequence[str | Path],
    folder: str | Path,
) -> None:
    """Write the tables of a campaign as CSV.

    Parameters
    ----------
    settings : mapping
        blocks, release_angles_deg (by block), published (values by block, foundation, model and quantity, or
        None), debonding: sections of the configuration as plain values.
    record_files, fit_files : sequence of path
        Datasets of all records, and of their fits.
    folder : path
        Where the tables are written.
    """
    records, estimates, tables = read_campaign(record_files, fit_files)
    blocks = {name: Block(**block) for name, block in settings["blocks"].items()}
    of_test = {Path(path).stem: each for path, each in zip(record_files, enumerate(records), strict=True)}

    def motions(test: str) -> Mapping[int, Motion]:
        i, record = of_test[test]
        return motions_in(record, open_record(record_files[i], only=("time", "theta")).dataset)

    selected = tables["choice"][tables["choice"]["status"] == "selected"]
    named = set(selected[["test", "run", "model"]].astype(str).itertuples(index=False, name=None))
    chosen = [each for each in estimates if (each.test, str(each.run), each.model) in named]
    tables["predictions"] = bands(
        chosen, motions, blocks, measured_swings(tables["restitution"]), settings["debonding"]
    )
    tables["foundations"] = foundations_table(tables["populations"])
    tables["summary"] = summary_table(tables)
    origin = ", ".join(tables["runs"]["origin"].unique())
    published = settings["published"]
    printed = {
        "table1": table1(records, blocks, settings["release_angles_deg"]),
        "table2": table2(tables["populations"], tables["paper"], tables["choice"], published),
        "table3": table3(tables["paper"], published),
    }
    tables |= {name: frame.assign(origin=origin) for name, frame in printed.items()}
    for name, frame in tables.items():
        write_csv(frame[columns_of(name)], Path(folder, f"{name}.csv"))
