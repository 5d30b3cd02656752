"""Swings of a block between its impacts, from the table restitution: rate, energy, loss, period."""

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
    """What happens between the impacts of runs and of the models fitted to them.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables; failed and excluded runs are left out, and models whose fit failed.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    pandas.DataFrame
        The columns of restitution, and amplitude, the peak before the impact over the critical angle,
        rigid_speed_m_s, the impact speed of a rigid block that falls from
        the peak before the impact, energy_j, what it has there above rest, loss = 1 - r² and its
        total uncertainty loss_u, and period_s, twice the time since the impact before; NaN of the first
        impact, and where an impact between was not seen.

    Notes
    -----
    m g R (cos φ - cos θ_cr) with φ = θ_cr - |θ_peak| is the energy, and p² (cos φ - cos θ_cr) half the
    squared angular rate, which times 2b is the impact speed (Housner 1963, doi:10.1785/BSSA0530020403).
    """
    failed = set(_keys(epsilon[~epsilon["success"]], "model"))
    usable = set(_keys(usable_rows(runs)))
    fits = zip(_keys(restitution), _keys(restitution, "source"), strict=True)
    found = restitution[np.array([run in usable and fit not in failed for run, fit in fits], bool)]
    of_block = found["block"].map(blocks)
    critical = np.array([block.theta_cr for block in of_block], float)
    peak = np.radians(found["peak_before_deg"].to_numpy(float))
    height = np.cos(critical - peak) - np.cos(critical)
    weight = np.array([block.weight * block.R for block in of_block], float)
    p_2b = np.array([block.p * 2 * block.b for block in of_block], float)
    r = found["r"].to_numpy(float)
    found = found.assign(
        amplitude=peak / critical,
        rigid_speed_m_s=p_2b * np.sqrt(2 * np.maximum(height, 0.0)),
        energy_j=weight * height,
        loss=1 - r**2,
        loss_u=2 * r * found["r_u"],
    )
    period = 2 * found.groupby(FIT, sort=False)["time_s"].diff()
    before = period.groupby([found[name] for name in FIT], sort=False).shift()
    return found.assign(period_s=period.where(~(period > GAP * before)))


def named_swings(
    runs: pd.DataFrame, restitution: pd.DataFrame, epsilon: pd.DataFrame, blocks: Mapping[str, Block]
) -> pd.DataFrame:
    """The swings of all runs, and of the first of each block and foundation those of its `named_models`."""
    found = swings(runs, restitution, epsilon, blocks)
    models = named_models(epsilon)
    own = [models.get((test, str(run))) for test, run in found[["test", "run"]].to_numpy()]
    recorded = found["source"] == "experiment"
    modelled = first_runs(found[recorded | (found["source"] == own)])
    return pd.concat([found[recorded], modelled[modelled["source"] != "experiment"]], ignore_index=True)


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


def named_models(epsilon: pd.DataFrame) -> dict[tuple[str, str], str]:
    """The model that stands for each run: the one the choice names, else that of the least ε_θ.

    Parameters
    ----------
    epsilon : pandas.DataFrame
        Tidy table; fits that may not be used are left out.

    Returns
    -------
    dict of (str, str) to str
        Model by record and run number.
    """
    usable = epsilon[epsilon["success"].astype(bool)]
    ranked = usable.sort_values(["selected", "epsilon_theta"], ascending=[False, True], kind="stable")
    first = ranked.drop_duplicates(["test", "run"])
    return {(test, str(run)): model for test, run, model in first[["test", "run", "model"]].to_numpy()}


def peaks_of_runs(restitution: pd.DataFrame) -> dict[tuple[str, int], Floats]:
    """Measured |θ| of each peak after the n-th impact [°], by test and run, from the tidy table."""
    seen = restitution[(restitution["source"] == "experiment") & (restitution["impact"] > 1)]
    return {
        (str(test), int(run)): own["peak_before_deg"].abs().to_numpy(float)
        for (test, run), own in seen.groupby(["test", "run"], sort=False)
    }
