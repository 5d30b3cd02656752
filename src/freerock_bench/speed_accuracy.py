"""Speed against accuracy: what each method costs for an error."""

import math
from functools import partial

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock_bench.methods.by_name import HOUSNER_METHODS, METHODS, Method, freerock
from freerock_bench.methods.problem import Problem
from freerock_bench.scenes import NOISE_RAD, ROUNDS, SAMPLING_HZ, SPAN_S, cyrk_installed, scenes
from freerock_bench.timing import interleaved

TOLERANCES = {"full": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12), "small": (1e-4, 1e-7)}
SLOW_TOLERANCES = {"full": (1e-3, 1e-5, 1e-7, 1e-9), "small": (1e-4,)}  # SciPy
STEPS_S = {"full": (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5), "small": (5e-4,)}
LONGEST_S = {"full": 2.0, "small": 0.5}  # a run that has taken this long in total is not repeated
Case = tuple[str, str, float, Method]  # method, setting, value, what to call


def run(size: str = "full") -> pd.DataFrame:
    """Time and error of every method over its ladder of tolerances or steps.

    Times are the best of several runs; the cases of a scene are run in turn, so that a busy machine
    disturbs all of them alike. The reference of the two contact laws is SciPy's DOP853 at rtol 1e-13,
    with which freerock at 1e-13 is compared; that of Housner's block is its closed form, with which
    DOP853 with events is compared.

    Returns
    -------
    pandas.DataFrame
        Columns block, foundation, model, method, setting ("rtol", "step_s" or "" where there is none),
        value, time_s, repeats, evaluations, epsilon, max_error_rad, outcome; reference_epsilon and
        reference_max_rad, the disagreement of the two references; noise_epsilon, ε of the noise of a laser.
    """
    sampled = np.arange(0.0, SPAN_S[size], 1 / SAMPLING_HZ)
    rows = []
    for (block, foundation, model), problem in scenes(size).items():
        reference, other = references(problem, sampled)
        apart = errors(other, reference)
        cases = _cases(problem, size)
        for method in {method for *_, method in cases}:
            method(problem, sampled[:10], 1e-3)  # compiled before it is timed
        timed = interleaved(
            [partial(method, problem, sampled, value) for _, _, value, method in cases],
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
                    "noise_epsilon": NOISE_RAD**2 / float(np.mean(reference**2)),
                }
            )
    return pd.DataFrame(rows)


def references(problem: Problem, time: Floats) -> tuple[Floats, Floats]:
    """θ [rad] of a problem by two independent methods at their tightest; the first is the reference."""
    if problem.model == "housner":
        return freerock(problem, time, 1e-8).theta, HOUSNER_METHODS["SciPy DOP853, events"](
            problem, time, 1e-12
        ).theta
    return METHODS["SciPy DOP853, numba"](problem, time, 1e-13).theta, freerock(problem, time, 1e-13).theta


def errors(theta: Floats, reference: Floats) -> tuple[float, float]:
    """ε (sums over samples, as a fraction) and largest error [rad] against a reference."""
    difference = theta - reference
    return float(difference @ difference / (reference @ reference)), float(np.max(np.abs(difference)))


def _cases(problem: Problem, size: str) -> list[Case]:
    """(method, setting, value, callable) of all methods for a problem."""
    if problem.model == "housner":
        return [
            ("freerock", "", math.nan, lambda p, t, _: freerock(p, t, 1e-8)),
            ("linearised", "", math.nan, HOUSNER_METHODS["linearised"]),
            *(
                (name, "rtol", rtol, HOUSNER_METHODS[name])
                for name in ("SciPy DOP853, events",)
                for rtol in SLOW_TOLERANCES[size]
            ),
        ]
    cases: list[Case] = []
    for name, method in METHODS.items():
        if name in ("RK4", "Newmark"):
            cases += [(name, "step_s", step, method) for step in STEPS_S[size]]
        elif name.startswith("SciPy"):
            tolerances = SLOW_TOLERANCES[size][: 3 if "Radau" in name else None]
            cases += [(name, "rtol", rtol, method) for rtol in tolerances]
        elif name == "freerock" or (size == "full" and cyrk_installed()):
            cases += [(name, "rtol", rtol, method) for rtol in TOLERANCES[size]]
    return cases
