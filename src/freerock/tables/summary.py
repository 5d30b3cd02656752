"""What a campaign found, as numbers: tables 1 to 3, and recovered values.

The numbering is that of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024).
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, LAWS
from freerock.products.groups import usable_runs

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
        One row per block: height 2h and width 2b [m], slenderness h/b, mass [kg], nominal release angle α,
        mean and standard deviation of the release angle |θ₀| over the usable runs [degree], their number,
        critical angle θ_cr [degree], R [m], frequency parameter p [rad/s], Housner's r.
    """
    held: dict[str, list[float]] = {name: [] for name in blocks}
    for tree in records:
        angles = (run["theta0"].item() for run in usable_runs(tree).values())
        held[tree.attrs["block"]] += [abs(math.degrees(angle)) for angle in angles]
    rows = [
        {
            "block": name,
            "height_m": block.height_m,
            "width_m": block.width_m,
            "slenderness": block.height_m / block.width_m,
            "mass_kg": block.mass_kg,
            "alpha_nominal_deg": (release_angles_deg or {}).get(name, math.nan),
            "alpha_deg": np.mean(held[name]) if held[name] else math.nan,
            "alpha_std_deg": np.std(held[name], ddof=1) if len(held[name]) > 1 else math.nan,
            "n_runs": len(held[name]),
            "theta_cr_deg": math.degrees(block.theta_cr),
            "R_m": block.R,
            "p_rad_s": block.p,
            "r_housner": block.restitution_housner,
        }
        for name, block in blocks.items()
    ]
    return pd.DataFrame(rows)


