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
from freerock.populations.means import Key
from freerock.populations.random_effects import LEVEL
from freerock.rotation.as_measured import as_measured
from freerock.rotation.laboratory import Input
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion

ALL = "all blocks"  # in place of a block, of the mean over blocks
OVER_BLOCKS = {"block": ALL, "laser": "", "release_angle_deg": math.nan}  # columns of such a mean
NOISE = "noise"  # in place of an input
BUDGET = [*CASE_COLUMNS, "parameter", "input", "input_owner", "input_u", "input_unit", "input_stated"]
BUDGET += ["contribution_fraction"]
TOTALS = [*CASE_COLUMNS, "parameter", "value", "unit", "spread_fraction", "n_runs", "runs_fraction"]
TOTALS += ["inputs_fraction", "u_total", "half95"]
TOTALS += ["first_input", "first_owner", "first_share", "u_total_without_first"]

Spread = Mapping[str, Mapping[str, float]]
"""Foundation: parameter: standard deviation between runs over the mean."""


class Known(NamedTuple):
    """What one run of a case will tell of a parameter.

    Parameters
    ----------
    case : tuple
        As `CASE_COLUMNS` has it.
    parameter : str
    inputs : tuple of Input
        Of the laboratory.
    parts : ndarray, shape (1 + n_inputs, n_inputs + 1)
        Over the value: shift by one standard uncertainty of each input; last, the standard error by noise.
        The first row has the inputs as stated; of the others each has one of the inputs exact. NaN where the
        block overturns, the sensor can't follow it or the run does not determine the parameter.
    """

    case: tuple[Any, ...]
    parameter: str
    inputs: tuple[Input, ...]
    parts: Floats


def plan_known(setups: Iterable[Setup], choices: Choices) -> list[Known]:
    """What one run of each case of `plan.plan` will tell of each parameter; arguments as there."""
    found = list[Known]()
    for setup, model, duration, angle in cases_of(setups, choices):
        inputs, names = setup.laboratory.inputs, CANDIDATES[model].parameters
        motion = expected_of(setup, model, duration, angle, choices)
        seen = [
            (case[:-1], math.nan if off else sigma / math.sqrt(rate))
            for rate in choices.sampling_rates_hz
            for case, sigma, off in with_each_sensor(setup, model, duration, angle, rate, choices)
        ]
        best, levels = None, [level for _, level in seen if math.isfinite(level)]
        if levels and not isinstance(motion, FreerockError):
            best = _expected_fit(motion, model, setup, min(levels), choices.settings_of(model))
        for case, level in seen:
            parts = np.full((len(names), len(inputs) + 1, len(inputs) + 1), np.nan)
            if best and math.isfinite(level):
                parts = _parts(best, names, level)
            found += [Known(case, *each) for each in zip(names, [inputs] * len(names), parts, strict=True)]
    return found


def _expected_fit(motion: Motion, model: str, setup: Setup, level: float, settings: FitSettings) -> Posterior:
    """The linear model of a fit of the expected motion, as the laser shows it; noise level in rad/√Hz."""
    candidate, laboratory = CANDIDATES[model], replace(setup.laboratory, block=setup.worn(model))
    values = {"width": 2 * laboratory.block.b, **setup.expected[model], "theta0": motion.theta0}
    view = view_of(list(laboratory.lasers.values()), laboratory.block)
    rules, solver = candidate.rules(settings.debonding), Solver(RTOL_RESIDUAL)
    theta = as_measured(
        candidate.law, laboratory.block, values, motion.time_s, view, rules=rules, solver=solver
    )
    sigma = level * math.sqrt(_rate_hz(motion.time_s))
    seen = replace(motion, theta=theta, view=view, laboratory=laboratory, sigma_theta=sigma)
    problem = replace(posed(model, (laboratory.block,), (seen,), settings), rtol=RTOL_RESIDUAL).rough()
    nuisances = Nuisances.of(problem)
    return at(nuisances, problem.start_at(values), np.zeros(len(nuisances.sources)), problem.samples())


def _rate_hz(time_s: Floats) -> float:
    return float(1 / (time_s[1] - time_s[0]))


def _parts(best: Posterior, names: Sequence[str], level: float) -> Floats:
    """The parts of `Known` of each parameter, shape (n_names, 1 + n_inputs, n_inputs + 1).

    The estimate is linear in noise and priors: what the centre of a prior shifts is a column of S, the
    covariance of numbers and inputs. An exact input j leaves S - S_j S_jᵀ / S_jj (conditional normal).
    """
    n, problem, motion = int(best.free.sum()), best.problem, best.problem.motions[0]
    sigma, gradient = level * math.sqrt(_rate_hz(best.samples.time_s)), problem.gradient(best.x)[:, best.free]
    rows = np.vstack([best.columns / sigma, best.prior[1]])
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0] = 1.0  # what the run does not tell
    spread = np.linalg.pinv((rows / scale).T @ (rows / scale), hermitian=True) / np.outer(scale, scale)
    inputs = motion.laboratory.inputs if motion.laboratory else ()
    wanted, value = [problem.names.index(name) for name in names], problem.physical(best.x)
    told = np.any(best.columns[:, :n], axis=0)
    told_of = np.isin(wanted, np.flatnonzero(best.free)[told])

    def parts(covariance: Floats) -> Floats:
        of_inputs = np.zeros((len(best.x), len(best.z)))
        of_inputs[best.free] = covariance[:n, n:]
        of_noise = covariance[:n, :n] - covariance[:n, n:] @ covariance[n:, :n]
        errors = np.sqrt(np.maximum(np.diag(gradient @ of_noise @ gradient.T), 0.0))
        shifts = contributed(best.nuisances, best.x, of_inputs).values
        of_value = np.column_stack([shifts, errors])[wanted] / value[wanted, None]
        return np.where(told_of[:, None], of_value, np.nan)

    found = [stated := parts(spread)]
    for j, source in enumerate(inputs):
        exact = np.array(stated)
        if source in best.nuisances.sources:
            k = n + best.nuisances.sources.index(source)
            exact = parts(spread - np.outer(spread[:, k], spread[k]) / spread[k, k])
        exact[:, j] = np.where(told_of, 0.0, np.nan)
        found.append(exact)
    return np.stack(found, axis=1)


