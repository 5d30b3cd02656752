"""A run that begins in motion, without a hold before its free rocking.

Until its first impact a block moves as one that was let go from rest at some angle and instant. These two,
from a local fit, are the first guesses of θ₀ and t₀, and a fit finds them with the rest.
"""

import math
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.runs.beginning import Beginning
from freerock.runs.release import HeldAngle, Release
from freerock.runs.signal import Signal
from freerock.runs.verdict import Reason

LOCAL_S, FEWEST = 0.04, 6  # the local fit takes so long of the motion, and at least so many samples
LOOSE, LOOSE_S = 0.05, 0.02  # standard uncertainty of the first guesses: of θ₀ as a share, of t₀
AIRBORNE = 0.1  # of the half width: a corner so much higher than at rest has left the ground
LEFT = 0.5  # of its top at least a swing has to fall yet where a run begins in it; else it begins in the next
RISES = 5.0  # standard deviations of the noise
SLIDES = 0.1  # of the half width, by which the corner that stands may move


class Position(NamedTuple):
    """Where the centre of a block is, from motion capture: x to the right, z upward, shape (n_time,) [m]."""

    x: Floats
    z: Floats


class LocalFit(NamedTuple):
    """Rotation [rad] and rate [rad/s] at an instant, and the standard error of the rotation."""

    theta: float
    rate: float
    theta_stderr: float


def begun_moving(
    signal: Signal, after_s: float, end_s: float, block: Block, position: Position | None, settle_s: float
) -> Beginning | None:
    """How a run begins that is in motion already, None where nothing moves.

    It begins after the last time something else acted: when |θ| was last at θ_cr or beyond, which is
    another face's, and where the position is known, when the block was last in the air before its first
    impact. A block that rises begins at the top of that swing.

    Parameters
    ----------
    signal : Signal
    after_s, end_s : float
        The rest before, or the start of the record, and the end of the motion [s].
    block : Block
    position : Position or None
        Of the centre, at the signal's instants; None where it is not known.
    settle_s : float
        No sample is fitted for so long after the top of a swing: a motion let go from rest there begins in
        static equilibrium, one that passes by does not [s].
    """
    if not signal.t[signal.during(after_s, end_s)].size:
        return None
    start_s = _last_acted(signal, after_s, end_s, block, position)
    for _ in range(2):
        start_s, impact_s = _first_swing(signal, start_s, end_s)
        swing = slice(np.searchsorted(signal.t, start_s), np.searchsorted(signal.t, impact_s, "right"))
        found = local_fit(signal.t[swing], signal.theta[swing], signal.sigma[swing])
        falls = found and found.theta * found.rate < 0
        top = let_go(found if falls else found._replace(rate=0.0), block) if found else None
        if found and (top is None or abs(found.theta) > LEFT * top[0]):
            break
        start_s = _next_swing(signal, impact_s, end_s)  # hardly any of this one is left
    if found is None:
        return None
    side, first = math.copysign(1.0, found.theta), float(signal.theta[np.searchsorted(signal.t, start_s)])
    seen = f"begins in motion at {start_s:.3f} s: {math.degrees(found.theta):.2f}°, "
    seen += f"{math.degrees(found.rate):.1f}°/s"
    if top is None:
        text = f"{seen}, faster than from rest below the critical angle: no law of a release is fitted"
        held = HeldAngle(first, found.theta_stderr, 0.0)
        release = Release(start_s, LOOSE_S, 0.0, start_s)
        return Beginning(start_s, release, held, start_s, (Reason("warn", "thrown", text),))
    height, before_s = top
    held = HeldAngle(side * height, LOOSE * height, 0.0)
    release = Release(start_s - before_s, LOOSE_S, 0.0, start_s)
    fit_start_s = max(start_s, release.instant_s + settle_s)
    return Beginning(start_s, release, held, fit_start_s, (Reason("ok", "in_motion", seen),))


def local_fit(time_s: Floats, theta: Floats, sigma: Floats) -> LocalFit | None:
    """A parabola through the first samples of a motion; None where there are too few."""
    n = max(FEWEST, round(LOCAL_S / float(time_s[1] - time_s[0]))) if len(time_s) > 1 else 0
    t, theta = time_s[:n] - time_s[:1], theta[:n]
    known = np.isfinite(theta)
    if np.count_nonzero(known) < FEWEST - 2:
        return None
    design = np.stack([np.ones(t.size), t, t**2], axis=1)[known]
    value, *_ = np.linalg.lstsq(design, theta[known], rcond=None)
    left = theta[known] - design @ value
    scatter = max(float(np.median(sigma[:n][known])), float(np.sqrt(np.mean(left**2))))
    stderr = scatter * np.sqrt(np.linalg.inv(design.T @ design)[0, 0])
    return LocalFit(float(value[0]), float(value[1]), float(stderr))


