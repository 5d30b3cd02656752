"""What a block stands on: the coefficients of its bed, how deep the block sinks, its energy.

One law f(z, ż) = k z + c ż + λ z ż acts per unit width of the base wherever base and foundation are
in contact (Spanos et al. 2017, section 3, doi:10.1016/j.proeng.2017.09.024): λ = 0 is the Winkler
model, c = 0 the Hunt-Crossley model. The compiled `kernel` has the force and the motion.
"""

import math
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from freerock.models.block import Block
from freerock.models.laws import GEOMETRIC, Rules

if TYPE_CHECKING:
    from freerock.arrays import Floats


class Foundation(NamedTuple):
    """Coefficients of the contact law, per unit width of the base.

    Parameters
    ----------
    k : float
        Stiffness [N/m²].
    c : float
        Linear damping [N·s/m²].
    lam : float
        Hunt-Crossley damping λ [N·s/m³].
    """

    k: float
    c: float = 0.0
    lam: float = 0.0

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> "Foundation":
        """The foundation that a model's parameters, named as in `laws`, describe; those it lacks are zero."""
        return cls(parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0))

    @property
    def is_damped(self) -> bool:
        """Whether it takes energy from the block."""
        return self.c > 0 or self.lam > 0

    def constants(self, block: Block, pivots: bool = False) -> tuple[float, ...]:
        """The law and the block as `kernel.integrate` takes them."""
        m = block.mass_kg
        law = (self.k / m, self.c / m, self.lam / m, block.flat, block.h, block.inertia_base / m, block.g)
        return (*law, block.flat if pivots else 0.0, block.edge_radius, block.e)


class State(NamedTuple):
    """State of the block.

    Parameters
    ----------
    z, z_rate : float
        Depth of the base centre, positive downward [m], and its rate [m/s].
    theta, theta_rate : float
        Rotation, positive clockwise [rad], and its rate [rad/s].
    """

    z: float
    z_rate: float
    theta: float
    theta_rate: float


def static_depth(block: Block, foundation: Foundation, theta: float) -> float:
    """Depth z_cb [m] at which the foundation carries the block's weight at rotation theta [rad]."""
    s = abs(math.sin(theta))
    flat = block.weight / (2 * block.b * foundation.k)
    depth = flat
    if flat < block.b * s:
        depth = math.sqrt(2 * block.weight * s / foundation.k) - block.b * s
    return _deeper(block, foundation, theta, depth) if block.edge_radius else depth


def lean(block: Block, foundation: Foundation, tilt_rad: float) -> float:
    """Angle to the base [rad] at which a block at rest stands on one that is off level by τ, positive to the
    right.

    The linearised no-uplift equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) at rest:
    m g (h sin τ + e cos τ) / (2/3 b³ k - m g (h cos τ - e sin τ)).
    """
    s, cos, weight = math.sin(tilt_rad), math.cos(tilt_rad), block.weight
    turning, falling = weight * block.h * s, weight * block.h * cos
    turning, falling = turning + weight * block.e * cos, falling - weight * block.e * s
    return turning / (2 / 3 * block.b**3 * foundation.k - falling)


def energy(
    block: Block,
    foundation: Foundation,
    z_cb: "float | Floats",
    z_cb_rate: "float | Floats",
    theta: "float | Floats",
    theta_rate: "float | Floats",
    rules: Rules = GEOMETRIC,
) -> "float | Floats":
    """Mechanical energy [J] above the upright block, sunk by its weight, for arrays or floats.

    The sum of kinetic energy, weight and elastic energy ∫ k z²/2 du over the contact z > 0.

    Parameters
    ----------
    block : Block
    foundation : Foundation
    z_cb, z_cb_rate, theta, theta_rate : float or ndarray, shape (n_time,)
        State [m, m/s, rad, rad/s].
    rules : Rules
        Its kinematics.
    """
    import numpy as np

    m, h, b, k = block.mass_kg, block.h, block.flat, foundation.k
    s = np.sin(theta)
    along, above = h * s + block.e * np.cos(theta), h * np.cos(theta) - block.e * s
    right, left = z_cb + b * s, z_cb - b * s
    flat = np.abs(s) * b <= 1e-9 * np.abs(z_cb)
    slope = np.where(flat, 1.0, s)
    partial = k / 6 * (np.maximum(right, 0) ** 3 - np.maximum(left, 0) ** 3) / slope
    full = k * (b * np.maximum(z_cb, 0) ** 2 + (b**3 / 3) * s**2)
    elastic = np.where(flat | (np.minimum(right, left) >= 0), full, partial)
    lever = above + (b * np.abs(s) if rules.kinematics == "pivoting" else 0.0)
    sinking = z_cb_rate + along * theta_rate
    kinetic = 0.5 * m * ((lever * theta_rate) ** 2 + sinking**2) + 0.5 * block.inertia_cm * theta_rate**2
    at_rest = static_depth(block, foundation, 0.0)
    weight = block.weight * (-2 * h * np.sin(0.5 * theta) ** 2 - block.e * s - (z_cb - at_rest))
    rest = np.full(1, at_rest)
    if block.edge_radius:
        elastic = elastic + _stored_by_edges(block, foundation, z_cb, s)
        kinetic = kinetic - _stored_by_edges(block, foundation, rest, 0.0)[0]
    return kinetic + weight + elastic - k * b * at_rest**2


