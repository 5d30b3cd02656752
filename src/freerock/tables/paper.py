"""Tables 1 to 3 of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024), and each foundation, as numbers."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from freerock.columns import table_of
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import MODELS, PAPER_MODELS, law_of
from freerock.products.contents import usable_runs
from freerock.products.netcdf_groups import reasons_in
from freerock.tables.choices import QUOTED, laws_of_foundations, rejected_laws
from freerock.tables.tidy_tables import R_ENERGY

Published = Mapping[str, Any] | None  # values by block, foundation, model and quantity
NOT_HELD = {"hold_unseen", "braked"}  # reasons of a run that begins at a peak, and so has no release angle


def table1(
    records: Iterable[xr.DataTree],
    blocks: Mapping[str, Block],
    release_angles_deg: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """Block configurations with the release angle as the sensor shows it, of runs whose hold was seen.

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
        Columns of table1.csv but origin; a row per block.
    """
    held: dict[str, list[xr.DataTree]] = {name: [] for name in blocks}
    for tree in records:
        held[tree.attrs["block"]] += filter(_was_held, usable_runs(tree).values())
    rows = [
        {
            "block": name,
            "height_m": block.height_m,
            "width_m": block.width_m,
            "slenderness": block.height_m / block.width_m,
            "mass_kg": block.mass_kg,
            "alpha_nominal_deg": (release_angles_deg or {}).get(name, math.nan),
            **_released_from(held[name]),
            "n_runs": len(held[name]),
            "theta_cr_deg": math.degrees(block.theta_cr),
            "R_m": block.R,
            "p_rad_s": block.p,
            "r_housner": block.restitution_housner,
        }
        for name, block in blocks.items()
    ]
    return table_of("table1", rows, but="origin")


def _was_held(run: xr.DataTree) -> bool:
    """Whether the sensor saw the angle from which a run was released."""
    return not NOT_HELD & {reason.name for reason in reasons_in(run.attrs)}


def _released_from(runs: Sequence[xr.DataTree]) -> dict[str, float]:
    """Mean release angle of some runs of a block [degree], its total u, and the spread of the runs.

    The noise of the runs averages out. Inputs and corners that sink are alike in all runs and do not.
    """
    angle, u, noise = (
        np.degrees([abs(run[name].item()) for run in runs])
        for name in ("theta0", "theta0_u", "theta0_stderr")
    )
    n = len(runs)
    alike = np.sqrt(np.maximum(u**2 - noise**2, 0.0))
    return {
        "alpha_deg": float(angle.mean()) if n else math.nan,
        "alpha_u_deg": math.hypot(alike.mean(), np.linalg.norm(noise) / n) if n else math.nan,
        "alpha_std_deg": float(angle.std(ddof=1)) if n > 1 else math.nan,
    }


def table2(
    populations: pd.DataFrame, paper: pd.DataFrame, choice: pd.DataFrame, published: Published = None
) -> pd.DataFrame:
    """Parameters of the paper's laws by its own procedure for each block, and means over a foundation with u.

    r belongs to a block on a foundation, k and damping to the foundation: these have a row over all blocks.
    A candidate beside the paper's laws has rows where most runs of a foundation select it.

    Parameters
    ----------
    populations, paper, choice : pandas.DataFrame
        Tidy tables.
    published : mapping, optional
        Published values by block, foundation, model and quantity.

    Returns
    -------
    pandas.DataFrame
        Columns of table2.csv but origin: block is empty in a row over all blocks of a foundation, which has
        nothing by the paper's procedure.
    """
    rejected = rejected_laws(choice)
    rows = []
    for model in dict.fromkeys((*PAPER_MODELS, *filter(None, laws_of_foundations(choice).values()))):
        for parameter in MODELS[model]:
            for block, foundation in _scenes(paper, choice, model):
                own = _of(paper, block, foundation, model, parameter)
                means = _of(populations, block, foundation, model, parameter)
                usable = own[own["success"].astype(bool)]
                rows.append(
                    {"block": block, "foundation": foundation, "model": model, "parameter": parameter}
                    | {"unit": PARAMETERS[parameter].unit, "n_records": own["test"].nunique() or len(means)}
                    | {"n_runs": len(own) or means["n_runs"].sum(), **_mean(means)}
                    | {"rejected": (block, foundation, model) in rejected}
                    | _by_procedure(usable if block else usable[:0])
                    | {"published": _published(published, block, foundation, model, parameter)}
                )
    return table_of("table2", rows, but="origin")


def _scenes(paper: pd.DataFrame, choice: pd.DataFrame, model: str) -> list[tuple[str, str]]:
    """Block and foundation of the rows of a candidate in table 2; the block is empty for all of them."""
    scenes = paper[["block", "foundation"]].drop_duplicates().itertuples(index=False, name=None)
    of_blocks = [(str(block), str(foundation)) for block, foundation in scenes]
    over_all = [("", foundation) for foundation in dict.fromkeys(each for _, each in of_blocks)]
    named = laws_of_foundations(choice)
    if model in PAPER_MODELS:
        return of_blocks + over_all * law_of(model).is_foundation
    own = over_all if law_of(model).is_foundation else of_blocks
    return [(block, foundation) for block, foundation in own if named.get(foundation) == model]


def _of(table: pd.DataFrame, block: str, foundation: str, model: str, parameter: str) -> pd.DataFrame:
    """The rows of a parameter of a candidate on a foundation, of one block where one is named."""
    own = (table["foundation"] == foundation) & (table["model"] == model) & (table["parameter"] == parameter)
    return table[own & (table["block"] == block)] if block else table[own]


def _by_procedure(fits: pd.DataFrame) -> dict[str, float]:
    """Median and range over runs by the paper's own procedure, and their ε_θ."""
    value = fits["value"]
    return {
        "paper": value.median(),
        "paper_low": value.min(),
        "paper_high": value.max(),
        "epsilon_theta": fits["epsilon_theta"].median(),
    }


