"""A compiled simulator of free rocking whose impacts scatter; it shares nothing with `freerock.models`.

A block on a bed has the coordinates z (of the base's middle, downward) and θ; a rigid one turns about its
corners. The classical Runge-Kutta method goes at even steps; a step ends where θ is zero. There the rate is
multiplied by 1 + δ if a side lifted off since the passage before (Housner: by r (1 + δ), always).
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from freerock.arrays import Floats
from freerock.models.block import GRAVITY, Block
from freerock.models.compiled import compiled

STEPS = 20  # of a sample at 2 kHz
AT_REST = 1e-5  # [rad]
SHORTEST_S = 0.25  # it must have been at rest for so long
LONGEST_S = 20.0
GAUSS = 3**-0.5
AWAY_M = 0.5  # sensor from the face


@dataclass(frozen=True)
class Rocking:
    """A motion since the hand began to leave.

    Parameters
    ----------
    time_s, theta, theta_rate, z, z_rate : ndarray, shape (n_time,)
    passages_s, deltas : ndarray, shape (n_impact,)
        Instants at which the rate was multiplied, and δ of each.
    energies : ndarray, shape (n_impact + 1,)
        Above rest when the hand has left and at the top after each impact [J].
    """

    time_s: Floats
    theta: Floats
    theta_rate: Floats
    z: Floats
    z_rate: Floats
    passages_s: Floats
    deltas: Floats
    energies: Floats

    @property
    def restitution(self) -> Floats:
        """√(energy after / before) of each impact, shape (n_impact,)."""
        return np.asarray(np.sqrt(self.energies[1:] / self.energies[:-1]))


def rock(
    block: Block,
    law: dict[str, float],
    theta0: float,
    deltas: Floats,
    *,
    pivoting: bool,
    fade_s: float = 0.0,
    rate_hz: float = 2000.0,
) -> Rocking:
    """Motion of a block until it is at rest.

    Parameters
    ----------
    block : Block
    law : dict of str to float
        k and c or lambda of a bed, or r of a rigid base [SI].
    theta0 : float
        Angle of the hold [rad].
    deltas : ndarray
        δ of the impacts in turn, 0 after the last.
    pivoting : bool
        About the lower corner; otherwise the base's middle is held sideways.
    fade_s : float
        Time over which the hand leaves.
    rate_hz : float
        Of the samples.
    """
    body = np.array([block.mass_kg, block.inertia_cm, block.b, block.h, float(pivoting)])
    soil = np.array([law.get(name, 0.0) for name in ("k", "c", "lambda", "r")])
    state = np.array([_depth(body, soil, theta0), 0.0, theta0, 0.0])
    states, passages = np.zeros((math.ceil(LONGEST_S * rate_hz), 4)), np.zeros(1000)
    count, until = np.zeros(1, np.int64), round(SHORTEST_S * rate_hz)
    given = np.asarray(deltas, float), fade_s, 1 / rate_hz
    filled = _march(body, soil, state, *given, states, passages, count, until)
    states, passed = states[:filled], passages[: count[0]]
    tops = _tops(states[:, 2], passed * rate_hz, math.ceil(fade_s * rate_hz))
    rest = np.array([[_depth(body, soil, 0.0), 0.0, 0.0, 0.0]])
    energies = _energies(states[tops], body, soil) - _energies(rest, body, soil)
    n, (z, z_rate, theta, theta_rate) = len(tops) - 1, states.T
    factors = np.concatenate([given[0], np.zeros(n)])[:n]
    return Rocking(np.arange(filled) / rate_hz, theta, theta_rate, z, z_rate, passed[:n], factors, energies)


def _tops(theta: Floats, passages: Floats, free: int) -> list[int]:
    """Samples of the free block, and of the tops between passages."""
    ends = [*np.ceil(passages).astype(int).tolist(), len(theta)]
    return [free] + [i + int(np.argmax(np.abs(theta[i:j]))) for i, j in pairwise(ends) if j > i]


def _energies(states: Floats, body: Floats, soil: Floats) -> Floats:
    """Kinetic, of the weight and of the springs [J]."""
    (m, inertia, b, h, pivoting), (z, v, theta, w) = body, states.T
    sin, cos = np.sin(theta), np.cos(theta)
    if soil[3]:
        z, v = -b * np.abs(sin), -b * np.sign(theta) * cos * w
    first = np.clip(np.where(sin > 0, -z / np.where(sin > 0, sin, 1), -b), -b, b)
    last = np.clip(np.where(sin < 0, -z / np.where(sin < 0, sin, 1), b), -b, b)
    stored = np.zeros(len(z))
    for node in (-GAUSS, GAUSS):
        u = (first + last) / 2 + (last - first) / 2 * node
        stored += soil[0] / 2 * np.maximum(z + u * sin, 0) ** 2 * (last - first) / 2
    across = h * cos + pivoting * b * np.abs(sin)
    moving = m * ((v + h * sin * w) ** 2 + (across * w) ** 2) + inertia * w**2
    return np.asarray(moving / 2 + m * GRAVITY * (h * cos - z) + stored)


def _depth(body: Floats, soil: Floats, theta: float) -> float:
    """Of the base's middle where the bed carries the weight."""
    reach = float(body[2]) * math.sin(abs(theta))
    if soil[3]:
        return -reach

    def excess(z: float) -> float:
        return float(_contact(body, soil, z, 0.0, theta, 0.0)[0]) - float(body[0]) * GRAVITY

    return float(brentq(excess, -reach, reach + 0.02, xtol=1e-16))