def table2(
    populations: pd.DataFrame,
    parameters: pd.DataFrame,
    published: Published = None,
    choice: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Identified parameters, record by record, beside the published ones.

    The rows of a record are those of the laws, and of the candidate that most of its runs name.

    Parameters
    ----------
    populations, parameters : pandas.DataFrame
        Tidy tables.
    published : mapping, optional
        Published values by block, foundation, model and quantity.
    choice : pandas.DataFrame, optional
        Tidy table.

    Returns
    -------
    pandas.DataFrame
        Columns test, block, foundation, model, parameter, unit, n_runs, mean, stderr, u_total, tau,
        tau_high, next_low, next_high, scatter_p (as in populations), published, given (of fits that may be
        used; "undetermined" where no run of the mean determines the parameter: n_runs then counts all fits
        that may be used), in_phase (the mean of the runs), success, selected and rejected (by the choice of
        most of the fitted runs); SI units. A law of which no fit may be used has n_runs 0 and the mean of
        what these gave.
    """
    of_model = [row.parameter in CANDIDATES[row.model].parameters for row in parameters.itertuples()]
    of_laws = parameters[_shown(parameters, choice) & np.array(of_model, bool)]
    named = ["test", "block", "foundation", "model", "parameter", "unit"]
    of_records = populations[populations["level"] == "record"]
    numbers = ["n_runs", "mean", "stderr", "u_total", "tau", "tau_high", "next_low", "next_high", "scatter_p"]
    given = of_laws["given"].where(of_laws["success"], "").fillna("")
    unknown = given == "undetermined"
    of_laws = of_laws.assign(given=given.mask(unknown, ""), unknown=unknown)
    every = of_laws.groupby(named, sort=False, as_index=False).agg(
        failed=("value", "mean"),
        in_phase=("in_phase", "mean"),
        given=("given", "max"),
        unknown=("unknown", "any"),
        used=("success", "sum"),
    )
    frame = every.merge(of_records[[*named, *numbers]], on=named, how="left")
    frame["success"] = frame["mean"].notna()
    frame["mean"] = frame["mean"].fillna(frame.pop("failed"))
    frame["n_runs"] = frame["n_runs"].fillna(0)
    determined = frame["n_runs"] > 0
    frame["given"] = frame["given"].mask(~determined & frame.pop("unknown"), "undetermined")
    frame["n_runs"] = frame["n_runs"].where(determined, frame.pop("used"))
    frame["published"] = [_published(published, row, row.parameter) for row in frame.itertuples()]
    frame = frame.assign(**{status: _mostly(status, frame, choice) for status in STATUSES})
    return frame[[*named, *numbers, "published", "given", "in_phase", "success", *STATUSES]]


def table3(
    epsilon: pd.DataFrame, published: Published = None, choice: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Discrepancy ε_θ, record by record, beside the published one, from the tidy table.

    Rows are those of the laws, and of the candidate that most runs of a record name. Columns test, block,
    foundation, model, n_runs, epsilon_theta (median of the runs, each under its own parameters), epsilon_low,
    epsilon_high (their range), published (fractions), final_time_s (the longest), in_phase (median of
    epsilon_in_phase), success, selected, rejected. A law of which no fit may be used has n_runs 0 and the
    numbers of those.
    """
    of_laws = epsilon[_shown(epsilon, choice)]
    named = ["test", "block", "foundation", "model"]
    any_use = of_laws.groupby(named, sort=False)["success"].transform("any")
    used = of_laws[of_laws["success"] | ~any_use]
    frame = used.groupby(named, sort=False, as_index=False).agg(
        n_runs=("success", "sum"),
        epsilon_theta=("epsilon_theta", "median"),
        epsilon_low=("epsilon_theta", "min"),
        epsilon_high=("epsilon_theta", "max"),
        final_time_s=("final_time_s", "max"),
        in_phase=("epsilon_in_phase", "median"),
    )
    frame = of_laws[named].drop_duplicates().merge(frame)  # in the order of the laws, whichever runs failed
    frame["success"] = frame["n_runs"] > 0
    frame["published"] = [_published(published, row, "epsilon_theta") for row in frame.itertuples()]
    frame = frame.assign(**{status: _mostly(status, frame, choice) for status in STATUSES})
    numbers = ["n_runs", "epsilon_theta", "epsilon_low", "epsilon_high", "published", "final_time_s"]
    return frame[[*named, *numbers, "in_phase", "success", *STATUSES]]


def recovered_table(
    parameters: pd.DataFrame, truth: Mapping[tuple[str, int, str, str], float]
) -> pd.DataFrame:
    """Values identified in a simulated campaign beside those it was simulated with.

    Parameters
    ----------
    parameters : pandas.DataFrame
        Tidy table.
    truth : mapping of (str, int, str, str) to float
        True value by test, run, model and parameter, SI units; other models are left out.

    Returns
    -------
    pandas.DataFrame
        Columns test, run, parameter, unit, truth, value, ci95_low, ci95_high, u_total, error_percent, inside
        (the truth lies in the 95 % interval by noise), inside_total (it lies within 1.96 u_total).
    """
    keys = parameters[["test", "run", "model", "parameter"]].astype(str).itertuples(index=False, name=None)
    known = {(test, str(run), model, name): value for (test, run, model, name), value in truth.items()}
    true = pd.Series([known.get(key, math.nan) for key in keys], parameters.index, float)
    frame = parameters[true.notna()].assign(
        truth=true,
        error_percent=100 * (parameters["value"] / true - 1),
        inside=(parameters["ci95_low"] <= true) & (true <= parameters["ci95_high"]),
        inside_total=(parameters["value"] - true).abs() <= NORMAL_95 * parameters["u_total"],
    )
    columns = ["test", "run", "parameter", "unit", "truth", "value", "ci95_low", "ci95_high", "u_total"]
    return frame[[*columns, "error_percent", "inside", "inside_total"]].reset_index(drop=True)


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


def _shown(rows: pd.DataFrame, choice: pd.DataFrame | None) -> "pd.Series[bool]":
    """Whether a row is of a law, or of the candidate that most runs of its record name."""
    return rows["model"].isin(LAWS) | np.array(_mostly("selected", rows, choice), bool)


def _mostly(status: str, rows: pd.DataFrame, choice: pd.DataFrame | None) -> list[bool]:
    """Whether the law of each row has a status in most runs of its record."""
    if choice is None or choice.empty:
        return [False] * len(rows)
    share = (choice["status"] == status).groupby([choice["test"], choice["model"]]).mean().to_dict()
    return [share.get((row.test, row.model), 0.0) > 0.5 for row in rows.itertuples()]


def _published(published: Published, row: Any, name: str) -> float:
    found: Any = published
    for key in (row.block, row.foundation, row.model, name):
        found = (found or {}).get(key)
    return math.nan if found is None else float(found)