def table3(paper: pd.DataFrame, published: Published = None) -> pd.DataFrame:
    """ε_θ of each law by the paper's own procedure, on each foundation, for each block.

    Parameters
    ----------
    paper : pandas.DataFrame
        Tidy table.
    published : mapping, optional
        Published values by block, foundation, model and quantity.

    Returns
    -------
    pandas.DataFrame
        Columns of table3.csv but origin: median and range over the runs, NaN where no fit may be used.
    """
    of_fits = paper.drop_duplicates(["test", "run", "model"])
    rows = []
    for (block, foundation, law), each in of_fits.groupby(["block", "foundation", "model"], sort=False):
        epsilon = each[each["success"].astype(bool)]["epsilon_theta"]
        rows.append(
            {"block": block, "foundation": foundation, "model": law, "n_runs": len(epsilon)}
            | {"epsilon_theta": epsilon.median(), "epsilon_low": epsilon.min(), "epsilon_high": epsilon.max()}
            | {"final_time_s": each["final_time_s"].max()}
            | {"published": _published(published, block, foundation, law, "epsilon_theta")}
        )
    return table_of("table3", rows, but="origin")


def summary_table(tidy: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """What was found of each foundation, a row each.

    Parameters
    ----------
    tidy : mapping of str to pandas.DataFrame
        The tidy tables runs, choice, epsilon, populations, restitution, paper and predictions.

    Returns
    -------
    pandas.DataFrame
        Columns of summary.csv.
    """
    runs = tidy["runs"]
    usable = runs[(runs["verdict"] != "fail") & ~runs["excluded"].astype(bool) & runs["run"].notna()]
    of_fits = tidy["paper"].drop_duplicates(["test", "run", "model"])
    of_fits = of_fits[of_fits["success"].astype(bool)]
    impacts = tidy["restitution"]
    first = impacts[(impacts["source"] == "experiment") & (impacts["impact"] == 1)]
    first = first.astype({"run": str}).merge(usable[["test", "run"]].astype(str))
    longest = usable.groupby(["block", "foundation"])["duration_s"].mean()
    rows = []
    for foundation, law in laws_of_foundations(tidy["choice"]).items():
        here = {
            name: own[own["foundation"] == foundation] for name, own in tidy.items() if "foundation" in own
        }
        blocks = [block for block, own in longest.groupby("block") if own.idxmax()[1] == foundation]
        several = [block for block in blocks if len(longest[block]) > 1]
        selected = (here["choice"]["status"] == "selected") & (here["choice"]["model"] == law)
        epsilon = of_fits[of_fits["foundation"] == foundation].groupby("model")["epsilon_theta"].median()
        rows.append(
            {"campaign": runs["campaign"].iloc[0], "foundation": foundation, "longest": " ".join(several)}
            | {"model": law, "n_selected": int(selected.sum())}
            | {"n_runs": len(here["choice"][["test", "run"]].drop_duplicates())}
            | _quoted(here["populations"], law)
            | _scatter(here["epsilon"], law)
            | {"r_first": first[first["foundation"] == foundation][R_ENERGY].median()}
            | {f"epsilon_{name}": epsilon.get(name, math.nan) for name in PAPER_MODELS}
            | _predicted(here["predictions"], law)
        )
    return table_of("summary", rows)


def _quoted(populations: pd.DataFrame, law: str) -> dict[str, float]:
    """Parameters of the selected law on a foundation, with u."""
    told = dict[str, float]()
    for name in QUOTED:
        own = populations[(populations["model"] == law) & (populations["parameter"] == name)]
        mean = _mean(own)
        told |= {name: mean["mean"], f"{name}_u": mean["u_total"]}
    return told


def _scatter(epsilon: pd.DataFrame, law: str) -> dict[str, float]:
    """Scatter of the impacts under a law: root mean square over the records of a foundation, and its u."""
    own = epsilon[epsilon["model"] == law].drop_duplicates("test")
    if not len(own):
        return {"sigma_r": math.nan, "sigma_r_u": math.nan}
    u = (own["sigma_r_high"] - own["sigma_r_low"]) / 4
    return {
        "sigma_r": math.sqrt((own["sigma_r"] ** 2).mean()),
        "sigma_r_u": math.sqrt((u**2).sum()) / len(own),
    }


def _predicted(predictions: pd.DataFrame, law: str) -> dict[str, float]:
    """How well a run is predicted from the others of its record: peaks in their 95 % band, and all."""
    own = predictions[predictions["model"] == law]
    half = (own["high_deg"] - own["low_deg"]) / (2 * own["median_deg"])
    return {"n_inside": int(own["inside"].sum()), "n_peaks": len(own), "half_band": half.median()}


def _mean(populations: pd.DataFrame) -> dict[str, float]:
    """Mean and u of a parameter over the records of a foundation, else the median of those of records."""
    over = populations[populations["level"] == "foundation"]
    own = over if len(over) else populations[populations["level"] == "record"]
    return {name: float(own[name].median()) if len(own) else math.nan for name in ("mean", "u_total")}


def _published(published: Published, *keys: str) -> float:
    """The published value of a block, foundation, law and quantity; NaN where there is none."""
    found: Any = published
    for key in keys:
        found = (found or {}).get(key)
    return math.nan if found is None else float(found)
