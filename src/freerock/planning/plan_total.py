"""How many runs, blocks and angles, and what to measure better first: total uncertainty before any test.

What n runs tell of a number is uncertain by

    u² = (τ² + s²)/n + Σ c_i²,

with τ the spread between runs, s the standard error of one by its noise, and c_i the contributions of the
laboratory's inputs, which are the same in all runs (JCGM 100:2008, 5.1 and 5.2). More runs make the first
term smaller and nothing else. s and c_i are those of a fit that adjusts the inputs within their priors, as
the analysis does (`identification.inputs_with_priors`), from the linear model of the expected run.
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
from freerock.identification.inputs_with_priors import Nuisances, Posterior, at, contributed
from freerock.identification.problem import RTOL_RESIDUAL
from freerock.identification.start import posed
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver
from freerock.planning.plan import CASE_COLUMNS, Choices, Setup, cases_of, expected_of, with_each_sensor
from freerock.populations.random_effects import LEVEL
from freerock.rotation.as_measured import as_measured
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion

ALL = "all blocks"  # in place of a block, of the mean over blocks
OVER_BLOCKS = {"block": ALL, "laser": "", "release_angle_deg": math.nan}  # columns of such a mean
BUDGET = [*CASE_COLUMNS, "parameter", "input", "input_owner", "input_u", "input_unit", "input_stated"]
BUDGET += ["contribution_fraction", "noise_fraction"]
TOTALS = [*CASE_COLUMNS, "parameter", "value", "unit", "spread_fraction", "n_runs", "runs_fraction"]
TOTALS += ["inputs_fraction", "u_total", "half95"]
TOTALS += ["first_input", "first_owner", "first_share", "u_total_without_first"]

Spread = Mapping[str, Mapping[str, float]]
"""Foundation: parameter: standard deviation between runs over the mean."""


def plan_budget(setups: Iterable[Setup], choices: Choices) -> pd.DataFrame:
    """What the laboratory's inputs and the noise will contribute to the uncertainty of each parameter.

    Parameters
    ----------
    setups, choices
        As for `plan.plan`.

    Returns
    -------
    pandas.DataFrame
        A row per case of `plan.plan`, parameter and input: input, input_owner, input_u, input_unit,
        input_stated, contribution_fraction (shift of the parameter for one standard uncertainty of the input,
        over its value), noise_fraction (standard error of the parameter by the noise of one run, over its
        value). Both are NaN where the block overturns or the like.
    """
    rows: list[tuple[Any, ...]] = []
    for setup, model, duration, angle in cases_of(setups, choices):
        inputs, names = setup.laboratory.inputs, CANDIDATES[model].parameters
        motion = expected_of(setup, model, duration, angle, choices)
        seen = [
            (case[:-1], sigma / math.sqrt(rate))
            for rate in choices.sampling_rates_hz
            for case, sigma, _ in with_each_sensor(setup, model, duration, angle, rate, choices)
        ]
        best, levels = None, [level for _, level in seen if math.isfinite(level)]
        if levels and not isinstance(motion, FreerockError):
            best = _expected_fit(motion, model, setup, min(levels), choices.settings_of(model))
        for case, level in seen:
            known = np.full((len(names), len(inputs) + 1), np.nan)
            if best and math.isfinite(level):
                known = _known(best, names, level)
            for name, own in zip(names, known, strict=True):
                for source, shift in zip(inputs, own, strict=False):
                    of = source.name, source.owner, source.u, source.unit, source.stated
                    rows.append((*case, name, *of, shift, own[-1]))
    return pd.DataFrame(rows, columns=BUDGET)


def _expected_fit(motion: Motion, model: str, setup: Setup, level: float, settings: FitSettings) -> Posterior:
    """The linear model of a fit of the expected motion, as the laser shows it; noise level in rad/√Hz."""
    candidate, laboratory = CANDIDATES[model], replace(setup.laboratory, block=setup.worn(model))
    values = {"width": 2 * laboratory.block.b, **setup.expected[model], "theta0": motion.theta0}
    view = view_of(list(laboratory.lasers.values()), laboratory.block)
    rules, solver = candidate.rules(settings.debonding), Solver(RTOL_RESIDUAL)
    theta = as_measured(
        candidate.law, laboratory.block, values, motion.time_s, view, rules=rules, solver=solver
    )
    sigma = level / math.sqrt(float(motion.time_s[1] - motion.time_s[0]))
    seen = replace(motion, theta=theta, view=view, laboratory=laboratory, sigma_theta=sigma)
    problem = replace(posed(model, (laboratory.block,), (seen,), settings), rtol=RTOL_RESIDUAL).rough()
    nuisances = Nuisances.of(problem)
    return at(nuisances, problem.start_at(values), np.zeros(len(nuisances.sources)), problem.samples())


def _known(best: Posterior, names: Sequence[str], level: float) -> Floats:
    """Shifts by each input and, last, the standard error by noise, both over the value; a row a parameter.

    The estimate is linear in noise and priors (`identification.intervals.uncertainty`).
    """
    n, n_z, problem = int(best.free.sum()), len(best.z), best.problem
    sigma = level / math.sqrt(float(best.samples.time_s[1] - best.samples.time_s[0]))
    rows, prior = best.columns / sigma, best.prior[1]
    information = rows.T @ rows + prior.T @ prior
    scale = np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    spread = np.linalg.pinv(information / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    release = prior[: len(prior) - n_z]
    of_noise = spread @ (rows.T @ rows + release.T @ release) @ spread
    of_inputs, gradient = np.zeros((len(best.x), n_z)), problem.gradient(best.x)[:, best.free]
    of_inputs[best.free] = spread[:n, n:]
    shifts = contributed(best.nuisances, best.x, of_inputs).values
    errors = np.sqrt(np.diag(gradient @ of_noise[:n, :n] @ gradient.T))
    wanted, value = [problem.names.index(name) for name in names], problem.physical(best.x)
    return np.column_stack([shifts, errors])[wanted] / value[wanted, None]


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
        (without its contribution).
    """
    of_parameter = [*CASE_COLUMNS, "parameter"]
    inputs = {
        case: {(row.input_owner, row.input): row.contribution_fraction for row in rows.itertuples()}
        for case, rows in budget.groupby(of_parameter, sort=False)
    }
    noise = budget.groupby(of_parameter)["noise_fraction"].first().to_dict()
    known = list[_Known]()
    for row in errors.to_dict("records"):
        between = spread.get(row["foundation"], {}).get(row["parameter"], 0.0)
        case = tuple(row[name] for name in of_parameter)
        own, shifts = math.hypot(between, noise.get(case, math.nan)), inputs.get(case, {})
        if math.isfinite(own) and math.isfinite(row["stderr"]) and shifts:
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
