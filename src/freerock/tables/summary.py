"""What a campaign found, as numbers: tables 1 to 3.

The numbering is that of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024).
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from freerock.models.block import Block
from freerock.models.laws import LAWS, MODELS
from freerock.products.groups import usable_runs
from freerock.tables.candidates import single_runs

STATUSES = ["selected", "rejected"]  # of a model in the choice, which the tables mark
Published = Mapping[str, Any] | None  # values by block, foundation, model and quantity


def table1(
    records: Iterable[xr.DataTree],
    blocks: Mapping[str, Block],
    release_angles_deg: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """Block configurations with the release angle as measured.

    Parameters
    ----------
    records : iterable of xarray.DataTree
        Record datasets.
    blocks : mapping of str to freerock.models.block.Block
        The campaign's blocks by name.
    release_angles_deg : mapping of str to float, optional
        Nominal release angle of each block [degree].

    Returns
    -------
    pandas.DataFrame
        One row per block: height 2h and width 2b [m], slenderness h/b, mass [kg], nominal release angle,
        mean and standard deviation of the release angle |θ₀| over the usable runs [degree], their number.
    """
    held: dict[str, list[float]] = {name: [] for name in blocks}
    for tree in records:
        held[tree.attrs["block"]] += [
            abs(math.degrees(run["theta0"].item())) for run in usable_runs(tree).values()
        ]
    rows = [
        {
            "block": name,
            "height_m": block.height_m,
            "width_m": block.width_m,
            "slenderness": block.height_m / block.width_m,
            "mass_kg": block.mass_kg,
            "release_angle_nominal_deg": (release_angles_deg or {}).get(name, math.nan),
            "release_angle_deg": np.mean(held[name]) if held[name] else math.nan,
            "release_angle_std_deg": np.std(held[name], ddof=1) if len(held[name]) > 1 else math.nan,
            "n_runs": len(held[name]),
        }
        for name, block in blocks.items()
    ]
    return pd.DataFrame(rows)


def table2(
    parameters: pd.DataFrame, published: Published = None, choice: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Identified parameters of the laws, beside the published ones; without their rivals.

    Of all runs of a record jointly, or of each run of a record without a joint fit.

    Parameters
    ----------
    parameters : pandas.DataFrame
        Tidy table.
    published : mapping, optional
        Published values by block, foundation, model and quantity.
    choice : pandas.DataFrame, optional
        Tidy table.

    Returns
    -------
    pandas.DataFrame
        Columns test, run, block, foundation, model, parameter, unit, value, stderr, run_mean, run_scatter,
        published, success, selected and rejected (by the choice of most of the fitted runs); SI units. run
        is "pooled" for a joint fit, run_mean and run_scatter are mean and standard deviation of the fits of
        single runs beside it.
    """
    key = ["test", "model", "parameter"]
    single = parameters[(parameters["run"] != "pooled") & parameters["success"]]
    runs = single.groupby(key)["value"].agg(run_mean="mean", run_scatter="std")
    frame = _leading(parameters).join(runs, on=key)
    frame.loc[frame["run"].astype(str) != "pooled", ["run_mean", "run_scatter"]] = math.nan
    own = [row.parameter in MODELS[row.model] for row in frame.itertuples()]
    frame = frame[np.array(own, bool)].reset_index(drop=True)
    frame["published"] = [_published(published, row, row.parameter) for row in frame.itertuples()]
    columns = ["test", "run", "block", "foundation", "model", "parameter", "unit", "value", "stderr"]
    frame = frame.assign(**{status: _mostly(status, frame, choice) for status in STATUSES})
    return frame[[*columns, "run_mean", "run_scatter", "published", "success", *STATUSES]]


def table3(
    epsilon: pd.DataFrame, published: Published = None, choice: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Discrepancy ε_θ of the same fits as in `table2`, beside the published one, from the tidy table.

    Columns test, run, block, foundation, model, epsilon_theta, published (fractions), final_time_s, success,
    selected, rejected.
    """
    frame = _leading(epsilon).reset_index(drop=True)
    frame["published"] = [_published(published, row, "epsilon_theta") for row in frame.itertuples()]
    columns = ["test", "run", "block", "foundation", "model", "epsilon_theta", "published", "final_time_s"]
    frame = frame.assign(**{status: _mostly(status, frame, choice) for status in STATUSES})
    return frame[[*columns, "success", *STATUSES]]


def largest_shift_m(runs: pd.DataFrame, blocks: Mapping[str, Block]) -> float:
    """How far the base's centre moves at most when a block turns about a corner: b(1 − cos θ₀) [m].

    Parameters
    ----------
    runs : pandas.DataFrame
        Tidy table.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    """
    released = runs.dropna(subset=["theta0_deg"]).itertuples()
    shifts = (blocks[run.block].b * (1 - math.cos(math.radians(run.theta0_deg))) for run in released)
    return max(shifts, default=math.nan)


def _leading(fits: pd.DataFrame) -> pd.DataFrame:
    """Joint fits of the laws, and the fits of each run of a record that has no joint one."""
    joint = fits["run"].astype(str) == "pooled"
    return fits[fits["model"].isin(LAWS) & (joint | ~fits["test"].isin(fits.loc[joint, "test"]))]


def _mostly(status: str, fits: pd.DataFrame, choice: pd.DataFrame | None) -> list[bool]:
    """Whether the model of each fit has a status in its run; of a joint fit, in most runs of the record."""
    if choice is None or choice.empty:
        return [False] * len(fits)
    runs = single_runs(choice)
    found = runs[["test", "model"]].assign(run=runs["run"].astype(str), share=runs["status"] == status)
    of_run = found.groupby(["test", "run", "model"])["share"].mean().to_dict()
    of_record = found.groupby(["test", "model"])["share"].mean().to_dict()
    keys = fits[["test", "run", "model"]].astype(str).itertuples(index=False, name=None)
    return [
        (of_record.get((test, model), 0) if run == "pooled" else of_run.get((test, run, model), 0)) > 0.5
        for test, run, model in keys
    ]


def _published(published: Published, row: Any, name: str) -> float:
    found: Any = published
    for key in (row.block, row.foundation, row.model, name):
        found = (found or {}).get(key)
    return math.nan if found is None else float(found)
