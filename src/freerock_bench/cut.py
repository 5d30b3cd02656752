"""Are the numbers of a run that begins in motion as certain as stated?

Free golden scenes of the Hunt-Crossley law, cut at any instant of the first swings, with white noise: the
run is found by `start: motion`, its law identified, and k, λ, and the angle and rate at the first sample used
are compared with the truth.

    python -m freerock_bench.cut results/studies/cut.csv full docs/validation.md
"""

import math
import re
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.config.keys_of_processing import RunLimits
from freerock.errors import FreerockError
from freerock.identification.fit import fit_run
from freerock.runs.motion import motion_of
from freerock.runs.segment import find_runs
from freerock_bench.golden.ours import response
from freerock_bench.golden.scenes import Scene, scenes
from freerock_bench.harness import NUMBERS, Study, number_row
from freerock_bench.virtual_run import SEED, Row

CASE = "cut"
SIZES = {"small": 4, "full": 200}
RATE_HZ, AFTER_S, REST_S = 500.0, 6.0, 1.0
SIGMA = math.radians(0.006)
LATEST_S = 1.2  # of the cut, since the release
EXACT = 1e-11  # rtol
STEPS = 1e-4  # of the fitted numbers, relative, for the propagation of their covariance


def _row(number: int) -> list[Row]:
    wanted = re.compile("hunt_crossley_geometric_.*_free")
    free = [scene for name, scene in scenes().items() if wanted.search(name)]
    scene, draw = free[number % len(free)], np.random.default_rng([SEED, 43, number])
    cut_s = float(draw.uniform(0.03, LATEST_S))
    of_case = {"scene": scene.name, "run": number, "cut_s": cut_s}
    truth = response(scene, np.arange(0, AFTER_S, 1 / RATE_HZ) + cut_s, EXACT)
    rest = np.zeros(round(REST_S * RATE_HZ))
    theta = np.append(np.nan_to_num(truth.theta), rest)
    clock = np.arange(theta.size) / RATE_HZ
    theta = theta + draw.normal(0, SIGMA, theta.size)
    try:
        found = find_runs(
            clock, theta, SIGMA, np.zeros(theta.size), scene.block, limits=RunLimits(start="motion")
        )[0]
        motion = motion_of(found, clock, theta)
        model = scene.law + ("_pivoting" if scene.kinematics == "pivoting" else "")
        fit = fit_run(model, scene.block, motion)
    except FreerockError as error:
        return [of_case | {"case": CASE, "parameter": "refused", "what": str(error)}]
    begun = response(scene, np.array([cut_s + found.fit_start_s]), EXACT)
    states = _states(scene, found.fit_start_s - found.release_s, fit.value, fit.covariance)
    expected = {**scene.parameters, "theta_start": begun.theta[0], "rate_start": begun.theta_rate[0]}
    values = {name: (fit.values[name], fit.stderr[fit.parameters.index(name)]) for name in scene.parameters}
    values |= dict(zip(("theta_start", "rate_start"), states, strict=True))
    return [
        of_case | number_row(CASE, name, expected[name], value, stderr if fit.success else math.nan)
        for name, (value, stderr) in values.items()
    ]


def _states(scene: Scene, start_s: float, value: Floats, covariance: Floats) -> Any:
    """θ [rad] and its rate [rad/s] at the first instant used, each with its standard error."""

    def at(numbers: Floats) -> Floats:
        k, damping, theta0, t0 = numbers
        moved = replace(scene, parameters={"k": k, "lambda": damping}, theta0=float(theta0))
        found = response(moved, np.array([abs(start_s - t0)]), EXACT)  # before the top as after it
        return np.array([found.theta[0], np.sign(start_s - t0) * found.theta_rate[0]])

    centre = at(value)
    steps = np.diag(STEPS * np.array([value[0], value[1], abs(value[2]), 1e-1]))
    slopes = np.array([(at(value + step) - at(value - step)) / (2 * step.max()) for step in steps])
    stderr = np.sqrt(np.diag(slopes.T @ covariance @ slopes))
    return [*zip(centre.tolist(), stderr.tolist(), strict=True)]


STUDY = Study(lambda size: range(SIZES[size]), _row, [*NUMBERS, "scene", "run", "cut_s", "what"], "cut")

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
