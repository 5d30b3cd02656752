"""Restitution of the fitted Housner model beside that of the impacts."""

import math
from collections.abc import Mapping

import pandas as pd

from freerock.columns import columns_of
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.tables.swings import usable_rows


def restitution_comparison(
    runs: pd.DataFrame, populations: pd.DataFrame, restitution: pd.DataFrame, blocks: Mapping[str, Block]
) -> pd.DataFrame:
    """Restitution of the fitted Housner model beside that of the impacts, and the time to the first impact.

    Parameters
    ----------
    runs, populations, restitution : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    pandas.DataFrame
        Columns of restitution_comparison.csv, one row per record with measured impacts: r_fitted and its
        standard error (mean of the runs), r_first, the mean r of the runs' first impacts, r_median, r_low and
        r_high, median and range of all impacts, first_impact_s, the mean time from release to the first
        impact, rigid_s, the mean time of a rigid block from the angles of the same releases [s], r_housner of
        a rigid block, r_fitted_u, the total uncertainty of r_fitted, r_first_u and r_median_u, at most those
        of r_first and r_median: that of a single impact, and the scatter between the runs over the root of
        their number.
    """
    rows = []
    runs = usable_rows(runs)
    measured = restitution[restitution["source"] == "experiment"].merge(runs[["test", "run"]])
    of_records = populations[(populations["level"] == "record") & (populations["parameter"] == "r")]
    for test, impacts in measured.groupby("test", sort=False):
        fitted = of_records[(of_records["test"] == test) & (of_records["model"] == "housner")]
        first = impacts[impacts["impact"] == 1]
        scene = impacts[["campaign", "test", "block", "foundation"]].iloc[0].to_dict()
        released = first["peak_before_deg"]
        rigid = _rigid_s(blocks[scene["block"]], released)
        rows.append(
            {
                **scene,
                "r_fitted": fitted["mean"].mean(),
                "r_fitted_stderr": fitted["stderr"].mean(),
                "r_first": first["r"].mean(),
                "r_median": impacts["r"].median(),
                "r_low": impacts["r"].min(),
                "r_high": impacts["r"].max(),
                "first_impact_s": first["time_s"].mean(),
                "rigid_s": sum(rigid) / len(rigid) if rigid else math.nan,
                "r_housner": blocks[scene["block"]].restitution_housner,
                "r_fitted_u": fitted["u_total"].mean(),
                "r_first_u": math.hypot(first["r_u"].mean(), _of_scatter(first["r"])),
                "r_median_u": math.hypot(
                    impacts["r_u"].median(), _of_scatter(impacts.groupby("run")["r"].median())
                ),
            }
        )
    return pd.DataFrame(rows, columns=columns_of("restitution_comparison"))


def _of_scatter(of_runs: pd.Series) -> float:
    """Standard error of the mean of values of the runs, by their scatter; 0 of one run, which shows none."""
    error = float(of_runs.sem())
    return error if math.isfinite(error) else 0.0


def _rigid_s(block: Block, theta0_deg: pd.Series) -> list[float]:
    """Time from release to the first impact of a rigid block, from each angle that does not overturn it."""
    return [
        float(housner_swings(block, 1.0, math.radians(abs(angle)), max_impacts=1).impact_time[0])
        for angle in theta0_deg
        if abs(angle) < math.degrees(block.theta_cr)
    ]
