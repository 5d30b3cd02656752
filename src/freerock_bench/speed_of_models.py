"""Speed of the models: every ratio in one run, the compared methods run in turn.

    python -m freerock_bench.speed_of_models            all
    python -m freerock_bench.speed_of_models methods    only these parts; there are methods, cyrk,
        kinematics, stiffness, many, overturning

Times are the best of several runs. Figures of another machine differ; ratios hardly.
"""

import math
import resource
import sys
from functools import partial

import numpy as np
from numba import njit

from freerock.identification.problem import COARSE, FINE
from freerock.models.block import GRAVITY
from freerock.models.ground import pulse
from freerock.models.laws import KINEMATICS, Rules
from freerock.models.published import TABLE_2
from freerock.models.simulate import Solver, simulate, simulate_many, simulate_theta
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.methods.by_name import METHODS
from freerock_bench.methods.foundation import rates
from freerock_bench.methods.housner import housner_overturns
from freerock_bench.methods.problem import NOISE_RAD, Problem, errors
from freerock_bench.stability import problem_of
from freerock_bench.timing import interleaved

BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
MARBLE = FOUNDATIONS["marble"]
HC = Problem("hunt_crossley", BLOCK, MARBLE, THETA0)
TIME = np.arange(0.0, 5.0, 1 / 2000)
ERROR = 1e-10  # ε at which methods are compared
LADDER = [10**-e for e in np.arange(2.0, 9.1, 0.25)]


def row(what, target, seen, note=""):
    print(f"{what:<62} {target:>12} {seen:>14}   {note}")


def own(rtol, problem=HC, time=TIME):
    theta, _ = simulate_theta(
        problem.model, problem.block, problem.parameters, time, theta0=problem.theta0, solver=Solver(rtol)
    )
    return theta


def loosest(run, reference, error=ERROR):
    """The loosest tolerance of the ladder whose error, and that of all tighter ones, is at most so large."""
    good = None
    for rtol in reversed(LADDER):
        if errors(run(rtol), reference)[0] > error:
            break
        good = rtol
    return good


def methods():
    """Time at the same error, against other methods."""
    reference = METHODS["SciPy DOP853, numba"](HC, TIME, 1e-13).theta
    runs = {"freerock": own}
    targets = {"SciPy DOP853, NumPy": "≥ 300", "SciPy LSODA, numba": "≥ 100", "CyRK DOP853": "≥ 5"}
    for name in [*targets, "CyRK RK45"]:
        try:
            METHODS[name](HC, TIME, 1e-3)
        except ImportError:
            print(f"{name}: not installed")
            continue
        runs[name] = lambda rtol, method=METHODS[name]: method(HC, TIME, rtol).theta
    tolerances = {name: loosest(run, reference) for name, run in runs.items()}
    timed = interleaved(
        [partial(run, tolerances[name]) for name, run in runs.items()], 20, longest_s=15.0, in_a_row=3
    )
    best = {name: seconds for name, (_, seconds, _) in zip(runs, timed, strict=True)}
    for name, (theta, seconds, repeats) in zip(runs, timed, strict=True):
        note = f"rtol {tolerances[name]:.1e}, ε {errors(theta, reference)[0]:.1e}, best of {repeats}"
        if name == "freerock":
            row(
                "Hunt-Crossley, config 2, marble, 5 s at 2 kHz, ε ≤ 1e-10",
                "≤ 1 ms",
                f"{1e3 * seconds:.3f} ms",
                note,
            )
        else:
            row(
                f"  {name} over freerock",
                targets.get(name, ""),
                f"{seconds / best['freerock']:.1f}",
                f"{1e3 * seconds:.2f} ms, {note}",
            )


@njit
def _rates(y, law, rounds):
    """Evaluations as CyRK asks for them, each waiting for the one before."""
    dy, state, total = np.empty(4), y.copy(), 0.0
    for _ in range(rounds):
        state[2] = y[2] + 1e-300 * total
        rates(dy, state, law)
        total += dy[1] + dy[3]
    return total


