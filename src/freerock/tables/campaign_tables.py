"""The tables of a campaign from the datasets of its records and of their fits."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from freerock.models.block import Block
from freerock.populations.band import bands
from freerock.populations.estimate import Estimate
from freerock.products.estimates import estimates_in
from freerock.products.netcdf import open_fits, open_record
from freerock.products.runs import motions_in
from freerock.runs.motion import Motion
from freerock.tables import tidy_tables as tidy
from freerock.tables.paper import summary_table, table1, table2, table3
from freerock.tables.populations import budget_table, foundations_table, means_in, populations_table
from freerock.tables.swings import measured_swings

AT_ONCE = 40  # records whose fits are in memory together


def campaign_tables(
    settings: Mapping[str, Any], record_files: Sequence[str | Path], fit_files: Sequence[str | Path]
) -> dict[str, pd.DataFrame]:
    """The tables of a campaign by name.

    Parameters
    ----------
    settings : mapping
        blocks, release_angles_deg (by block), published (values by block, foundation, model and quantity, or
        None), debonding: sections of the configuration as plain values.
    record_files, fit_files : sequence of path
        Datasets of all records, and of their fits.
    """
    records, estimates, tables = _read(record_files, fit_files)
    blocks = {name: Block(**block) for name, block in settings["blocks"].items()}
    of_test = {Path(path).stem: each for path, each in zip(record_files, enumerate(records), strict=True)}

    def motions(test: str) -> Mapping[int, Motion]:
        i, record = of_test[test]
        return motions_in(record, open_record(record_files[i], only=("time", "theta")).dataset)

    selected = tables["choice"][tables["choice"]["status"] == "selected"]
    named = set(selected[["test", "run", "model"]].astype(str).itertuples(index=False, name=None))
    chosen = [each for each in estimates if (each.test, str(each.run), each.model) in named]
    swings = measured_swings(tables["restitution"])
    tables["predictions"] = bands(chosen, motions, blocks, swings, settings["debonding"])
    tables["foundations"] = foundations_table(tables["populations"])
    tables["summary"] = summary_table(tables)
    origin = ", ".join(tables["runs"]["origin"].unique())
    published = settings["published"]
    printed = {
        "table1": table1(records, blocks, settings["release_angles_deg"]),
        "table2": table2(tables["populations"], tables["paper"], tables["choice"], published),
        "table3": table3(tables["paper"], published),
    }
    return tables | {name: frame.assign(origin=origin) for name, frame in printed.items()}


def _read(
    record_files: Sequence[str | Path], fit_files: Sequence[str | Path]
) -> tuple[list[xr.DataTree], list[Estimate], dict[str, pd.DataFrame]]:
    """Records without samples, usable fits and the tidy tables by name."""
    records: list[xr.DataTree] = []
    estimates: list[Estimate] = []
    parts = []
    for start in range(0, max(len(record_files), 1), AT_ONCE):
        some = slice(start, start + AT_ONCE)
        measured = [open_record(path, samples=False) for path in record_files[some]]
        fits = [open_fits(path, samples=False) for path in fit_files[some]]
        parts.append(rows_of(measured, fits))
        records += measured
        estimates += estimates_in(fits)
    return records, estimates, joined(parts)


def rows_of(records: Sequence[xr.DataTree], fits: Sequence[xr.DataTree]) -> dict[str, pd.DataFrame]:
    """What some records of a campaign add to its tidy tables.

    Parameters
    ----------
    records, fits : sequence of xarray.DataTree
        Record and fit datasets.

    Returns
    -------
    dict of str to pandas.DataFrame
        runs, reasons, parameters, contributions, pulls, epsilon, paper, choice and
        restitution.
    """
    return {
        "runs": tidy.runs_table(records, fits),
        "reasons": tidy.reasons_table(records, fits),
        "parameters": tidy.parameters_table(fits),
        "contributions": tidy.contributions_table(fits),
        "pulls": tidy.pulls_table(fits),
        "epsilon": tidy.epsilon_table(fits),
        "paper": tidy.paper_table(fits),
        "choice": tidy.choice_table(fits),
        "restitution": tidy.restitution_table(records, fits),
    }


def joined(parts: Sequence[Mapping[str, pd.DataFrame]]) -> dict[str, pd.DataFrame]:
    """The tidy tables of a campaign by name, contributions as those of its budget.

    Parameters
    ----------
    parts : sequence of mapping of str to pandas.DataFrame
        At least one, as `rows_of` gives them; a record with its fits is in one of them.
    """
    tables = {}
    for name, first in parts[0].items():
        filled = [part[name] for part in parts if len(part[name])]
        tables[name] = pd.concat(filled, ignore_index=True) if filled else first
    contributions = tables.pop("contributions")
    means = means_in(tables["parameters"], contributions)
    tables["populations"] = populations_table(means)
    tables["budget"] = budget_table(means, contributions)
    return tables
