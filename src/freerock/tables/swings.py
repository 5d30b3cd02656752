"""Swings of a block between its impacts, from the table restitution: amplitude and period."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.models.block import Block

GAP = 1.25  # times the period before, above which an impact between was not seen: periods fall with amplitude
FIT = ["test", "run", "source"]


def swings(
    runs: pd.DataFrame, restitution: pd.DataFrame, epsilon: pd.DataFrame, blocks: Mapping[str, Block]
) -> pd.DataFrame:
    """What happens between the impacts of runs and of the laws fitted to them.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables; failed and excluded runs are left out, and laws whose fit failed.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    pandas.DataFrame
        The columns of restitution, and amplitude, the peak before the impact over the critical angle, and
        period_s, twice the time since the impact before; NaN of the first impact, and where an impact
        between was not seen.
    """
    failed = set(_keys(epsilon[~epsilon["success"]], "model"))
    usable = set(_keys(usable_rows(runs)))
    fits = zip(_keys(restitution), _keys(restitution, "source"), strict=True)
    found = restitution[np.array([run in usable and fit not in failed for run, fit in fits], bool)]
    critical_deg = np.array([np.degrees(blocks[name].theta_cr) for name in found["block"]], float)
    found = found.assign(amplitude=found["peak_before_deg"].to_numpy(float) / critical_deg)
    period = 2 * found.groupby(FIT, sort=False)["time_s"].diff()
    before = period.groupby([found[name] for name in FIT], sort=False).shift()
    return found.assign(period_s=period.where(~(period > GAP * before)))


def usable_rows(runs: pd.DataFrame) -> pd.DataFrame:
    """The rows of the table runs that are neither failed nor excluded."""
    return runs[(runs["verdict"] != "fail") & ~runs["excluded"].astype(bool)]


def _keys(table: pd.DataFrame, *more: str) -> Iterator[tuple[str, ...]]:
    """Test, run and what else of each row; run numbers of files are texts."""
    yield from table[["test", "run", *more]].astype(str).itertuples(index=False, name=None)


def first_runs(found: pd.DataFrame) -> pd.DataFrame:
    """The swings of the first run of each block and foundation, with those of its models."""
    recorded = found[found["source"] == "experiment"]
    return found.merge(recorded.drop_duplicates(["block", "foundation"])[["test", "run"]])


def rigid_period_s(block: Block, amplitude: Floats) -> Floats:
    """Period [s] of a rigid block without losses, four falls from an amplitude over the critical angle."""
    from scipy.special import ellipkinc  # loads in 0.2 s; few figures need it

    k2 = np.sin((1 - amplitude) * block.theta_cr / 2) ** 2
    turned = np.arcsin(np.sqrt((1 - k2 / np.sin(block.theta_cr / 2) ** 2) / (1 - k2)))
    return np.asarray(4 * ellipkinc(turned, 1 - k2) / block.p)


def measured_swings(restitution: pd.DataFrame) -> dict[tuple[str, int], tuple[Floats, Floats]]:
    """Measured |θ| of each peak after the n-th impact [°] and when that was [s], by test and run."""
    seen = restitution[restitution["source"] == "experiment"].sort_values(["test", "run", "impact"])
    found = {}
    for (test, run), own in seen.groupby(["test", "run"], sort=False):
        peaks, times = (own[name].to_numpy(float) for name in ("peak_before_deg", "time_s"))
        found[str(test), int(run)] = np.abs(peaks[1:]), times[:-1]
    return found