@compiled()
def _contact(body, soil, z, v, theta, w):  # type: ignore[no-untyped-def]
    """Force [N], moment about the base's middle [N m] and length [m] of the contact."""
    sin, cos, b = math.sin(theta), math.cos(theta), body[2]
    first, last = -b, b
    if sin > 0.0:
        first = max(-b, -z / sin)
    elif sin < 0.0:
        last = min(b, -z / sin)
    elif z <= 0.0:
        return 0.0, 0.0, 0.0
    if last <= first:
        return 0.0, 0.0, 0.0
    force = moment = 0.0
    half = 0.5 * (last - first)
    for node in (-GAUSS, GAUSS):
        u = 0.5 * (first + last) + half * node
        depth, rate = z + u * sin, v + u * w * cos
        f = half * (soil[0] * depth + (soil[1] + soil[2] * depth) * rate)
        force, moment = force + f, moment + f * u * cos
    return force, moment, last - first


@compiled()
def _rates(body, soil, side, hand, z, v, theta, w):  # type: ignore[no-untyped-def]
    """ż, z̈, θ̇, θ̈ and whether a side is off the bed; the hand is a couple."""
    m, inertia, b, h, pivoting = body
    sin, cos = math.sin(theta), math.cos(theta)
    if soil[3] > 0.0:
        turning = (hand - m * GRAVITY * (side * b * cos - h * sin)) / (inertia + m * (b * b + h * h))
        return -side * b * cos * w, 0.0, w, turning, True
    force, moment, touched = _contact(body, soil, z, v, theta, w)
    lift, slide = h * sin, h * cos
    bend = -h * sin
    if pivoting > 0.0:
        slide, bend = slide + side * b * sin, bend + side * b * cos
    # m (z̈ + lift θ̈ + h cos θ θ̇²) = m g - F; the second of Lagrange's has that bracket times lift
    bracket = GRAVITY - force / m
    right = m * GRAVITY * lift - moment + hand - m * slide * bend * w * w - m * lift * bracket
    turning = right / (inertia + m * slide * slide)
    return v, bracket - lift * turning - h * cos * w * w, w, turning, touched < 2.0 * b


