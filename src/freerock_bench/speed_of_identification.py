"""Speed of the identification: a fit of freerock, and the same fit over SciPy's LSODA.

    python -m freerock_bench.speed_of_identification

Runs of 8 s at 2 kHz, angle and instant of release free, six scenes. The other fit is the same one, scan,
growing horizons and least squares included, with every simulation by LSODA and a right-hand side in Python;
it takes minutes.
"""

import os
import time as clock

os.environ["OMP_NUM_THREADS"] = "1"  # as in the workflow's jobs: with two a fit takes twice as long

import numpy as np

from freerock.identification.fit import fit_run
from freerock.models import simulate
from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.methods.by_name import METHODS
from freerock_bench.methods.problem import Problem
from freerock_bench.virtual_run import RATE_HZ, published_truth, virtual_motion

AIMS_S = {"housner": 0.03, "winkler": 0.1, "hunt_crossley": 0.1}
REPEATS = 5


def runs(model):
    """Truths and their measured runs, lengthened by noise to 8 s."""
    for block in CONFIGURATIONS:
        for foundation in FOUNDATIONS:
            truth = published_truth(block, foundation, model)
            motion = virtual_motion(truth, np.random.default_rng(1))
            if motion is None:
                continue
            time_s = np.arange(int(8 * RATE_HZ)) / RATE_HZ + motion.time_s[0]
            rest = np.random.default_rng(2).standard_normal(len(time_s) - len(motion.theta))
            theta = np.append(motion.theta, truth.sigma_theta * rest)
            yield truth, Motion(**{**vars(motion), "time_s": time_s, "theta": theta})


def timed(model, truth, motion):
    """A fit and its processor time [s]."""
    begin = clock.process_time()
    fit = fit_run(model, truth.block, motion)
    return fit, clock.process_time() - begin


def lsoda(model, block, parameters, time_s, *, theta0, solver, rates=None, **_):
    """As `freerock.models.simulate.simulate_theta`."""
    grid = np.union1d(0.0, time_s)
    parameters = {name: parameters[name] for name in MODELS[model]}
    theta = METHODS["SciPy LSODA, NumPy"](Problem(model, block, parameters, theta0), grid, solver.rtol).theta
    theta = np.interp(np.maximum(time_s, 0.0), grid, theta)
    if rates is not None:
        rates[:, -1] = np.gradient(theta, time_s)
    return theta, "completed"


def main():
    print(
        f"{'8 s at 2 kHz, θ₀ and t₀ free':<30} {'aim':>7} {'median':>8} {'range':>15}   the same over LSODA"
    )
    for model in PAPER_MODELS:
        cases = list(runs(model))
        timed(model, *cases[0])
        own = [min((timed(model, *case) for _ in range(REPEATS)), key=lambda pair: pair[1]) for case in cases]
        times = [seconds for _, seconds in own]
        median, low, high = np.median(times), min(times), max(times)
        print(f"{model:<30} {AIMS_S[model]:>5} s {median:>6.3f} s {low:.3f} … {high:.3f} s", end="")
        if model != "housner":
            kept, simulate.simulate_theta = simulate.simulate_theta, lsoda
            fit, seconds = timed(model, *cases[2])
            simulate.simulate_theta = kept
            apart = abs(fit.value[0] - own[2][0].value[0]) / own[2][0].stderr[0]
            print(
                f"   {seconds / times[2]:.0f} × ({seconds:.0f} s, k {apart:.2f} standard errors apart)",
                end="",
            )
        print(flush=True)


if __name__ == "__main__":
    main()
