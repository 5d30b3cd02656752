"""Mean, spread and prediction of parameters over the runs of a record, foundation or campaign."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import expit, logit

from freerock.columns import columns_of, table_of
from freerock.models.free_parameters import OF_RECORD
from freerock.models.laws import MODELS, law_of
from freerock.populations.means import Key, Mean, over_records, over_runs, spread_of_runs
from freerock.populations.random_effects import Population, exponential

INPUT = ["input", "input_owner", "input_u", "input_unit", "input_stated"]
COMMON = ["campaign", "foundation", "model", "parameter", "unit"]  # of the records of a foundation
# Column of an end of an interval, and its name in `Population`.
ENDS = {"ci95_low": "low", "ci95_high": "high", "total95_low": "total_low", "total95_high": "total_high"}
ENDS |= {"next_low": "next_low", "next_high": "next_high"}
SIGNIFICANT = 0.05  # chance of the scatter between blocks, below which they differ
RECORD = ["campaign", "test", "block", "foundation", "model", "parameter"]


class _Scale(NamedTuple):
    """On which runs scatter evenly: there, back, and by how much a value changes for a change there."""

    there: Callable[[Any], Any]
    back: Callable[[Any], Any]
    slope: Callable[[float], float]


LOGARITHM = _Scale(np.log, exponential, lambda value: value)
LOGIT = _Scale(logit, expit, lambda value: value * (1 - value))
AS_IT_IS = _Scale(np.asarray, np.asarray, lambda value: 1.0)


def scale_of(parameter: str) -> _Scale:
    """Logarithms; of r, which is a share, the logit; of the tilt, which has a sign, and of edges, which may
    be sharp, the value itself."""
    return {"r": LOGIT, "tilt": AS_IT_IS, "edge_radius": AS_IT_IS}.get(parameter, LOGARITHM)


Means = Sequence[tuple[dict[str, Any], Mean]]
"""What each mean is of, and what its members say: of records, then of foundations."""


def means_in(parameters: pd.DataFrame, contributions: pd.DataFrame | None = None) -> Means:
    """Random effects of the identified parameters (`populations.random_effects`).

    Values are taken as logarithms, r as the logit, tilt and edge radius as they are. Of a foundation its
    records are the members, each with the spread between its runs that all records of the foundation have; r
    belongs to the block and has no such level.

    Parameters
    ----------
    parameters, contributions : pandas.DataFrame
        Tidy tables. Without contributions the inputs are taken for exact. A mean holds all runs that are
        neither failed nor excluded and whose fit may be used.
    """
    records = list(_records(parameters, contributions))
    return [*records, *_foundations(_by_foundation(records))]


def populations_table(means: Means) -> pd.DataFrame:
    """Means of `means_in`, and of the campaign the spread between the runs of a record alone.

    Returns
    -------
    pandas.DataFrame
        Columns of populations.csv: level is "record", "foundation" (of two records or more) or "campaign";
        test and block are empty where they are several. mean (geometric, weighted), its standard error and 95
        % interval without what all members share; u_total, its total standard uncertainty with what the
        members owe to the laboratory's inputs, and the 95 % interval of that; tau, the standard deviation
        between the members without noise and inputs, and its 95 % interval; next_low and next_high, where the
        next member that is measured lies with 95 %: a run of the same record, or a record of another block;
        in the parameter's unit. scatter_p: p-value of tau = 0. Of a single run n_runs is 1, mean and error
        are its own, and the rest is NaN.
    """
    rows = [_told(scene["parameter"], mean.found) | scene for scene, mean in means]
    rows += _campaign(_by_foundation(means))
    return table_of("populations", rows).astype({"n_runs": "Int64", "n_records": "Int64"})


def foundations_table(populations: pd.DataFrame) -> pd.DataFrame:
    """The laws of each foundation, and whether they transfer to another block.

    Parameters
    ----------
    populations : pandas.DataFrame
        From `populations_table`.

    Returns
    -------
    pandas.DataFrame
        Columns of foundations.csv, a row per foundation with several records, law and parameter: the mean
        over its records with its total uncertainty, which holds the scatter tau between them; next_low and
        next_high, where another block lies with 95 %. transfers is False where the records scatter by more
        than noise, their runs and inputs explain (scatter_p below 5 %).
    """
    rows = populations[populations["level"] == "foundation"]
    return rows.assign(transfers=~(rows["scatter_p"] < SIGNIFICANT))[columns_of("foundations")]


def budget_table(means: Means, contributions: pd.DataFrame) -> pd.DataFrame:
    """Uncertainty budget of the means of `means_in` with these contributions (JCGM 100:2008, 7.2.7 and H).

    Returns
    -------
    pandas.DataFrame
        Columns of budget.csv, a row per mean (with its u_total) and contribution: the scatter of the
        members beyond what the inputs explain (input "runs": noise, and what differs from run to run or from
        record to record), then each input with its standard uncertainty input_u [input_unit] and whether it
        was stated; sensitivity, the derivative of the mean by the input; contribution, their product [unit of
        the parameter]; share_percent of the square of u_total.
    """
    known, rows = _inputs_by_key(contributions), list[dict[str, Any]]()
    for scene, member in means:
        scale, found = scale_of(scene["parameter"]), member.found
        if not found.n:
            continue
        mean = float(scale.back(found.mean))
        slope = scale.slope(mean)
        of_runs: dict[str, Any] = dict.fromkeys(INPUT, math.nan) | {"input": "runs"}
        of_runs |= {"input_owner": scene["test"] or scene["foundation"]}
        each = [(of_runs, member.scatter), *((known[key], by) for key, by in member.shifts.items())]
        rows += [
            {name: scene[name] for name in (*RECORD, "level", "unit", "n_runs")}
            | of_input
            | {
                "mean": mean,
                "u_total": found.u * slope,
                "sensitivity": shift * slope / float(u) if (u := of_input["input_u"]) else math.nan,
                "contribution": shift * slope,
                "share_percent": 100 * shift**2 / found.u**2 if found.u else math.nan,
            }
            for of_input, shift in each
        ]
    return table_of("budget", rows).astype({"n_runs": "Int64", "input_stated": "Int64"})


def _records(
    parameters: pd.DataFrame, contributions: pd.DataFrame | None
) -> Iterator[tuple[dict[str, Any], Mean]]:
    """What each row of a record is of, and what its runs say."""
    own = [each.parameter in (*MODELS[each.model], *OF_RECORD) for each in parameters.itertuples()]
    used = parameters[np.array(own, bool) & parameters["success"].astype(bool)]
    shifts: dict[tuple[Any, ...], dict[Key, float]] = {}
    for row in contributions.itertuples() if contributions is not None else ():
        of = row.campaign, row.test, row.run, row.model, row.parameter
        slope = scale_of(row.parameter).slope(row.value)
        shifts.setdefault(of, {})[row.input_owner, row.input] = row.contribution / slope
    for key, runs in used.groupby(RECORD, sort=False):
        scene = dict(zip(RECORD, key, strict=True)) | {"unit": runs["unit"].iloc[0]}
        of_runs = [
            shifts.get((scene["campaign"], scene["test"], run, scene["model"], scene["parameter"]), {})
            for run in runs["run"]
        ]
        member = _member(scene["parameter"], runs, of_runs)
        yield scene | {"level": "record", "n_records": 1, "n_runs": member.found.n}, member


def _by_foundation(means: Means) -> dict[tuple[str, ...], list[Mean]]:
    """The records of each parameter on a foundation."""
    found: dict[tuple[str, ...], list[Mean]] = {}
    for scene, member in means:
        if scene["level"] == "record" and member.found.n:
            found.setdefault(tuple(scene[name] for name in COMMON), []).append(member)
    return found


def _member(parameter: str, runs: pd.DataFrame, shifts: list[dict[Key, float]]) -> Mean:
    """What the runs of a record say, on the scale; of those that have a standard error, where any has."""
    value, scale = runs["value"].to_numpy(float), scale_of(parameter)
    stderr = runs["stderr"].to_numpy(float)
    known = np.isfinite(stderr) & (stderr > 0)
    there = scale.there(value)
    if not known.any():
        return Mean(Population(0, float(there.mean())), np.empty(0), np.empty(0), {})
    noise = stderr[known] / np.array([scale.slope(each) for each in value[known]])
    return over_runs(there[known], noise, [each for each, one in zip(shifts, known, strict=True) if one])


def _foundations(members: Mapping[tuple[str, ...], list[Mean]]) -> Iterator[tuple[dict[str, Any], Mean]]:
    """The parameters of each foundation over its records: what they are of, and what the records say."""
    for common, records in members.items():
        scene = _scene("foundation", common, records)
        if len(records) > 1 and law_of(scene["model"]).is_foundation:
            yield scene, over_records(records)


def _inputs_by_key(contributions: pd.DataFrame) -> dict[Key, dict[str, Any]]:
    """Uncertainty, unit and origin of each input in a table of contributions."""
    first = contributions.drop_duplicates(["input_owner", "input"])
    return {(row["input_owner"], row["input"]): row for row in first[INPUT].to_dict("records")}


def _campaign(members: Mapping[tuple[str, ...], list[Mean]]) -> Iterator[dict[str, Any]]:
    """The spread between the runs of a record, over all records of a campaign."""
    alike: dict[tuple[str, ...], list[Mean]] = {}
    for (campaign, _, model, parameter, unit), records in members.items():
        alike.setdefault((campaign, model, parameter, unit), []).extend(records)
    for (campaign, model, parameter, unit), records in alike.items():
        found = spread_of_runs(records)
        if found:
            told = _told(parameter, Population(0, float(np.mean([each.found.mean for each in records]))))
            slope = scale_of(parameter).slope(told["mean"])
            spread = zip(("tau", "tau_low", "tau_high"), found, strict=True)
            told |= {name: value * slope for name, value in spread}
            yield told | _scene("campaign", (campaign, "", model, parameter, unit), records)


def _scene(level: str, common: Sequence[str], records: list[Mean]) -> dict[str, Any]:
    """What a row of several records is of."""
    scene = {"level": level, "test": "", "block": "", **dict(zip(COMMON, common, strict=True))}
    return scene | {"n_records": len(records), "n_runs": sum(each.found.n for each in records)}


def _told(parameter: str, found: Population) -> dict[str, Any]:
    """A population in the unit of its parameter."""
    scale = scale_of(parameter)
    mean = float(scale.back(found.mean))
    slope = scale.slope(mean)
    return {
        "n_runs": found.n,
        "mean": mean,
        "stderr": found.stderr * slope,
        "u_total": found.u * slope,
        **{name: getattr(found, name) * slope for name in ("tau", "tau_low", "tau_high")},
        **{column: float(scale.back(getattr(found, name))) for column, name in ENDS.items()},
        "scatter_p": found.p,
    }