@compiled()
def _step(body, soil, side, t, dt, y, hand, fade, out):  # type: ignore[no-untyped-def]
    """A step of Runge and Kutta into `out`; whether a side was off the bed."""
    k = np.zeros((4, 4))
    lifted = False
    for i in range(4):
        part = 0.0 if i == 0 else (dt if i == 3 else 0.5 * dt)
        at = t + part
        pull = hand * 0.5 * (1.0 + math.cos(math.pi * at / fade)) if at < fade else 0.0
        s = np.empty(4)
        for j in range(4):
            s[j] = y[j] + (part * k[i - 1, j] if i > 0 else 0.0)
        k[i, 0], k[i, 1], k[i, 2], k[i, 3], off = _rates(body, soil, side, pull, s[0], s[1], s[2], s[3])
        lifted = lifted or off
    for j in range(4):
        out[j] = y[j] + dt / 6.0 * (k[0, j] + 2.0 * k[1, j] + 2.0 * k[2, j] + k[3, j])
    return lifted


@compiled()
def _passage(body, soil, side, t, dt, y, hand, fade, out):  # type: ignore[no-untyped-def]
    """Length of the step that ends at θ = 0, by false position; its end is in `out`."""
    low, at_low, high = 0.0, y[2], dt
    at_high = out[2]
    length = dt
    for _ in range(60):
        length = low - at_low * (high - low) / (at_high - at_low)
        _step(body, soil, side, t, length, y, hand, fade, out)
        if abs(out[2]) < 1e-15 or high - low < 1e-15:
            break
        if out[2] * at_low > 0.0:
            low, at_low, at_high = length, out[2], 0.5 * at_high
        else:
            high, at_high, at_low = length, out[2], 0.5 * at_low
    return length


@compiled()
def _march(body, soil, start, deltas, fade, sample_s, states, passages, count, until):  # type: ignore[no-untyped-def]
    """Fills states and instants of passages; how many samples until it is at rest."""
    y, out = start.copy(), np.empty(4)
    side = 1.0 if y[2] > 0.0 else -1.0
    weigh = _rates(body, soil, side, 0.0, y[0], y[1], y[2], y[3])[3]
    hand = -weigh / (_rates(body, soil, side, 1.0, y[0], y[1], y[2], y[3])[3] - weigh)
    lifted, still = False, 0
    dt = sample_s / STEPS
    for i in range(states.shape[0]):
        states[i] = y
        still = still + 1 if abs(y[2]) < AT_REST else 0
        if still > until:
            return i + 1
        for j in range(STEPS):
            t, left = i * sample_s + j * dt, dt
            for _ in range(8):
                off = _step(body, soil, side, t, left, y, hand, fade, out)
                lifted = lifted or off
                if out[2] * side > 0.0:
                    break
                done = _passage(body, soil, side, t, left, y, hand, fade, out)
                t, left = t + done, left - done
                y[:] = out
                y[2] = 0.0
                if soil[3] > 0.0 and abs(y[3]) < 1e-4:  # the tops after it are below 1e-9 rad
                    y[:] = 0.0
                    states[i + 1 :] = 0.0
                    return min(i + until, states.shape[0])
                if lifted:
                    n = count[0]
                    if n < passages.shape[0]:
                        passages[n] = t
                        count[0] = n + 1
                    y[3] *= (1.0 + deltas[n]) if n < deltas.shape[0] else 1.0
                    if soil[3] > 0.0:
                        y[3] *= soil[3]
                lifted = False
                side = -side
            y[:] = out
    return states.shape[0]


def way_to_face(motion: Floats, block: Block, height_m: float) -> Floats:
    """Way of a horizontal beam to the left face [m] from a sensor `AWAY_M` off, by z and θ, shape (2, n).

    The block turns about its lower corner, as the equations of the sensor have it.
    """
    z, theta = motion
    sin, cos, b = np.sin(theta), np.cos(theta), block.b
    along = (height_m + z - b * sin) / cos
    return np.asarray(AWAY_M + np.sign(theta) * b * (1 - cos) - b * cos + along * sin)