def _stored_by_edges(
    block: Block, foundation: Foundation, z_cb: "float | Floats", s: "float | Floats"
) -> "Floats":
    """Elastic energy k/2 ∫ z² dv of the bed below both rounded edges [J], by the nodes of `_edge_force`."""
    import numpy as np

    radius, total = block.edge_radius, np.zeros(np.broadcast(z_cb, s).shape)
    for side in (1, -1):
        depth, slope = z_cb + side * block.flat * s, side * np.asarray(s)
        ends = np.vectorize(_edge_ends, [float, float])(depth, slope, radius)
        first, last = (np.arcsin(each / radius) for each in ends)
        for node, weight in _gauss(12):
            phi = 0.5 * (first + last) + 0.5 * (last - first) * node
            z = depth + slope * radius * np.sin(phi) - radius * (1 - np.cos(phi))
            total = total + 0.5 * (last - first) * weight * radius * np.cos(phi) * z**2
    return np.asarray(0.5 * foundation.k * total)


def _deeper(block: Block, foundation: Foundation, theta: float, depth: float) -> float:
    """The depth that carries a block with rounded edges, from that of sharp ones.

    It is up to ρ deeper; the force grows with the depth, and its slope too, so that Newton's method from
    there comes down to it. The slope of the force is k times the length that touches.
    """
    radius, s = block.edge_radius, abs(math.sin(theta))
    wanted = block.weight / foundation.k
    z = depth + radius
    for _ in range(100):
        low, high = z - block.flat * s, z + block.flat * s
        touching = 2 * block.flat if low >= 0 else max(high, 0.0) / s
        area = touching * (z if low >= 0 else high / 2)
        for ends, slope in ((low, -s), (high, s)):
            v0, v1 = _edge_ends(ends, slope, radius)
            touching += v1 - v0
            area += (v1 - v0) * (ends + slope * (v0 + v1) / 2) - _risen(v1, radius) + _risen(v0, radius)
        step = (area - wanted) / touching
        z -= step
        if step <= 1e-14 * block.b:
            break
    return z


def _risen(v: float, radius: float) -> float:
    """Integral from 0 to v of ρ - sqrt(ρ² - v²), by which a rounded edge rises [m²]."""
    return radius * v - 0.5 * (v * math.sqrt(radius**2 - v**2) + radius**2 * math.asin(v / radius))


@cache
def _gauss(n: int) -> list[tuple[float, float]]:
    """Nodes and weights of Gauss's rule on [-1, 1]."""
    from numpy.polynomial.legendre import leggauss

    nodes, weights = leggauss(n)
    return list(zip(nodes.tolist(), weights.tolist(), strict=True))


def _edge_ends(depth: float, slope: float, radius: float) -> tuple[float, float]:
    """From which v to which an edge touches that begins so deep [m]: depth + v slope > ρ - sqrt(ρ² - v²)."""
    rest, root = radius - depth, (radius * slope) ** 2 + depth * (2 * radius - depth)
    whole = radius * slope >= rest
    if not whole and (root <= 0 or (depth < 0 and slope <= 0)):
        return 0.0, 0.0
    half = math.sqrt(max(root, 0.0))
    v0 = (rest * slope - half) / (1 + slope**2) if depth < 0 else 0.0
    v1 = radius if whole else min((rest * slope + half) / (1 + slope**2), radius)
    return v0, max(v0, v1)
