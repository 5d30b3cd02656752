"""What runs have in common: mean, spread and next value of parameters, by record, foundation, campaign."""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import expit, logit

from freerock.arrays import Floats
from freerock.identification.random_effects import Population, common_spread, population
from freerock.models.laws import MODELS, OF_RECORD, law_of

POPULATIONS = ["campaign", "level", "test", "block", "foundation", "model", "parameter", "unit", "n_runs"]
POPULATIONS += ["n_records", "mean", "stderr", "ci95_low", "ci95_high", "tau", "tau_low", "tau_high"]
POPULATIONS += ["next_low", "next_high", "scatter_p"]
RECORD = ["campaign", "test", "block", "foundation", "model", "parameter"]


class _Scale(NamedTuple):
    """On which runs scatter evenly: there, back, and by how much a value changes for a change there."""

    there: Callable[[Any], Any]
    back: Callable[[Any], Any]
    slope: Callable[[float], float]


LOGARITHM = _Scale(np.log, np.exp, lambda value: value)
LOGIT = _Scale(logit, expit, lambda value: value * (1 - value))
AS_IT_IS = _Scale(np.asarray, np.asarray, lambda value: 1.0)


def scale_of(parameter: str) -> _Scale:
    """Logarithms; of r, which is a share, the logit; of the tilt, which has a sign, and of edges, which may
    be sharp, the value itself."""
    return {"r": LOGIT, "tilt": AS_IT_IS, "edge_radius": AS_IT_IS}.get(parameter, LOGARITHM)


def populations_table(parameters: pd.DataFrame) -> pd.DataFrame:
    """Random effects of the identified parameters (`identification.random_effects`).

    Values are taken as logarithms, r as the logit, tilt and edge radius as they are. Of a foundation its
    records are the members, each with the spread between its runs that all records of the foundation have; r
    belongs to the block and has no such level. Of the campaign there is the spread between the runs of a
    record alone.

    Parameters
    ----------
    parameters : pandas.DataFrame
        Tidy table.

    Returns
    -------
    pandas.DataFrame
        Columns `POPULATIONS`: level is "record", "foundation" (of two records or more) or "campaign"; test
        and block are empty where they are several. mean (geometric), its standard error and 95 % interval;
        tau, the standard deviation between the members without their noise, and its 95 % interval; next_low
        and next_high, where the next member that is measured lies with 95 %; in the parameter's unit.
        scatter_p: chance of so much scatter by noise alone. Of a single run n_runs is 1, mean and error are
        its own, and the rest is NaN.
    """
    own = [each.parameter in (*MODELS[each.model], *OF_RECORD) for each in parameters.itertuples()]
    used = parameters[np.array(own, bool) & parameters["success"].astype(bool)]
    rows, members = [], dict[tuple[str, ...], list[_Member]]()
    for key, runs in used.groupby(RECORD, sort=False):
        scene = dict(zip(RECORD, key, strict=True)) | {"unit": runs["unit"].iloc[0]}
        member = _member(scene["parameter"], runs)
        rows.append(scene | {"level": "record", "n_records": 1} | _told(scene["parameter"], member.found))
        if member.found.n:
            common = tuple(scene[name] for name in ("campaign", "foundation", "model", "parameter", "unit"))
            members.setdefault(common, []).append(member)
    rows += list(_foundations(members))
    rows += list(_campaign(members))
    return pd.DataFrame(rows, columns=POPULATIONS).astype({"n_runs": "Int64", "n_records": "Int64"})


class _Member(NamedTuple):
    """A record among others: what its runs say, on the scale; their values; the variances of their noise."""

    found: Population
    values: Floats
    variances: Floats


def _member(parameter: str, runs: pd.DataFrame) -> _Member:
    """What the runs of a record say, on the scale; of those that have a standard error, where any has."""
    value, scale = runs["value"].to_numpy(float), scale_of(parameter)
    stderr = runs["stderr"].to_numpy(float)
    known = np.isfinite(stderr) & (stderr > 0)
    there = scale.there(value)
    if not known.any():
        return _Member(Population(0, float(there.mean()), *[math.nan] * 3), np.empty(0), np.empty(0))
    noise = stderr[known] / np.array([scale.slope(each) for each in value[known]])
    return _Member(population(there[known], noise), there[known], noise**2)


def _foundations(members: Mapping[tuple[str, ...], list[_Member]]) -> Iterator[dict[str, Any]]:
    """The parameters of each foundation over its records."""
    for (campaign, foundation, model, parameter, unit), records in members.items():
        if len(records) < 2 or not law_of(model).is_foundation:
            continue
        tau2 = (_spread(records) or (0.0,))[0] ** 2
        errors = [math.sqrt(1 / np.sum(1 / (each.variances + tau2))) for each in records]
        found = population([each.found.mean for each in records], errors)
        scene = _scene(campaign, "foundation", foundation, model, parameter, unit, records)
        yield scene | _told(parameter, found) | {"n_runs": scene["n_runs"]}


def _campaign(members: Mapping[tuple[str, ...], list[_Member]]) -> Iterator[dict[str, Any]]:
    """The spread between the runs of a record, over all records of a campaign."""
    alike: dict[tuple[str, ...], list[_Member]] = {}
    for (campaign, _, model, parameter, unit), records in members.items():
        alike.setdefault((campaign, model, parameter, unit), []).extend(records)
    for (campaign, model, parameter, unit), records in alike.items():
        found = _spread(records)
        if found:
            scale = scale_of(parameter)
            mean = float(scale.back(np.mean([each.found.mean for each in records])))
            spread = zip(("tau", "tau_low", "tau_high"), found, strict=True)
            yield _scene(campaign, "campaign", "", model, parameter, unit, records) | {
                "mean": mean,
                **{name: value * scale.slope(mean) for name, value in spread},
            }


def _scene(
    campaign: str,
    level: str,
    foundation: str,
    model: str,
    parameter: str,
    unit: str,
    records: list[_Member],
) -> dict[str, Any]:
    """What a row of several records is of."""
    scene = {"campaign": campaign, "level": level, "test": "", "block": "", "foundation": foundation}
    scene |= {"model": model, "parameter": parameter, "unit": unit}
    return scene | {"n_records": len(records), "n_runs": sum(each.found.n for each in records)}


def _spread(records: list[_Member]) -> tuple[float, float, float] | None:
    """Standard deviation between the runs of a record, from all records, and its interval; None of one run
    each."""
    several = [(each.values, each.variances) for each in records if each.found.n > 1]
    return common_spread(several) if several else None


def _told(parameter: str, found: Population) -> dict[str, Any]:
    """A population in the unit of its parameter."""
    scale = scale_of(parameter)
    mean = float(scale.back(found.mean))
    slope = scale.slope(mean)
    return {
        "n_runs": found.n,
        "mean": mean,
        "stderr": found.stderr * slope,
        "ci95_low": float(scale.back(found.low)),
        "ci95_high": float(scale.back(found.high)),
        **{name: getattr(found, name) * slope for name in ("tau", "tau_low", "tau_high")},
        "next_low": float(scale.back(found.next_low)),
        "next_high": float(scale.back(found.next_high)),
        "scatter_p": found.p,
    }
