"""The published tables, re-identified: do tables 2 and 3 of Spanos et al. 2017 agree with each other?

The laboratory's records are not public, but its identified models are, and these can be set against one
another (doi:10.1016/j.proeng.2017.09.024).

Table 2. The Hunt-Crossley model with its published parameters is simulated, and Housner's and Winkler's are
identified on that θ(t). Had the Hunt-Crossley model matched the laboratory's record, these would be the
published parameters of the two. Table 2 names no configuration; its figure 3 and table 3 are of
configuration 2, so the values of the other two blocks are those of configuration 2 carried over.

Table 3. √ε_θ is the distance of a model from the record x, ‖θ_model - x‖ / ‖x‖, in the norm of L2. Two models
at distances d₁ and d₂ from the same record are at least |d₁ - d₂| and at most d₁ + d₂ apart, in units of ‖x‖.
That is not published, but the Hunt-Crossley model, at the distance d, bounds it:
‖θ_HC‖/(1 + d) ≤ ‖x‖ ≤ ‖θ_HC‖/(1 - d). Hence, whatever the record was, the ε between two models, in units
of that motion, lies within::

    (|d₁ - d₂| / (1 + d))² ≤ ‖θ₁ - θ₂‖² / ‖θ_HC‖² ≤ ((d₁ + d₂) / (1 - d))²

A pair outside was not identified on one record over the span assumed. Table 3 does not give the final time of
its ε_θ, so several are tried.
"""

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_run
from freerock.models.published import PUBLISHED_BLOCK, TABLE_2, TABLE_3
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS

SAMPLING_HZ = 2000.0
SIGMA_RAD = 1e-6  # the motions are free of noise; sets the integrator's tolerance in the fits
FINAL_TIMES_S = {"full": (2.0, 3.0, 5.0, 8.0), "small": (3.0, 8.0)}
Row = dict[str, object]
COLUMNS = ["table", "block", "foundation", "final_time_s", "model", "against", "quantity", "value"]
COLUMNS += ["published", "low", "high", "agrees", "message"]


def run(size: str = "full") -> pd.DataFrame:
    """Tables 2 and 3 of the paper against what the published models themselves say.

    Three blocks and four final times; in the small size the published block and two.

    Returns
    -------
    pandas.DataFrame
        Rows of `table` 2: a parameter (`quantity`) of `model` identified on the motion of `against`, or the
        ε_θ of that fit, beside the `published` parameter; `message` is the fit's.
        Rows of `table` 3: the ε between `model` and `against`, both with their published parameters, with
        the bounds `low` and `high` and whether it lies within (`agrees`).
    """
    rows: list[Row] = []
    for block in CONFIGURATIONS if size == "full" else (PUBLISHED_BLOCK,):
        for foundation in FOUNDATIONS:
            for final_time_s in FINAL_TIMES_S[size]:
                named = block, foundation, final_time_s
                scene = dict(zip(("block", "foundation", "final_time_s"), named, strict=True))
                rows += [scene | row for row in _reidentified(*named)]
                if block == PUBLISHED_BLOCK:
                    rows += [scene | row for row in _apart(*named)]
    return pd.DataFrame(rows, columns=COLUMNS)


def _reidentified(block: str, foundation: str, final_time_s: float) -> Iterator[Row]:
    time_s = np.arange(0.0, final_time_s, 1 / SAMPLING_HZ)
    shape, theta0, _ = CONFIGURATIONS[block]
    theta = _published_theta("hunt_crossley", block, foundation, time_s)
    motion = Motion(time_s, theta, SIGMA_RAD, theta0)
    for model in ("housner", "winkler"):
        fit = fit_run(model, shape, motion, FitSettings(free=()))
        found = dict(zip(fit.parameters, fit.value, strict=True)) | {"epsilon_theta": fit.epsilon_theta}
        for quantity, value in found.items():
            yield {
                "table": 2,
                "model": model,
                "against": "hunt_crossley",
                "quantity": quantity,
                "value": value,
                "published": TABLE_2[foundation][model].get(quantity),
                "message": fit.message,
            }


def _apart(block: str, foundation: str, final_time_s: float) -> Iterator[Row]:
    time_s = np.arange(0.0, final_time_s, 1 / SAMPLING_HZ)
    theta = {model: _published_theta(model, block, foundation, time_s) for model in TABLE_2[foundation]}
    distance = {model: math.sqrt(epsilon) for model, epsilon in TABLE_3[foundation].items()}
    reference, off = theta["hunt_crossley"], distance["hunt_crossley"]
    for one, other in combinations(theta, 2):
        apart = theta[one] - theta[other]
        epsilon = float(apart @ apart / (reference @ reference))
        low = (abs(distance[one] - distance[other]) / (1 + off)) ** 2
        high = ((distance[one] + distance[other]) / (1 - off)) ** 2
        yield {
            "table": 3,
            "model": one,
            "against": other,
            "quantity": "epsilon_theta",
            "value": epsilon,
            "low": low,
            "high": high,
            "agrees": low <= epsilon <= high,
        }


def _published_theta(model: str, block: str, foundation: str, time_s: Floats) -> Floats:
    shape, theta0, _ = CONFIGURATIONS[block]
    parameters = TABLE_2[foundation][model]
    theta, _ = simulate_theta(model, shape, parameters, time_s, theta0=theta0, solver=Solver(1e-10))
    return theta
