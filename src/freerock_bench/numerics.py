"""How methods behave as numerical methods: order of convergence, drift of energy, chattering near rest.

Configuration 2 on marble (Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024), released from 10°.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.models.contact import Foundation, energy
from freerock.models.housner import housner_swings
from freerock.models.simulate import Solver, simulate
from freerock_bench.engines import problem_of
from freerock_bench.golden.files import read_golden
from freerock_bench.methods.by_name import HOUSNER_METHODS, METHODS, TIME_STEPPING, freerock
from freerock_bench.methods.foundation import stepped_states
from freerock_bench.methods.housner import housner_eventless
from freerock_bench.methods.problem import Problem

COLUMNS = ["part", "model", "method", "setting", "x", "y", "order"]
X = {  # what x and y are, by part
    "order": ("evaluations, or series of freerock, per second of motion", "relative error of θ"),
    "energy": ("time / s", "relative error of the energy"),
    "chattering": ("time to rest / s", "largest |θ| from then on / rad"),
}
STEPS_S = {"full": 2e-3 / 2 ** np.arange(0, 8), "small": 2e-3 / 2 ** np.arange(0, 3)}
RTOLS = {"full": 10.0 ** -np.arange(2, 13), "small": 10.0 ** -np.arange(4, 7)}
ENERGY_STEP_S, ENERGY_EVERY_S = 5e-4, 0.05
ENERGY_SPAN_S = {"full": 20.0, "small": 1.0}
REST_STEPS_S = {"full": (1e-3, 1e-4, 1e-5), "small": (1e-3,)}
Row = dict[str, Any]


def run(size: str = "full") -> pd.DataFrame:
    """Curves of the three parts.

    Returns
    -------
    pandas.DataFrame
        Columns part ("order", "energy", "chattering"), model, method, setting, x and y, which `X` names;
        order, the slope of a ladder of the first part.
    """
    rows = [*_order(size), *_energy(size), *_chattering(size)]
    frame = pd.DataFrame(rows, columns=COLUMNS)
    ladders = frame[frame["part"] == "order"].groupby(["model", "method"])
    for _, points in ladders:
        frame.loc[points.index, "order"] = _slope(points)
    return frame


def _slope(points: pd.DataFrame) -> float:
    """Order of a method: the slope of its curve by least squares, for errors between 1e-12 and 1e-4."""
    inside = points[(points["y"] > 1e-12) & (points["y"] < 1e-4)]
    if len(inside) < 2:
        return math.nan
    return -float(np.polyfit(np.log(inside["x"]), np.log(inside["y"]), 1)[0])


def _order(size: str) -> Iterator[Row]:
    """Error over the work of a run of 1 s, over which the block meets its base twice."""
    for model in ("winkler", "hunt_crossley"):
        problem = problem_of(model, "geometric")
        golden = read_golden()[f"config2_marble_{model}_geometric_guided_free"]
        time, true = golden.time_s[:101], golden.theta_rad[:101]
        ladders = [("freerock", freerock, RTOLS[size])]
        ladders += [(name, method, STEPS_S[size]) for name, method in TIME_STEPPING.items()]
        if size == "full":
            ladders.append(("SciPy DOP853", METHODS["SciPy DOP853, numba"], RTOLS[size][1:]))
        for name, method, settings in ladders:
            for setting in settings.tolist():
                found = method(problem, time, setting)
                if found.outcome == "completed":
                    error = float(np.linalg.norm(found.theta - true) / np.linalg.norm(true))
                    yield _row("order", model, name, setting, found.evaluations / float(time[-1]), error)


def _energy(size: str) -> Iterator[Row]:
    """Error of the energy of a block on a bed without damping, in parts of the energy at the release."""
    damped = problem_of("winkler", "geometric")
    problem = replace(damped, parameters={"k": damped.parameters["k"], "c": 0.0})
    steps = round(ENERGY_EVERY_S / ENERGY_STEP_S)
    intervals = round(ENERGY_SPAN_S[size] / ENERGY_EVERY_S)
    time: Floats = ENERGY_EVERY_S * np.arange(intervals + 1, dtype=float)
    for rtol in (1e-6, 1e-8, 1e-10):
        response = simulate(
            "winkler", problem.block, problem.parameters, time, theta0=problem.theta0, solver=Solver(rtol)
        )
        states = np.stack([response.z_cb, response.z_cb_rate, response.theta, response.theta_rate])
        yield from _drift(problem, "freerock", f"rtol {rtol:g}", time, states)
    for name in TIME_STEPPING:
        states = stepped_states(name, problem, ENERGY_STEP_S, steps, intervals)
        yield from _drift(problem, name, f"step {1e3 * ENERGY_STEP_S:g} ms", time, states)


def _drift(problem: Problem, method: str, setting: str, time: Floats, states: Floats) -> Iterator[Row]:
    foundation = Foundation.of(problem.parameters)
    total = np.asarray(energy(problem.block, foundation, *states))
    for t, error in zip(time[1:], np.abs(total[1:] / total[0] - 1), strict=True):
        yield _row("energy", "winkler", method, setting, float(t), float(error))


def _chattering(size: str) -> Iterator[Row]:
    """What is left of Housner's motion as its infinitely many impacts come to their end."""
    problem = problem_of("housner", "")
    rest = rest_time(problem)
    before = np.geomspace(rest, 1e-5, 200 if size == "full" else 20)
    time = np.unique(np.concatenate([rest - before, np.linspace(0, rest, 4000), [rest, rest + 0.5]]))
    ladders = [("freerock", "closed form", freerock(problem, time, 1e-8).theta)]
    for rtol in (1e-6, 1e-10) if size == "full" else (1e-6,):
        found = HOUSNER_METHODS["SciPy DOP853, events"](problem, time, rtol)
        ladders.append(("SciPy DOP853, events", f"rtol {rtol:g}", found.theta))
    for step in REST_STEPS_S[size]:
        found = housner_eventless(problem, time, step)
        ladders.append(("Runge–Kutta without events", f"step {1e3 * step:g} ms", found.theta))
    for name, setting, theta in ladders:
        ahead = np.maximum.accumulate(np.abs(theta)[::-1])[::-1]
        for each in before:
            left = float(ahead[np.searchsorted(time, rest - each)])
            yield _row("chattering", "housner", name, setting, float(each), left)


def rest_time(problem: Problem) -> float:
    """When Housner's block is at rest after infinitely many impacts [s]."""
    swings = housner_swings(problem.block, problem.parameters["r"], problem.theta0, 0.0, 100.0, 10**6)
    return float(swings.rest_time)


def _row(part: str, model: str, method: str, setting: object, x: float, y: float) -> Row:
    values = (part, model, method, setting, x, y, math.nan)
    return dict(zip(COLUMNS, values, strict=True))
