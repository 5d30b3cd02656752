"""Speed against accuracy: what each method costs for an error, and each model for a discrepancy."""

import math
import time as clock
from functools import partial

import numpy as np
import pandas as pd

from freerock.identification.choice import epsilon_theta
from freerock.identification.fit import fit_run
from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.models.simulate import simulate_theta
from freerock.runs.motion import Motion
from freerock.studies.methods import HOUSNER_METHODS, METHODS, Scene, freerock
from freerock.virtual_lab.record import CONFIGURATIONS, FOUNDATIONS

SAMPLING_HZ = 2000.0
SIGMA_DEG = 0.01  # noise of the records the models are fitted to
# Table 2 of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024; its Hunt-Crossley column is in `twin`.
WINKLER = {"marble": {"k": 6.77e6, "c": 2.17e4}, "aerstop": {"k": 4.50e6, "c": 4.05e4}}
HOUSNER = {"marble": {"r": 0.958}, "aerstop": {"r": 0.895}}

TOLERANCES = {"full": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12), "small": (1e-4, 1e-7)}
SLOW_TOLERANCES = {"full": (1e-3, 1e-5, 1e-7, 1e-9), "small": (1e-4,)}  # SciPy
STEPS_S = {"full": (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5), "small": (5e-4,)}
SPAN_S = {"full": 5.0, "small": 1.0}
ROUNDS = {"full": 7, "small": 2}
LONGEST_S = {"full": 2.0, "small": 0.5}  # a run that has taken this long in total is not repeated


def scenes(size: str = "full") -> dict:
    """The scenes measured, by name: block, foundation and model.

    Parameters
    ----------
    size : str
        "full", or "small": one scene of each model.

    Returns
    -------
    dict of (str, str, str) to Scene
        Keys are block, foundation, model.
    """
    chosen = {}
    for name, (block, theta0, _) in CONFIGURATIONS.items():
        for foundation, parameters in FOUNDATIONS.items():
            chosen[name, foundation, "hunt_crossley"] = Scene("hunt_crossley", block, parameters, theta0)
    for name, (block, theta0, _) in CONFIGURATIONS.items():
        if name == "config2":
            for foundation, parameters in WINKLER.items():
                chosen[name, foundation, "winkler"] = Scene("winkler", block, parameters, theta0)
        chosen[name, "marble", "housner"] = Scene("housner", block, HOUSNER["marble"], theta0)
    if size == "small":
        chosen = {key: scene for key, scene in chosen.items() if key[:2] == ("config2", "marble")}
    return chosen


def speed_accuracy(size: str = "full") -> pd.DataFrame:
    """Time and error of every method over its ladder of tolerances or steps.

    Times are the best of several runs; the cases of a scene are run in turn, so that a busy machine
    disturbs all of them alike. The reference of the two contact laws is SciPy's DOP853 at rtol 1e-13,
    with which freerock at 1e-13 is compared; that of Housner's block is its closed form, with which
    DOP853 with events is compared.

    Parameters
    ----------
    size : str
        "full" or "small" (seconds, without CyRK).

    Returns
    -------
    pandas.DataFrame
        Columns block, foundation, model, method, setting ("rtol", "step_s" or "" where there is none),
        value, time_s, repeats, evaluations, epsilon, max_error_rad, outcome; reference_epsilon and
        reference_max_rad, the disagreement of the two references.
    """
    sampled = np.arange(0.0, SPAN_S[size], 1 / SAMPLING_HZ)
    rows = []
    for (block, foundation, model), scene in scenes(size).items():
        reference, other = references(scene, sampled)
        apart = errors(other, reference)
        cases = _cases(scene, size)
        for method in {method for *_, method in cases}:
            method(scene, sampled[:10], 1e-3)  # compiled before it is timed
        timed = interleaved(
            [partial(method, scene, sampled, value) for _, _, value, method in cases],
            ROUNDS[size],
            LONGEST_S[size],
        )
        for (name, setting, value, _), (solution, seconds, repeats) in zip(cases, timed, strict=True):
            epsilon, largest = errors(solution.theta, reference)
            rows.append(
                {
                    "block": block,
                    "foundation": foundation,
                    "model": model,
                    "method": name,
                    "setting": setting,
                    "value": value,
                    "time_s": seconds,
                    "repeats": repeats,
                    "evaluations": solution.evaluations,
                    "epsilon": epsilon,
                    "max_error_rad": largest,
                    "outcome": solution.outcome,
                    "reference_epsilon": apart[0],
                    "reference_max_rad": apart[1],
                }
            )
    return pd.DataFrame(rows)


