"""How many runs, blocks and angles, and what to measure better first: total uncertainty before any test.

What n runs tell of a number is uncertain by

    u² = (τ² + s²)/n + Σ c_i²,

with τ the spread between runs, s the standard error of one by its noise, and c_i the contributions of the
laboratory's inputs, which are the same in all runs (JCGM 100:2008, 5.1 and 5.2). More runs make the first
term smaller and nothing else.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t

from freerock.arrays import Floats
from freerock.config.defaults import FitSettings
from freerock.identification.problem import COARSE
from freerock.identification.start import posed
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver
from freerock.planning.plan import BUDGET_CASE, CASE, Choices, Nuisances, Setup, different, expected_of
from freerock.populations.random_effects import LEVEL
from freerock.populations.sensitivity import held_contributions
from freerock.rotation.as_measured import as_measured
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT

ALL = "all blocks"  # in place of a block, of the mean over blocks
BUDGET = [*BUDGET_CASE, "parameter", "input", "input_owner", "input_u", "input_unit", "input_stated"]
BUDGET += ["contribution_fraction"]
TOTALS = [
    *CASE,
    "parameter",
    "value",
    "unit",
    "spread_fraction",
    "n_runs",
    "runs_fraction",
    "inputs_fraction",
]
TOTALS += ["u_total", "half95", "first_input", "first_owner", "first_share", "u_total_without_first"]

Spread = Mapping[str, Mapping[str, float]]
"""Foundation: parameter: standard deviation between runs over the mean."""


def plan_budget(
    setups: Iterable[Setup],
    choices: Choices,
    *,
    free: Nuisances = BY_DEFAULT.free,
    debonding: str = "geometric",
) -> pd.DataFrame:
    """What the laboratory's inputs will contribute to the uncertainty of each parameter.

    Parameters
    ----------
    setups, choices, free, debonding
        As for `plan.plan`; a setup without a laboratory has no rows.

    Returns
    -------
    pandas.DataFrame
        A row per block, foundation, laser, duration_s, release_angle_deg, model, parameter and input:
        input, input_owner, input_u, input_unit, input_stated, contribution_fraction (shift of the parameter
        for one standard uncertainty of the input, over its value; NaN where the block overturns or the like).
    """
    rows: list[tuple[Any, ...]] = []
    for setup in different(setups):
        for model in setup.expected:
            rows += _budget_rows(setup, model, choices, FitSettings(free[CANDIDATES[model].law], debonding))
    return pd.DataFrame(rows, columns=BUDGET)


def _budget_rows(
    setup: Setup, model: str, choices: Choices, settings: FitSettings
) -> Iterator[tuple[Any, ...]]:
    """Rows of one model on one setup."""
    if setup.laboratory is None:
        return
    laboratory = replace(setup.laboratory, block=setup.worn(model))
    values = {**setup.expected[model], "width": 2 * laboratory.block.b}
    names = CANDIDATES[model].parameters
    for duration, angle in product(choices.durations_s, setup.release_angles_deg):
        span_s = choices.finger_s, duration
        motion, _ = expected_of(setup, model, angle, span_s, settings.debonding)
        if motion is None:
            shifts = np.full((len(names), len(laboratory.inputs)), np.nan)
        else:
            motion = _as_seen(motion, model, laboratory, values, settings)
            shifts = _shifts(names, motion, model, laboratory, values, settings)
        for name, own in zip(names, shifts, strict=True):
            for source, shift in zip(laboratory.inputs, own, strict=True):
                known = source.name, source.owner, source.u, source.unit, source.stated
                yield (*setup.names, duration, angle, model, name, *known, shift / values[name])


def _as_seen(
    motion: Motion, model: str, laboratory: Laboratory, values: Mapping[str, float], settings: FitSettings
) -> Motion:
    """The expected motion as the laboratory's laser shows it."""
    view = view_of(list(laboratory.lasers.values()), laboratory.block)
    theta = as_measured(
        CANDIDATES[model].law,
        laboratory.block,
        {**values, "theta0": motion.theta0},
        motion.time_s,
        view,
        rules=CANDIDATES[model].rules(settings.debonding),
        solver=Solver(COARSE),
    )
    return replace(motion, theta=theta, view=view)


def _shifts(
    names: Sequence[str],
    motion: Motion,
    model: str,
    laboratory: Laboratory,
    values: Mapping[str, float],
    settings: FitSettings,
) -> Floats:
    """Of some numbers for one standard uncertainty of each input, shape (n_names, n_inputs)."""
    problem = replace(posed(model, (laboratory.block,), (motion,), settings), rtol=COARSE).rough()
    found = held_contributions(problem, problem.start_at(values), laboratory)
    return found.values[[problem.names.index(name) for name in names]]


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
    inputs = {
        case: {(row.input_owner, row.input): row.contribution_fraction for row in rows.itertuples()}
        for case, rows in budget.groupby([*BUDGET_CASE, "parameter"], sort=False)
    }
    known = [_Known(row, inputs, spread) for row in errors.to_dict("records")]
    known = [each for each in known if math.isfinite(each.own) and each.shifts]
    rows = [each.row([each], n) for each in known for n in n_runs]
    together: dict[tuple[Any, ...], dict[str, _Known]] = {}
    for each in known:
        best = together.setdefault(each.of_foundation, {})
        block = each.case["block"]
        if block not in best or each.u(n_runs[-1]) < best[block].u(n_runs[-1]):
            best[block] = each
    for blocks in together.values():
        members = list(blocks.values())
        if len(members) > 1:
            rows += [members[0].row(members, n) for n in n_runs]
    return pd.DataFrame(rows, columns=TOTALS)


class _Known:
    """What one run of a case knows of a parameter; all numbers over its value."""

    def __init__(
        self, row: dict[str, Any], inputs: Mapping[Any, Mapping[tuple[str, str], float]], spread: Spread
    ) -> None:
        self.case = {name: row[name] for name in CASE}
        self.parameter, self.value, self.unit = row["parameter"], row["value"], row["unit"]
        self.spread = spread.get(row["foundation"], {}).get(row["parameter"], 0.0)
        self.own = math.hypot(self.spread, row["stderr"] / self.value)
        key = tuple(row[name] for name in [*BUDGET_CASE, "parameter"])
        self.shifts = dict(inputs.get(key, {}))

    @property
    def of_foundation(self) -> tuple[Any, ...]:
        """What a mean over blocks has in common."""
        of_block = {"block", "laser", "release_angle_deg"}
        return (*(value for name, value in self.case.items() if name not in of_block), self.parameter)

    def u(self, n: int) -> float:
        """Of the mean of n runs."""
        return float(self.row([self], n)["u_total"] / self.value)

    def row(self, members: Sequence["_Known"], n: int) -> dict[str, Any]:
        """Of the mean of n runs of each member."""
        blocks = len(members)
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
        together = {"block": ALL, "laser": "", "release_angle_deg": math.nan} if blocks > 1 else {}
        return {
            **self.case,
            **together,
            "parameter": self.parameter,
            "value": self.value,
            "unit": self.unit,
            "spread_fraction": self.spread,
            "n_runs": n,
            "runs_fraction": runs,
            "inputs_fraction": math.sqrt(of_inputs),
            "u_total": u * self.value,
            "half95": half * self.value,
            "first_input": first,
            "first_owner": owner,
            "first_share": shifts[owner, first] ** 2 / u**2,
            "u_total_without_first": math.sqrt(u**2 - shifts[owner, first] ** 2) * self.value,
        }
