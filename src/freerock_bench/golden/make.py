"""Golden solutions made: every scene by both methods, quoted as far as they agree.

python -m freerock_bench.golden             # renews the package's own, a quarter of an hour
python -m freerock_bench.golden FOLDER 0.5  # up to 0.5 s, into a folder
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np

from freerock_bench.golden import dop853, taylor
from freerock_bench.golden.fixed_point import number
from freerock_bench.golden.motion import Motion
from freerock_bench.golden.scenes import SPAN_S, Scene, instants, scenes
from freerock_bench.golden.taylor import Solution

MOST_APART_RAD = 1e-11  # θ by the two methods, at every instant quoted
MOST_APART_S = 1e-10  # instants of impacts and peaks
# smaller ones than these are not quoted: peaks [rad], angular rates at impacts [rad/s]
SMALLEST_PEAK_RAD, SMALLEST_RATE_RAD_S = 1e-6, 1e-5
Event = tuple[float, float, float]


@dataclass(frozen=True)
class Golden:
    """What is quoted of a scene: the first method's numbers, as far as the second agrees.

    Parameters
    ----------
    scene : Scene
    quoted : Solution
    z_cb0_m : float
        Depth of the base centre at t = 0 [m].
    apart_rad, apart_rad_s, apart_s : float
        Largest difference between the methods: θ, θ̇, instants of impacts and peaks.
    """

    scene: Scene
    quoted: Solution
    z_cb0_m: float
    apart_rad: float
    apart_rad_s: float
    apart_s: float


def run(span_s: float) -> list[Golden]:
    """Every scene by both methods up to an instant [s], with a printed line for each."""
    made = []
    for scene in scenes().values():
        last = golden(scene, span_s)
        apart = f"{last.apart_rad:.1e} rad, {last.apart_rad_s:.1e} rad/s, {last.apart_s:.1e} s"
        events = f"{len(last.quoted.impacts)} impacts, {len(last.quoted.peaks)} peaks"
        print(f"{scene.name}: up to {last.quoted.time_s[-1]:g} s, {events}, apart {apart}", flush=True)
        made.append(last)
    return made


def golden(scene: Scene, span_s: float = SPAN_S) -> Golden:
    """A scene by both methods, up to the last instant before which they agree everywhere.

    Raises
    ------
    ArithmeticError
        The methods see other impacts or peaks in what is quoted.
    """
    one, other = taylor.solve(scene, span_s), dop853.solve(scene, span_s)
    n = min(len(one.time_s), len(other.time_s))
    apart = np.abs(np.subtract(one.theta_rad[:n], other.theta_rad[:n]))
    n = sum(1 for _ in takewhile(lambda each: each <= MOST_APART_RAD, apart.tolist()))
    end = one.time_s[n - 1]
    impacts, late = _paired(one, other, "impacts", end)
    peaks, later = _paired(one, other, "peaks", end)
    quoted = Solution(instants(end), one.theta_rad[:n], one.theta_rate_rad_s[:n], impacts, peaks)
    of_rate = np.abs(np.subtract(quoted.theta_rate_rad_s, other.theta_rate_rad_s[:n])).max()
    depth_m, apart_rad = number(Motion(scene).state[0]), float(apart[:n].max())
    return Golden(scene, quoted, depth_m, apart_rad, float(of_rate), max(late, later))


def _paired(one: Solution, other: Solution, kind: str, end: float) -> tuple[list[Event], float]:
    """Impacts or peaks up to an instant, and how far apart the methods have them."""
    ours, theirs = (_quoted(getattr(each, kind), kind, end) for each in (one, other))
    if len(ours) != len(theirs):
        raise ArithmeticError(f"{len(ours)} {kind} by one method, {len(theirs)} by the other")
    apart = max((abs(a[0] - b[0]) for a, b in zip(ours, theirs, strict=True)), default=0.0)
    if apart > MOST_APART_S:
        raise ArithmeticError(f"{kind} are {apart:.1e} s apart")
    return ours, apart


def _quoted(events: Sequence[Event], kind: str, end: float) -> list[Event]:
    return [
        (time, theta, rate)
        for time, theta, rate in events
        if time < end - MOST_APART_S
        and (abs(rate) > SMALLEST_RATE_RAD_S if kind == "impacts" else abs(theta) > SMALLEST_PEAK_RAD)
    ]