def plan_budget(known: Iterable[Known]) -> pd.DataFrame:
    """What the laboratory's inputs and the noise will contribute to the uncertainty of each parameter.

    Parameters
    ----------
    known : iterable of Known
        From `plan_known`.

    Returns
    -------
    pandas.DataFrame
        A row per case of `plan.plan`, parameter and input: input, input_owner, input_u, input_unit,
        input_stated, contribution_fraction (shift of the parameter for one standard uncertainty of the input,
        over its value); and a row of the input "noise" (standard error by that of one run, over the value).
    """
    rows: list[tuple[Any, ...]] = []
    for each in known:
        for source, shift in zip(each.inputs, each.parts[0], strict=False):
            of = source.name, source.owner, source.u, source.unit, source.stated
            rows.append((*each.case, each.parameter, *of, shift))
        rows.append((*each.case, each.parameter, NOISE, "", math.nan, "", None, each.parts[0, -1]))
    return pd.DataFrame(rows, columns=BUDGET)


def plan_totals(
    errors: pd.DataFrame, known: Iterable[Known], n_runs: Sequence[int], spread: Spread
) -> pd.DataFrame:
    """Total uncertainty of a mean over n runs of a block, and over as many of each block of a foundation.

    Of all blocks together each has the laser and angle by which it knows the parameter best. Inputs that
    blocks share shift their mean as they shift each of them; those of their own cancel in part.

    Parameters
    ----------
    errors : pandas.DataFrame
        From `plan.plan`.
    known : iterable of Known
        From `plan_known`.
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
        (the input without whose uncertainty u is least; "" where there is none), u_total_without_first (u
        were it exact), first_share (the share of u² that goes with it, as a fraction).
    """
    parts = {(*each.case, each.parameter): (each.inputs, each.parts) for each in known}
    members = list[_Member]()
    for row in errors.to_dict("records"):
        inputs, own = parts[*(row[name] for name in CASE_COLUMNS), row["parameter"]]
        between = spread.get(row["foundation"], {}).get(row["parameter"], 0.0)
        if math.isfinite(row["stderr"]) and np.isfinite(own).all():
            keys = [(each.owner, each.name) for each in inputs]
            members.append(_Member(row | {"spread_fraction": between}, between, keys, own))
    rows = [_mean([each], n) for each in members for n in n_runs]
    together: dict[tuple[Any, ...], dict[str, list[_Member]]] = {}
    alike = [name for name in [*CASE_COLUMNS, "parameter"] if name not in OVER_BLOCKS]
    for each in members:
        blocks = together.setdefault(tuple(each.row[name] for name in alike), {})
        blocks.setdefault(each.row["block"], []).append(each)
    for blocks in together.values():
        best = [
            min(own, key=lambda each: _mean([each], n_runs[-1])["u_total"] / each.row["value"])
            for own in blocks.values()
        ]
        if len(best) > 1:
            rows += [_mean(best, n) for n in n_runs]
    return pd.DataFrame(rows, columns=TOTALS)


class _Member(NamedTuple):
    """A case of `plan.plan`: its row, the spread between its runs, its inputs and the parts of `Known`."""

    row: Mapping[str, Any]
    between: float
    keys: Sequence[Key]
    parts: Floats

    def at(self, exact: Key | None) -> tuple[float, Mapping[Key, float]]:
        """Standard uncertainty of a run by noise and spread, and the shifts, were an input exact."""
        *shifts, noise = self.parts[1 + self.keys.index(exact) if exact in self.keys else 0].tolist()
        return math.hypot(self.between, noise), dict(zip(self.keys, shifts, strict=True))


def _mean(members: Sequence[_Member], n: int) -> dict[str, Any]:
    """Of the mean of n runs of each member."""
    blocks, row = len(members), members[0].row

    def total(exact: Key | None) -> tuple[float, float]:
        """Its uncertainty by runs and by inputs, were an input exact."""
        of_runs, shifts = 0.0, dict[Key, float]()
        for own, by in (each.at(exact) for each in members):
            of_runs += own**2 / n / blocks**2
            for key, shift in by.items():
                shifts[key] = shifts.get(key, 0.0) + shift / blocks
        return math.sqrt(of_runs), math.sqrt(sum(shift**2 for shift in shifts.values()))

    runs, inputs = total(None)
    u = math.hypot(runs, inputs)
    known = {key: math.hypot(*total(key)) for each in members for key in each.keys}
    owner, first = min(known, key=lambda key: known[key], default=("", ""))
    least = known.get((owner, first), u)
    dof = blocks * (n - 1) * (u / runs) ** 4 if runs > 0 else math.inf
    half = t.ppf((1 + LEVEL) / 2, dof) * u if dof > 0 else math.nan
    return {
        **row,
        **(OVER_BLOCKS if blocks > 1 else {}),
        "n_runs": n,
        "runs_fraction": runs,
        "inputs_fraction": inputs,
        "u_total": u * row["value"],
        "half95": half * row["value"],
        "first_input": first,
        "first_owner": owner,
        "first_share": 1 - (least / u) ** 2 if u else 0.0,
        "u_total_without_first": least * row["value"],
    }
