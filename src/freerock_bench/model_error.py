"""What does the identification say of blocks that are not quite what the law says?"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

from freerock.arrays import Floats
from freerock.identification.fit import fit_run
from freerock.models.block import GRAVITY
from freerock.models.contact import Foundation, State, accelerations, contact_force, static_depth
from freerock.models.laws import MODELS
from freerock.planning.cramer_rao import standard_errors
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.virtual_run import (
    LONGEST_S,
    RATE_HZ,
    SEED,
    Row,
    Truth,
    published_truth,
    rows_of_all,
    virtual_motion,
)

RUNS = {"full": 3, "small": 1}  # of each scene and imperfection
CENTRE_OFF_M = 3e-4
FEET = 0.6  # share of the width, in the middle, where an uneven base does not touch


def imperfect_motion(truth: Truth, imperfection: str) -> tuple[Floats, Floats]:
    """θ(t) of a block that is not quite what the law says, by an independent integration.

    Parameters
    ----------
    truth : Truth
        Of the Hunt-Crossley law.
    imperfection : str
        "centre": the centre of mass 0.3 mm off the middle; "uneven": a base that does not touch in the
        middle 60 % of its width; "amplitude": damping from half to one and a half times λ with |θ|/θ₀.

    Returns
    -------
    time_s, theta : ndarray, shape (n_time,)
        [s, rad]
    """
    block, k, lam = truth.block, truth.parameters["k"], truth.parameters["lambda"]
    m, h = block.mass_kg, block.h
    middle = replace(block, contact_width_m=FEET * block.width_m)

    def rates(_: float, y: Floats) -> list[float]:
        state = State(*y)
        _, v, theta, w = state
        damping = lam * (0.5 + abs(theta / truth.theta0)) if imperfection == "amplitude" else lam
        a, turn = accelerations(block, Foundation(k, lam=damping), state)
        force = moment = 0.0
        if imperfection == "centre":
            moment = -m * GRAVITY * CENTRE_OFF_M * math.cos(theta)
        elif imperfection == "uneven":
            force, moment = (-x for x in contact_force(middle, Foundation(k, lam=lam), state))
        arm = h * math.sin(theta)
        more = (arm * force - moment) / (block.inertia_base - m * arm * arm)
        return [v, a - force / m - arm * more, w, turn + more]

    time_s = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    start = [static_depth(block, Foundation(k), truth.theta0), 0.0, truth.theta0, 0.0]
    motion = solve_ivp(rates, (0, LONGEST_S), start, "DOP853", time_s, rtol=1e-7, atol=1e-11)
    return time_s, motion.y[2]


def run(size: str = "full") -> pd.DataFrame:
    """What the identification says of blocks that are not quite what the law says.

    Returns
    -------
    pandas.DataFrame
        One row per run and parameter of the Hunt-Crossley law: block, foundation, imperfection, run, success,
        detected (the residual test says that the law is not the whole truth), widened (standard error over
        the Cramér-Rao bound), error (of the parameter in standard errors), error_percent and epsilon_theta.
    """
    cases = [
        (block, foundation, imperfection, i)
        for block in (CONFIGURATIONS if size == "full" else ["config3"])
        for foundation in FOUNDATIONS
        for imperfection in ("none", "centre", "uneven", "amplitude")
        for i in range(RUNS[size])
    ]
    return pd.DataFrame(rows_of_all(_model_error, cases))


def _model_error(case: Any) -> list[Row]:
    block, foundation, imperfection, i = case
    truth = published_truth(block, foundation, "hunt_crossley")
    exact = imperfect_motion(truth, imperfection)
    key = (3, list(CONFIGURATIONS).index(block), list(FOUNDATIONS).index(foundation), i)
    motion = virtual_motion(truth, np.random.default_rng([SEED, *key]), exact)
    assert motion is not None  # given, not simulated
    fit = fit_run("hunt_crossley", truth.block, motion)
    bound = standard_errors(
        "hunt_crossley",
        truth.block,
        truth.parameters,
        exact[0][: len(motion.time_s)],
        truth.theta0,
        truth.sigma_theta,
    )
    detected = not fit.diagnostics["noise"]
    return [
        {
            "block": block,
            "foundation": foundation,
            "imperfection": imperfection,
            "run": i,
            "parameter": name,
            "success": fit.success,
            "detected": detected,
            "widened": fit.stderr[j] / bound[name],
            "error": (fit.value[j] - truth.parameters[name]) / fit.stderr[j],
            "error_percent": 100 * (fit.value[j] / truth.parameters[name] - 1),
            "epsilon_theta": fit.epsilon_theta,
        }
        for j, name in enumerate(MODELS["hunt_crossley"])
    ]
