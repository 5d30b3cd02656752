"""How many runs, blocks and angles, and what to measure better first: total uncertainty before any test.

What n runs tell of a number is uncertain by

    u² = (τ² + s²)/n + Σ c_i²,

with τ the spread between runs, s the standard error of one by its noise, and c_i the contributions of the
laboratory's inputs, which are the same in all runs (JCGM 100:2008, 5.1 and 5.2). More runs make the first
term smaller and nothing else.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import t

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.problem import RTOL_RESIDUAL
from freerock.identification.start import posed
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver
from freerock.planning.plan import BUDGET_CASE, CASE_COLUMNS, Choices, Setup, cases_of, expected_of
from freerock.populations.random_effects import LEVEL
from freerock.populations.sensitivity import held_contributions
from freerock.rotation.as_measured import as_measured
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion

ALL = "all blocks"  # in place of a block, of the mean over blocks
OVER_BLOCKS = {"block": ALL, "laser": "", "release_angle_deg": math.nan}  # columns of such a mean
BUDGET = [*BUDGET_CASE, "parameter", "input", "input_owner", "input_u", "input_unit", "input_stated"]
BUDGET += ["contribution_fraction"]
TOTALS = [*CASE_COLUMNS, "parameter", "value", "unit", "spread_fraction", "n_runs", "runs_fraction"]
TOTALS += ["inputs_fraction", "u_total", "half95"]
TOTALS += ["first_input", "first_owner", "first_share", "u_total_without_first"]

Spread = Mapping[str, Mapping[str, float]]
"""Foundation: parameter: standard deviation between runs over the mean."""


def plan_budget(setups: Iterable[Setup], choices: Choices) -> pd.DataFrame:
    """What the laboratory's inputs will contribute to the uncertainty of each parameter.

    Parameters
    ----------
    setups, choices
        As for `plan.plan`.

    Returns
    -------
    pandas.DataFrame
        A row per block, foundation, laser, duration_s, release_angle_deg, model, parameter and input:
        input, input_owner, input_u, input_unit, input_stated, contribution_fraction (shift of the parameter
        for one standard uncertainty of the input, over its value; NaN where the block overturns or the like).
    """
    rows: list[tuple[Any, ...]] = []
    for setup, model, duration, angle in cases_of(setups, choices):
        laboratory, names = replace(setup.laboratory, block=setup.worn(model)), CANDIDATES[model].parameters
        values = {**setup.expected[model], "width": 2 * laboratory.block.b}
        motion = expected_of(setup, model, duration, angle, choices)
        if isinstance(motion, FreerockError):
            shifts = np.full((len(names), len(laboratory.inputs)), np.nan)
        else:
            shifts = _shifts(motion, model, laboratory, values, choices.settings_of(model))
        for name, own in zip(names, shifts, strict=True):
            for source, shift in zip(laboratory.inputs, own, strict=True):
                known = source.name, source.owner, source.u, source.unit, source.stated
                rows.append((*setup.names, duration, angle, model, name, *known, shift / values[name]))
    return pd.DataFrame(rows, columns=BUDGET)


def _shifts(
    motion: Motion, model: str, laboratory: Laboratory, values: Mapping[str, float], settings: FitSettings
) -> Floats:
    """Of the parameters for one standard uncertainty of each input, shape (n_parameters, n_inputs).

    They are found from the expected motion as the laboratory's laser shows it.
    """
    candidate = CANDIDATES[model]
    view = view_of(list(laboratory.lasers.values()), laboratory.block)
    theta = as_measured(
        candidate.law,
        laboratory.block,
        {**values, "theta0": motion.theta0},
        motion.time_s,
        view,
        rules=candidate.rules(settings.debonding),
        solver=Solver(RTOL_RESIDUAL),
    )
    seen = replace(motion, theta=theta, view=view)
    problem = replace(posed(model, (laboratory.block,), (seen,), settings), rtol=RTOL_RESIDUAL).rough()
    found = held_contributions(problem, problem.start_at(values), laboratory)
    return found.values[[problem.names.index(name) for name in candidate.parameters]]


def plan_totals(
    errors: pd.DataFrame, budget: pd.DataFrame, n_runs: Sequence[int], spread: Spread
) -> pd.DataFrame:
    """Total uncertainty of a mean over n runs of a block, and over as many of each block of a foundation.

    Of all blocks together each has the laser and angle by which it knows the parameter best. Inputs that
    blocks share shift their mean as they shift each of them; those of their own cancel in part.

    Parameters
    ----------
    errors : pandas.DataFrame
        From `plan.plan`.
    budget : pandas.DataFrame
        From `plan_budget`.
    n_runs : sequence of int
        Numbers of runs.
    spread : mapping of str to mapping of str to float
        Of each foundation, by parameter: τ over the mean; 0 where it is not given.

    Returns
    -------
    pandas.DataFrame
        A row per case of `errors`, parameter and number of runs: the columns of the case (block is `ALL`,
        laser "" and release_angle_deg NaN of all blocks together), parameter, value, unit, spread_fraction,
        n_runs (of each block), runs_fraction and inputs_fraction (the two parts of u over the value), u_total
        and half95 (half the 95 % interval, by Student's t with the degrees of freedom of Welch and
        Satterthwaite; NaN of a single run, which does not tell its spread), unit; first_input, first_owner
        (the input that contributes most), first_share (its share of u², as a fraction), u_total_without_first
        (were it exact).
    """
    of_parameter = [*BUDGET_CASE, "parameter"]
    inputs = {
        case: {(row.input_owner, row.input): row.contribution_fraction for row in rows.itertuples()}
        for case, rows in budget.groupby(of_parameter, sort=False)
    }
    known = list[_Known]()
    for row in errors.to_dict("records"):
        between = spread.get(row["foundation"], {}).get(row["parameter"], 0.0)
        own = math.hypot(between, row["stderr"] / row["value"])
        shifts = inputs.get(tuple(row[name] for name in of_parameter), {})
        if math.isfinite(own) and shifts:
            known.append(_Known(row | {"spread_fraction": between}, own, shifts))
    rows = [_mean([each], n) for each in known for n in n_runs]
    together: dict[tuple[Any, ...], dict[str, list[_Known]]] = {}
    alike = [name for name in [*CASE_COLUMNS, "parameter"] if name not in OVER_BLOCKS]
    for each in known:
        blocks = together.setdefault(tuple(each.row[name] for name in alike), {})
        blocks.setdefault(each.row["block"], []).append(each)
    for blocks in together.values():
        members = [
            min(own, key=lambda each: _mean([each], n_runs[-1])["u_total"] / each.row["value"])
            for own in blocks.values()
        ]
        if len(members) > 1:
            rows += [_mean(members, n) for n in n_runs]
    return pd.DataFrame(rows, columns=TOTALS)


class _Known(NamedTuple):
    """What one run of a case knows of a parameter: its row, and over its value the standard uncertainty by
    noise and spread and the shifts by the inputs."""

    row: Mapping[str, Any]
    own: float
    shifts: Mapping[tuple[str, str], float]


def _mean(members: Sequence[_Known], n: int) -> dict[str, Any]:
    """Of the mean of n runs of each member."""
    blocks, row = len(members), members[0].row
    runs = math.sqrt(sum(each.own**2 for each in members) / n) / blocks
    shifts: dict[tuple[str, str], float] = {}
    for each in members:
        for key, shift in each.shifts.items():
            shifts[key] = shifts.get(key, 0.0) + shift / blocks
    of_inputs = sum(shift**2 for shift in shifts.values())
    u = math.sqrt(runs**2 + of_inputs)
    owner, first = max(shifts, key=lambda key: abs(shifts[key]))
    dof = blocks * (n - 1) * (u / runs) ** 4 if runs > 0 else math.inf
    half = t.ppf((1 + LEVEL) / 2, dof) * u if dof > 0 else math.nan
    return {
        **row,
        **(OVER_BLOCKS if blocks > 1 else {}),
        "n_runs": n,
        "runs_fraction": runs,
        "inputs_fraction": math.sqrt(of_inputs),
        "u_total": u * row["value"],
        "half95": half * row["value"],
        "first_input": first,
        "first_owner": owner,
        "first_share": shifts[owner, first] ** 2 / u**2,
        "u_total_without_first": math.sqrt(u**2 - shifts[owner, first] ** 2) * row["value"],
    }
