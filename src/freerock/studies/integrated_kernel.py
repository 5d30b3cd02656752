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
def rates(y, hand, m, inertia, h, b, k, c, lam, pivoting):  # type: ignore[no-untyped-def]
    z, theta, z_rate, w = y
    force, moment, _ = bed(z, theta, z_rate, w, b, k, c, lam)
    sin, cos = math.sin(theta), math.cos(theta)
    lever, bends = h * cos, -h * sin
    if pivoting:
        lever, bends = lever + b * abs(sin), bends + math.copysign(b * cos, theta)
    turn = (force * h * sin - moment - m * lever * bends * w * w + hand) / (inertia + m * lever**2)
    fall = GRAVITY - force / m - h * sin * turn - h * cos * w * w
    return np.array([z_rate, w, fall, turn])