def cyrk():
    """Where the time goes that freerock and CyRK take: evaluations of the law, and all samples but a few."""
    reference, few = METHODS["SciPy DOP853, numba"](HC, TIME, 1e-13).theta, TIME[:: len(TIME) // 20]
    calls = {"freerock": own}
    for name in ("CyRK DOP853", "CyRK RK45"):
        calls[name] = lambda rtol, problem=HC, time=TIME, method=METHODS[name]: (
            method(problem, time, rtol).theta
        )
    rounds, start = 10_000, np.array(HC.start)
    ((_, seconds, _),) = interleaved([partial(_rates, start, np.array(HC.law), rounds)], 20, in_a_row=3)
    row("an evaluation as CyRK asks for it", "", f"{1e9 * seconds / rounds:.0f} ns")
    for error in (ERROR, NOISE_RAD**2 / float(np.mean(reference**2))):
        at = {name: loosest(call, reference, error) for name, call in calls.items()}
        runs = [partial(call, at[name], HC, time) for name, call in calls.items() for time in (TIME, few)]
        seconds = [best for _, best, _ in interleaved(runs, 20, in_a_row=3)]
        for name, whole, bare in zip(calls, seconds[::2], seconds[1::2], strict=True):
            note = f"{1e3 * whole:.3f} ms, {1e3 * bare:.3f} ms of it for few samples, rtol {at[name]:.1e}"
            row(f"  {name} over freerock at ε ≤ {error:.1e}", "", f"{whole / seconds[0]:.2f}", note)
        solver = Solver(at["freerock"])
        known = simulate(HC.model, BLOCK, MARBLE, TIME, theta0=THETA0, solver=solver).statistics
        row("  evaluations of freerock", "", f"{known['evaluations']}")


def kinematics():
    """Time of a pivoting run over that of a guided one, 8 s at 2 kHz at the tolerances of fits."""
    time, ratios = np.arange(0.0, 8.0, 1 / 2000), []
    for rtol in (COARSE, FINE):
        for configuration, (block, theta0, _) in CONFIGURATIONS.items():
            for foundation, laws in TABLE_2.items():
                for model in ("winkler", "hunt_crossley"):
                    scene = partial(
                        simulate_theta, model, block, laws[model], time, theta0=theta0, solver=Solver(rtol)
                    )
                    calls = [partial(scene, rules=Rules(kinematics=one)) for one in KINEMATICS]
                    guided, pivoting = (s for _, s, _ in interleaved(calls, 60, longest_s=2.0, in_a_row=2))
                    ratios.append(pivoting / guided)
                    row(
                        f"  {model}, {configuration}, {foundation}, rtol {rtol:.0e}: pivoting over guided",
                        "",
                        f"{ratios[-1]:.3f}",
                        f"{1e3 * pivoting:.3f} ms, {1e3 * guided:.3f} ms",
                    )
    row(
        "pivoting over guided, mean of these", "≤ 1.1", f"{np.mean(ratios):.3f}", f"largest {max(ratios):.3f}"
    )


def stiffness():
    """Time of a run over k from 1e5 to 1e12, damping in proportion."""
    for model, ratio, target in (("winkler", 2.17e4 / 6.77e6, "≤ 10"), ("hunt_crossley", 130 / 6.88, "≤ 30")):
        ks = np.geomspace(1e5, 1e12, 8)
        problems = [problem_of(model, k, ratio) for k in ks]
        timed = interleaved(
            [partial(own, 1e-6, problem) for problem in problems], 5, longest_s=5.0, in_a_row=2
        )
        times = np.array([seconds for _, seconds, _ in timed])
        rocking = np.array([np.all(np.isfinite(theta)) for theta, _, _ in timed])
        note = "; ".join(
            f"1e{math.log10(k):.0f}: {1e3 * s:.2f} ms{'' if r else ' overturns'}"
            for k, s, r in zip(ks, times, rocking, strict=True)
        )
        row(
            f"{model}, longest over shortest time, k = 1e5…1e12",
            target,
            f"{times.max() / times[rocking].min():.1f}",
            note,
        )


def many():
    """`simulate_many` on two threads against one; memory over the number of steps."""
    n = 10_000
    generator = np.random.default_rng(1)
    sets = {name: value * generator.uniform(0.5, 2.0, n) for name, value in MARBLE.items()}
    time = np.arange(0.0, 5.0, 0.01)

    def run(threads, rtol=1e-6):
        solver = Solver(rtol, threads=threads)
        return simulate_many("hunt_crossley", BLOCK, sets, time, theta0=THETA0, solver=solver)[0]

    timed = interleaved([partial(run, 1), partial(run, 2)], 4)
    (one, alone, _), (two, together, _) = timed
    same = "same bytes" if np.array_equal(one, two, equal_nan=True) else "DIFFERENT results"
    row(
        f"simulate_many, {n} sets, 2 threads over 1",
        "≥ 1.8",
        f"{alone / together:.2f}",
        f"{alone:.2f} s, {together:.2f} s, {same}",
    )
    del one, two, timed
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    run(2, rtol=1e-10)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    row(
        "  growth of memory with 10 times the steps",
        "0 MB",
        f"{grown:.1f} MB",
        f"output {8e-6 * n * time.size:.0f} MB",
    )


def overturning():
    """Housner's block under a one-sine pulse: 50 by 50 cells against SciPy with events."""
    r, unit = BLOCK.restitution_housner, GRAVITY * BLOCK.b / BLOCK.h
    cells = [
        (unit * a, 2 * math.pi / (BLOCK.p * w))
        for a in np.linspace(1, 12, 50)
        for w in np.linspace(0.5, 10, 50)
    ]

    def ours(amplitude, period):
        motion, time = pulse("sine", period, x=amplitude), np.array([0.0, period + 20.0])
        response = simulate("housner", BLOCK, {"r": r}, time, base_excitation=motion, solver=Solver(1e-9))
        return response.outcome == "overturned"

    calls = [
        lambda: [ours(*cell) for cell in cells],
        lambda: [housner_overturns(BLOCK, r, *cell) for cell in cells],
    ]
    (found, seconds, _), (other, others, _) = interleaved(calls, 1)
    differ = int(np.sum(np.array(found) != np.array(other)))
    row(
        "cells of 2500 in which the overturning maps differ",
        "0",
        f"{differ}",
        f"{sum(found)} overturn; {seconds:.1f} s, SciPy {others:.1f} s",
    )


PARTS = {
    "methods": methods,
    "cyrk": cyrk,
    "kinematics": kinematics,
    "stiffness": stiffness,
    "many": many,
    "overturning": overturning,
}

if __name__ == "__main__":
    row("", "target", "seen")
    for name in sys.argv[1:] or PARTS:
        PARTS[name]()
