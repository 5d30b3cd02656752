"""Does the total uncertainty hold where the laboratory's inputs are wrong by what it states of them?"""

import math
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.identification.discrepancy import as_measured
from freerock.identification.fit import fit_run
from freerock.identification.settings import FitSettings
from freerock.models.simulate import Solver
from freerock.populations.random_effects import population
from freerock.populations.sensitivity import contributions
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion
from freerock.runs.noise import noise_at_rest
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.virtual_run import RATE_HZ, SEED, T0_STDERR_S, Row, rows_of_all

MODEL, N_RUNS, SCATTER, LONGEST_S = "hunt_crossley", 3, 0.01, 4.0
SIGMA = math.radians(0.006)
CAMPAIGNS = {"full": 300, "small": 2}  # of each kind of instruments
INSTRUMENTS = {  # standard uncertainties
    "caliper": {"block": 3e-5, "mass": 2e-4, "position_m": 2e-4, "scale": 5e-4, "rate": 2e-5},
    "rule": {"block": 3e-4, "mass": 1e-3, "position_m": 6e-4, "scale": 1e-3, "rate": 6e-5},
}


def run(size: str = "full") -> pd.DataFrame:
    """Campaigns of three runs that differ by 1 %, each analysed with inputs that are wrong.

    Every input of a campaign is off by a normal draw of its stated uncertainty; the block is released, seen
    and recorded as it truly is, and analysed as it was stated.

    Parameters
    ----------
    size : str
        "full", or "small" for seconds.

    Returns
    -------
    pandas.DataFrame
        A row per campaign and parameter: instruments ("caliper" or "rule"), block, foundation, parameter,
        error (of the logarithm of the mean), stderr, u_total (of the logarithm), inside (the 95 % interval of
        the total holds the truth), inside_scatter (that of the scatter alone does).
    """
    cases = [(kind, i) for kind in INSTRUMENTS for i in range(CAMPAIGNS[size])]
    return pd.DataFrame(rows_of_all(campaign, cases))


def campaign(case: tuple[str, int]) -> list[Row]:
    """Rows of one campaign."""
    kind, number = case
    generator = np.random.default_rng([SEED, list(INSTRUMENTS).index(kind), number])
    name = list(CONFIGURATIONS)[number % len(CONFIGURATIONS)]
    foundation = list(FOUNDATIONS)[number // len(CONFIGURATIONS) % len(FOUNDATIONS)]
    block, theta0, laser = CONFIGURATIONS[name]
    u = INSTRUMENTS[kind]
    inputs = [Input(name, each, u["block"], True) for each in ("height_m", "width_m")]
    inputs += [Input(name, "mass_kg", u["mass"] * block.mass_kg, True)]
    inputs += [Input("laser", "position_m", u["position_m"], True)]
    inputs += [Input("laser", "scale_fraction", u["scale"], True)]
    inputs += [Input("laser", "sampling_rate_fraction", u["rate"], True)]
    stated = Laboratory(block, {"laser": laser}, tuple(inputs))
    true = stated
    for each in inputs:
        true = true.moved(each, float(generator.standard_normal()))
    truth = FOUNDATIONS[foundation]
    values, errors, shifts = [], [], []
    for _ in range(N_RUNS):
        own = {key: value * math.exp(SCATTER * generator.standard_normal()) for key, value in truth.items()}
        motion = _measured(own, theta0, true, stated, generator)
        fit = fit_run(MODEL, block, motion)
        known = contributions(fit, motion, stated, FitSettings())
        values.append(np.log(fit.value[:2]))
        errors.append(fit.stderr[:2] / fit.value[:2])
        shifts.append(known.values[:2] / fit.value[:2, None])
    return [
        {"instruments": kind, "block": name, "foundation": foundation, "parameter": parameter}
        | _judged(np.array(values)[:, i], np.array(errors)[:, i], np.array(shifts)[:, i], truth[parameter])
        for i, parameter in enumerate(("k", "lambda"))
    ]


def _judged(values: Floats, errors: Floats, shifts: Floats, truth: float) -> Row:
    """The mean of the runs against the truth."""
    known = np.isfinite(errors) & (errors > 0)
    found = population(values[known], errors[known], shifts[known])
    return {
        "error": found.mean - math.log(truth),
        "stderr": found.stderr,
        "u_total": found.u,
        "inside": found.total_low <= math.log(truth) <= found.total_high,
        "inside_scatter": found.low <= math.log(truth) <= found.high,
    }


def _measured(own: Any, theta0: float, true: Laboratory, stated: Laboratory, generator: Any) -> Motion:
    """A run as the laboratory has it, whose inputs are not the true ones."""
    view = view_of(list(true.lasers.values()), true.block)
    time_s = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    values = {**own, "theta0": theta0}
    theta = as_measured(MODEL, true.block, values, time_s * true.clock, view, solver=Solver(1e-9))
    error = SIGMA * generator.standard_normal(theta.size + 4000)
    moving = np.flatnonzero(np.abs(theta) > SIGMA)
    n = min(theta.size, moving[-1] + 200)
    read = true.reread(np.append(theta[:n], theta0), stated)
    return Motion(
        time_s=time_s[:n] + T0_STDERR_S * generator.standard_normal(),
        theta=read[:-1] + error[:n],
        sigma_theta=SIGMA,
        theta0=float(read[-1] + error[-2000:].mean()),
        theta0_stderr=3 * SIGMA / math.sqrt(2000),
        t0_stderr=T0_STDERR_S,
        fit_start_s=0.0,
        noise=noise_at_rest([error[-4000:-2000], error[-2000:]], RATE_HZ),
        view=view_of(list(stated.lasers.values()), stated.block),
    )
