"""Forces and rates of `integrated`: one call tree of compiled code."""

import math

import numpy as np

from freerock.models.block import GRAVITY
from freerock.models.compiled import compiled


@compiled()
def bed(z, theta, z_rate, w, b, k, c, lam):  # type: ignore[no-untyped-def]
    """Force [N], moment about the base's centre [N m] and stored energy [J]: k z + c ż + λ z ż, z > 0."""
    sin, cos = math.sin(theta), math.cos(theta)
    low, high = -b, b
    if z - b * abs(sin) < 0.0:
        edge = -z / sin if sin != 0.0 else math.inf
        if sin > 0.0:
            low = max(low, edge)
        else:
            high = min(high, edge)
    force = moment = stored = 0.0
    if high <= low or z + b * abs(sin) <= 0.0:
        return force, moment, stored
    for node in (-(3**-0.5), 3**-0.5):  # exact for cubics
        u = 0.5 * (low + high) + 0.5 * (high - low) * node
        depth, rate = z + u * sin, z_rate + u * w * cos
        part = 0.5 * (high - low) * (k * depth + (c + lam * depth) * rate)
        force, moment = force + part, moment + part * u
        stored += 0.25 * (high - low) * k * depth**2
    return force, moment * cos, stored


@compiled()
def rates(y, hand, m, inertia, h, b, k, c, lam, pivoting, tilt):  # type: ignore[no-untyped-def]
    """Of depth, rotation and their rates; the base is lower on the right by its tilt [rad]."""
    z, theta, z_rate, w = y
    force, moment, _ = bed(z, theta, z_rate, w, b, k, c, lam)
    sin, cos = math.sin(theta), math.cos(theta)
    lever, bends = h * cos, -h * sin
    if pivoting:
        lever, bends = lever + b * abs(sin), bends + math.copysign(b * cos, theta)
    hand += m * GRAVITY * math.sin(tilt) * lever
    turn = (force * h * sin - moment - m * lever * bends * w * w + hand) / (inertia + m * lever**2)
    fall = GRAVITY * math.cos(tilt) - force / m - h * sin * turn - h * cos * w * w
    return np.array([z_rate, w, fall, turn])


@compiled()
def turns(theta, side, m, inertia, h, b, tilt):  # type: ignore[no-untyped-def]
    """Rotation's second rate [rad/s²] of a rigid block on its right corner (side 1) or left one (-1)."""
    sin, cos = math.sin(theta), math.cos(theta)
    lever, rises = h * cos + side * b * sin, side * b * cos - h * sin
    moment = m * GRAVITY * (math.sin(tilt) * lever - math.cos(tilt) * rises)
    return moment / (inertia + m * (b * b + h * h))


@compiled()
def _stepped(y, t, dt, fade_s, hand, *scene):  # type: ignore[no-untyped-def]
    """States a step later, by Runge and Kutta's fourth order."""
    slope, total = np.zeros(4), np.zeros(4)
    for ahead, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        support = 0.5 * (1 + math.cos(math.pi * min((t + ahead * dt) / fade_s, 1.0)))
        slope = rates(y + ahead * dt * slope, support * hand, *scene)
        total = total + weight * slope
    return y + dt / 6 * total


@compiled()
def rocks(y, n, dt, fade_s, hand, *scene):  # type: ignore[no-untyped-def]
    """States at n instants, shape (n, 4), since a finger begins to leave; of the scene as in `rates`.

    A step over the upright ends there and begins anew: the lever of a block that pivots has a kink.
    """
    found = np.zeros((n, 4))
    found[0] = y
    for i in range(1, n):
        t = (i - 1) * dt
        end = _stepped(y, t, dt, fade_s, hand, *scene)
        if end[1] * y[1] < 0.0:
            part, upright = dt, end
            for _ in range(4):  # steps of Newton to the upright
                part -= upright[1] / upright[3]
                upright = _stepped(y, t, part, fade_s, hand, *scene)
            upright[1] = math.copysign(1e-300, end[1])
            end = _stepped(upright, t + part, dt - part, fade_s, hand, *scene)
        y = end
        found[i] = y
    return found