def let_go(found: LocalFit, block: Block) -> tuple[float, float] | None:
    """Angle [rad] from which, and how long before [s], a rigid block was let go that now falls so.

    With φ = θ_cr - |θ|: cos φ₀ = cos φ + φ̇²/2p² (Housner 1963, doi:10.1785/BSSA0530020403). None where it was
    thrown in from beyond the critical angle.
    """
    phi = block.theta_cr - abs(found.theta)
    energy = math.cos(phi) + found.rate**2 / (2 * block.p**2)
    if energy >= 1 - 1e-6 or phi <= 0:
        return None
    top = math.acos(energy)
    # φ grows from rest as φ̇ = p √(2 (cos φ₀ - cos φ)); φ = φ₀ + s² takes the root out of the integral
    s, weight = np.polynomial.legendre.leggauss(40)
    s = 0.5 * math.sqrt(max(phi - top, 0.0)) * (s + 1)
    fall = np.cos(top) - np.cos(top + s**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        slowness = np.where(fall > 0, 2 * s / np.sqrt(2 * fall), math.sqrt(2 / max(math.sin(top), 1e-9)))
    before_s = 0.5 * math.sqrt(max(phi - top, 0.0)) * float(weight @ slowness) / block.p
    return block.theta_cr - top, before_s


def lifted(theta: Floats, z: Floats, at_rest: float, block: Block) -> Floats:
    """How much higher the lower corner is than at rest, where the centre is at z = `at_rest` [m]."""
    height = z - at_rest + block.h
    return np.asarray(height - block.b * np.abs(np.sin(theta)) - block.h * np.cos(theta))


def slid(signal: Signal, start_s: float, block: Block, position: Position) -> Reason | None:
    """A warning where the corner that stands moves before the first impact."""
    first = int(np.searchsorted(signal.t, start_s))
    side = float(np.sign(signal.theta[first]))
    down = np.flatnonzero(~(signal.theta[first:] * side > 0))
    part = slice(first, first + (int(down[0]) if down.size else 0))
    if part.stop - part.start < 2:
        return None
    theta = signal.theta[part]
    corner = position.x[part] + side * block.b * np.cos(theta) - block.h * np.sin(theta)
    moved = float(corner[-1] - corner[0])
    if abs(moved) <= SLIDES * block.b:
        return None
    text = f"the corner it turns about slides by {1e3 * moved:+.1f} mm before the first impact"
    return Reason("warn", "slid", text)


def _first_swing(signal: Signal, start_s: float, end_s: float) -> tuple[float, float]:
    """From when to when the first swing falls on its side [s]."""
    during = signal.during(start_s, end_s)
    t, theta = signal.t[during], signal.theta[during]
    down = np.flatnonzero(theta * np.sign(theta[:1]) <= 0)
    swing = np.abs(theta[: int(down[0]) if down.size else None])
    if not np.isfinite(swing).any():
        return start_s, start_s
    top = int(np.nanargmax(swing))
    noise = RISES * float(np.nanmedian(signal.sigma[during]))
    rises = swing[top] > swing[0] + noise and np.nanmin(swing[: top + 1]) > swing[0] - noise
    return float(t[top if rises else 0]), float(t[swing.size - 1])


def _next_swing(signal: Signal, impact_s: float, end_s: float) -> float:
    """When a swing begins that follows an impact [s]: at its first sample that stands out of the noise."""
    during = signal.during(impact_s, end_s)
    t, theta = signal.t[during], signal.theta[during]
    side = theta * np.sign(theta[:1])
    over = np.flatnonzero(side < -RISES * float(np.nanmedian(signal.sigma[during]))) if t.size else side
    return float(t[int(over[0])]) if over.size else end_s


def _last_acted(
    signal: Signal, after_s: float, end_s: float, block: Block, position: Position | None
) -> float:
    """From when on nothing but the ground acts on the block, turning about the corners of one face [s]."""
    during = signal.during(after_s, end_s)
    t, theta = signal.t[during], signal.theta[during]
    beyond = np.flatnonzero(np.abs(theta) >= block.theta_cr)
    first = int(beyond[-1]) + 1 if beyond.size else 0
    known = np.flatnonzero(np.isfinite(theta[first:]))
    first += int(known[0]) if known.size else 0
    if position is not None and first < t.size:
        at_rest = float(np.nanmedian(position.z[signal.during(end_s, math.inf)]))
        high = lifted(theta, position.z[during], at_rest, block)
        side = np.sign(theta[first])
        down = np.flatnonzero(side * theta[first:] <= 0)
        impact = first + (int(down[0]) if down.size else 0)
        air = np.flatnonzero(high[first:impact] > AIRBORNE * block.b)
        first += int(air[-1]) + 1 if air.size else 0
    return float(t[min(first, t.size - 1)])
