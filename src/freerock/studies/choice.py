"""Does the choice of model name the law that made a run?"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit, fit_run
from freerock.identification.ladder import BY_DEFAULT, identify_run
from freerock.models.laws import LAWS, MODELS, PAPER_MODELS
from freerock.models.simulate import simulate
from freerock.runs.motion import Motion
from freerock.studies.virtual_run import Row, Truth, draw_truth, drawn_run, rows_of_all

RUNS = {"full": 300, "small": 3}  # of each law
LADDER = replace(BY_DEFAULT, kinematics=())  # the laws as the paper has them
NEAR = 30.0  # distance of two laws [σ] below which it is found without noise


def run(size: str = "full") -> pd.DataFrame:
    """Whether the choice of model names the law that made a run.

    Returns
    -------
    pandas.DataFrame
        One row per case: model (the true law), chosen, rival (the nearest other law that is no larger),
        distance (between the true motion and the rival's best, in σ: √Σ(Δθ)²/σ; inf where no other law is
        as small or its fit fails), reason.
    """
    cases = [(model, i) for model in LAWS for i in range(RUNS[size])]
    return pd.DataFrame(rows_of_all(_choice, cases))


def _draw_any(model: str, noises: Sequence[str], generator: np.random.Generator) -> Truth:
    """As `draw_truth`; of the general law one damping as there, of the other anything down to a trace."""
    if model != "general":
        return draw_truth(model, noises, generator)
    main, other = ("winkler", "hunt_crossley")[:: generator.choice([-1, 1])]
    truth, trace = draw_truth(main, noises, generator), draw_truth(other, noises, generator).parameters
    (name,) = set(trace) - {"k"}
    k = truth.parameters["k"]
    added = k * trace[name] / trace["k"] * 10 ** generator.uniform(-4, 0)
    return replace(truth, model="general", parameters={**truth.parameters, name: added})


def _choice(case: Any) -> list[Row]:
    model, i = case
    truth, motion, _ = drawn_run(model, ("white",), (4, list(LAWS).index(model), i), _draw_any)
    found = identify_run(truth.block, motion, LADDER)
    answer = found.choice(LADDER)
    distance, rival = _nearest_rival(truth, motion, found.fits)
    return [
        {
            "model": model,
            "case": i,
            "sigma_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "chosen": answer.selected,
            "rival": rival,
            "distance": distance,
            "reason": answer.reason,
        }
    ]


def _nearest_rival(truth: Truth, motion: Motion, fits: Mapping[str, Fit]) -> tuple[float, str]:
    """Distance [σ] of the true motion from the best of another law that is no larger, and that law."""
    model = truth.model
    response = simulate(
        model, truth.block, truth.parameters, motion.time_s - motion.time_s[0], theta0=truth.theta0
    )
    exact = replace(motion, time_s=response.time, theta=response.theta, theta0=truth.theta0)
    distance, rival = math.inf, ""
    for law in PAPER_MODELS:
        if law == model or len(MODELS[law]) > len(MODELS[model]) or not fits[law].success:
            continue
        # the squared residual exceeds that of noise by the squared distance, give or take a few σ²
        excess = np.sum(fits[law].residual ** 2) / truth.sigma_theta**2 - len(exact.theta)
        apart = math.sqrt(max(0.0, excess))
        if apart < NEAR:
            apart = np.sqrt(np.sum(fit_run(law, truth.block, exact).residual ** 2)) / truth.sigma_theta
        if apart < distance:
            distance, rival = float(apart), law
    return distance, rival
