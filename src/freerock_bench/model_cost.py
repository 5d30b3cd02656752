"""What each model costs, and what discrepancy it reaches."""

import math
from functools import partial

import numpy as np
import pandas as pd

from freerock.identification.discrepancy import epsilon_theta
from freerock.identification.fit import fit_run
from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion
from freerock_bench.methods.by_name import freerock
from freerock_bench.scenes import ROUNDS, SAMPLING_HZ, SPAN_S, scenes
from freerock_bench.timing import interleaved

SIGMA_DEG = 0.01  # noise of the records the models are fitted to


def run(size: str = "full") -> pd.DataFrame:
    """What each model costs and reaches on noisy records moved by the Hunt-Crossley law.

    Six scenes, or one in the small size.

    Returns
    -------
    pandas.DataFrame
        Columns block, foundation, model, n_parameters (of the model), n_free (with nuisances),
        epsilon_theta, noise_epsilon (ε_θ of the noise alone), time_s (of one run at the fit's
        tolerance), rtol, success.
    """
    sampled = np.arange(0.0, SPAN_S[size], 1 / SAMPLING_HZ)
    sigma = math.radians(SIGMA_DEG)
    rows: list[dict[str, object]] = []
    for (block, foundation, law), scene in scenes(size).items():
        if law != "hunt_crossley":
            continue
        theta = freerock(scene, sampled, 1e-10).theta
        noise = np.random.default_rng(len(rows)).normal(0, sigma, sampled.size)
        motion = Motion(sampled, theta + noise, sigma, scene.theta0, theta0_stderr=sigma)
        for model in PAPER_MODELS:
            fit = fit_run(model, scene.block, motion)
            found = dict(zip(fit.parameters, fit.value, strict=True))
            run = partial(
                simulate_theta,
                model,
                scene.block,
                found,
                sampled - found["t0"],
                theta0=found["theta0"],
                solver=Solver(fit.diagnostics["rtol"]),
            )
            ((_, seconds, _),) = interleaved([run], 10 * ROUNDS[size])
            rows.append(
                {
                    "block": block,
                    "foundation": foundation,
                    "model": model,
                    "n_parameters": len(MODELS[model]),
                    "n_free": fit.n_parameters,
                    "epsilon_theta": fit.epsilon_theta,
                    "noise_epsilon": epsilon_theta(sampled, theta, motion.theta),
                    "time_s": seconds,
                    "rtol": fit.diagnostics["rtol"],
                    "success": fit.success,
                }
            )
    return pd.DataFrame(rows)
