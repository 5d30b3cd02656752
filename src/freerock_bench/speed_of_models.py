"""Speed of the models: every ratio in one run, the compared methods run in turn.

    python -m freerock_bench.speed_of_models            all
    python -m freerock_bench.speed_of_models methods    only these parts; there are methods, kinematics,
        stiffness, overturning

Times are the best of several runs. Figures of another machine differ; ratios hardly.
"""

import math
import sys
from functools import partial
from itertools import product

import numpy as np

from freerock.identification.problem import RTOL_DERIVATIVES, RTOL_RESIDUAL
from freerock.models.block import GRAVITY
from freerock.models.ground import pulse
from freerock.models.laws import KINEMATICS, Rules
from freerock.models.published import TABLE_2
from freerock.models.simulate import Solver, simulate, simulate_theta
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.methods.by_name import METHODS
from freerock_bench.methods.housner import housner_overturns
from freerock_bench.methods.problem import NOISE_RAD, Problem, errors
from freerock_bench.stability import problem_of
from freerock_bench.timing import interleaved

BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
MARBLE = FOUNDATIONS["marble"]
HC = Problem("hunt_crossley", BLOCK, MARBLE, THETA0)
TIME = np.arange(0.0, 5.0, 1 / 2000)
ERROR = 1e-10  # ε at which methods are compared; those of CyRK at the noise of a laser as well
TARGETS = {
    "SciPy DOP853, NumPy": "≥ 300",
    "SciPy LSODA, numba": "≥ 100",
    "CyRK DOP853": "≥ 5",
    "CyRK RK45": "",
}
LADDER = [10**-e for e in np.arange(2.0, 9.1, 0.25)]


def row(what, target, seen, note=""):
    print(f"{what:<62} {target:>12} {seen:>14}   {note}")


def own(rtol, problem=HC, time=TIME):
    theta, _ = simulate_theta(
        problem.model, problem.block, problem.parameters, time, theta0=problem.theta0, solver=Solver(rtol)
    )
    return theta


def loosest(run, reference, error):
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
    calls = {name: lambda rtol, solve=METHODS[name]: solve(HC, TIME, rtol).theta for name in TARGETS}
    noise = NOISE_RAD**2 / float(np.mean(reference**2))
    for error, others in ((ERROR, TARGETS), (noise, [name for name in TARGETS if name.startswith("CyRK")])):
        runs = {"freerock": own} | {name: calls[name] for name in others}
        at = {name: loosest(run, reference, error) for name, run in runs.items()}
        timed = interleaved([partial(run, at[name]) for name, run in runs.items()], 20, 15.0, in_a_row=3)
        _, least, _ = timed[0]
        row(
            f"Hunt-Crossley, config 2, marble, 5 s at 2 kHz, ε ≤ {error:.0e}",
            "≤ 1 ms",
            f"{1e3 * least:.3f} ms",
        )
        for name, (theta, seconds, repeats) in zip(runs, timed, strict=True):
            note = f"{1e3 * seconds:.3f} ms, rtol {at[name]:.1e}, ε {errors(theta, reference)[0]:.1e}"
            row(f"  {name}", TARGETS.get(name, ""), f"{seconds / least:.1f}", f"{note}, best of {repeats}")


def kinematics():
    """Time of a pivoting run over that of a guided one, 8 s at 2 kHz at the tolerances of fits."""
    time, ratios = np.arange(0.0, 8.0, 1 / 2000), []
    scenes = product((RTOL_RESIDUAL, RTOL_DERIVATIVES), CONFIGURATIONS, TABLE_2, ("winkler", "hunt_crossley"))
    for rtol, configuration, foundation, model in scenes:
        (block, theta0, _), law = CONFIGURATIONS[configuration], TABLE_2[foundation][model]
        scene = partial(simulate_theta, model, block, law, time, theta0=theta0, solver=Solver(rtol))
        calls = [partial(scene, rules=Rules(kinematics=one)) for one in KINEMATICS]
        guided, pivoting = (s for _, s, _ in interleaved(calls, 60, longest_s=2.0, in_a_row=2))
        ratios.append(pivoting / guided)
        what = f"  {model}, {configuration}, {foundation}, rtol {rtol:.0e}: pivoting over guided"
        row(what, "", f"{ratios[-1]:.3f}", f"{1e3 * pivoting:.3f} ms, {1e3 * guided:.3f} ms")
    largest = f"largest {max(ratios):.3f}"
    row("pivoting over guided, mean of these", "≤ 1.1", f"{np.mean(ratios):.3f}", largest)


def stiffness():
    """Time of a run over k from 1e5 to 1e12, damping in proportion."""
    ks = np.geomspace(1e5, 1e12, 8)
    for model, ratio, target in (("winkler", 2.17e4 / 6.77e6, "≤ 10"), ("hunt_crossley", 130 / 6.88, "≤ 30")):
        calls = [partial(own, 1e-6, problem_of(model, k, ratio)) for k in ks]
        timed = interleaved(calls, 5, longest_s=5.0, in_a_row=2)
        times = np.array([seconds for _, seconds, _ in timed])
        rocking = np.array([np.all(np.isfinite(theta)) for theta, _, _ in timed])
        note = "; ".join(
            f"1e{math.log10(k):.0f}: {1e3 * s:.2f} ms{'' if r else ' overturns'}"
            for k, s, r in zip(ks, times, rocking, strict=True)
        )
        what = f"{model}, longest over shortest time, k = 1e5…1e12"
        row(what, target, f"{times.max() / times[rocking].min():.1f}", note)


def overturning():
    """Housner's block under a one-sine pulse: 50 by 50 cells against SciPy with events."""
    r, unit = BLOCK.restitution_housner, GRAVITY * BLOCK.b / BLOCK.h
    grid = product(np.linspace(1, 12, 50), np.linspace(0.5, 10, 50))
    cells = [(unit * a, 2 * math.pi / (BLOCK.p * w)) for a, w in grid]

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
    note = f"{sum(found)} overturn; {seconds:.1f} s, SciPy {others:.1f} s"
    row("cells of 2500 in which the overturning maps differ", "0", f"{differ}", note)


PARTS = {part.__name__: part for part in (methods, kinematics, stiffness, overturning)}

if __name__ == "__main__":
    row("", "target", "seen")
    for name in sys.argv[1:] or PARTS:
        PARTS[name]()