def references(scene: Scene, time) -> tuple:
    """θ [rad] of a scene by two independent methods at their tightest; the first is the reference."""
    if scene.model == "housner":
        return freerock(scene, time, 1e-8).theta, HOUSNER_METHODS["SciPy DOP853, events"](
            scene, time, 1e-12
        ).theta
    return METHODS["SciPy DOP853, numba"](scene, time, 1e-13).theta, freerock(scene, time, 1e-13).theta


def errors(theta, reference) -> tuple:
    """ε (sums over samples, as a fraction) and largest error [rad] against a reference."""
    difference = theta - reference
    return float(difference @ difference / (reference @ reference)), float(np.max(np.abs(difference)))


def interleaved(calls, rounds: int, longest_s: float = math.inf, in_a_row: int = 1) -> list:
    """Best time of each of several calls, run in turn so that they share the machine's bad moments.

    Parameters
    ----------
    calls : sequence of callable
        Without arguments. The first run of each, which may have to compile, counts only where it is not
        repeated.
    rounds : int
        Most runs of each after the first.
    longest_s : float
        A call is not repeated again once its runs have taken this long together [s], and not once where
        the first takes five times as long.
    in_a_row : int
        Runs of each in its turn: from the second on they find the caches as repeated runs do.

    Returns
    -------
    list of (result, float, int)
        Result, best time [s] and number of runs that count, of each.
    """
    results, spent = [], []
    for call in calls:
        begin = clock.perf_counter()
        results.append(call())
        spent.append(clock.perf_counter() - begin)
    best, runs = list(spent), [0] * len(calls)
    for n in range(rounds):
        for i, call in enumerate(calls):
            if spent[i] > (longest_s if n else 5 * longest_s):
                continue
            for _ in range(in_a_row):
                begin = clock.perf_counter()
                call()
                elapsed = clock.perf_counter() - begin
                best[i] = min(best[i], elapsed) if runs[i] else elapsed
                spent[i], runs[i] = spent[i] + elapsed, runs[i] + 1
    return list(zip(results, best, (max(1, n) for n in runs), strict=True))


def _cases(scene: Scene, size: str) -> list:
    """(method, setting, value, callable) of all methods for a scene."""
    if scene.model == "housner":
        return [
            ("freerock", "", math.nan, lambda s, t, _: freerock(s, t, 1e-8)),
            ("linearised", "", math.nan, HOUSNER_METHODS["linearised"]),
            *(
                (name, "rtol", rtol, HOUSNER_METHODS[name])
                for name in ("SciPy DOP853, events",)
                for rtol in SLOW_TOLERANCES[size]
            ),
        ]
    cases = []
    for name, method in METHODS.items():
        if name in ("RK4", "Newmark"):
            cases += [(name, "step_s", step, method) for step in STEPS_S[size]]
        elif name.startswith("SciPy"):
            tolerances = SLOW_TOLERANCES[size][: 3 if "Radau" in name else None]
            cases += [(name, "rtol", rtol, method) for rtol in tolerances]
        elif name == "freerock" or (size == "full" and cyrk_installed()):
            cases += [(name, "rtol", rtol, method) for rtol in TOLERANCES[size]]
    return cases


def cyrk_installed() -> bool:
    """Whether the optional package CyRK can be compared with."""
    from importlib.util import find_spec

    return find_spec("CyRK") is not None


def model_choice(size: str = "full") -> pd.DataFrame:
    """What each model costs and reaches on noisy records moved by the Hunt-Crossley law.

    Parameters
    ----------
    size : str
        "full": six scenes, or "small": one.

    Returns
    -------
    pandas.DataFrame
        Columns block, foundation, model, n_parameters (of the model), n_free (with nuisances),
        epsilon_theta, noise_epsilon (ε_θ of the noise alone), time_s (of one run at the fit's
        tolerance), rtol, success.
    """
    sampled = np.arange(0.0, SPAN_S[size], 1 / SAMPLING_HZ)
    sigma = math.radians(SIGMA_DEG)
    rows = []
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
                rtol=fit.diagnostics["rtol"],
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
