"""The distributed contact law of the foundation models, written to be read.

One law f(z, ż) = k z + c ż + λ z ż acts per unit width of the base wherever base and foundation are
in contact (Spanos et al. 2017, section 3, doi:10.1016/j.proeng.2017.09.024): λ = 0 is the Winkler
model, c = 0 the Hunt-Crossley model. With u in [-b, b] measured from the base centre, positive to
the right, z(u) = z_cb + u sinθ and ż(u) = ż_cb + u θ̇ cosθ are linear in u, so that contact is an
interval of u (at most two for c λ > 0) and force and moment are polynomial moments over it. What the
base does sideways enters the motion by `sideways` alone. Rounded edges of radius ρ lie w = ρ - sqrt(ρ² - v²)
higher at v beyond the flat part of the base. The compiled `kernel` computes the same; this is what it is
checked against.
"""

import math
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
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

    def pressure(self, depth: "float | Floats", rate: "float | Floats" = 0.0) -> "float | Floats":
        """Force per unit width [N/m] of the bed in contact, at a depth [m] and its rate [m/s]."""
        return self.k * depth + (self.c + self.lam * depth) * rate

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


def contact_intervals(
    block: Block, foundation: Foundation, state: State, rules: Rules = GEOMETRIC
) -> list[tuple[float, float]]:
    """Parts of the base [-b, b] in contact with the foundation; of its flat part, where edges are rounded.

    Parameters
    ----------
    block : Block
    foundation : Foundation
    state : State
    rules : Rules
        Its debonding: "geometric", contact where z > 0; "tensionless", contact where z > 0 and f > 0.

    Returns
    -------
    list of (float, float)
        Intervals (u0, u1) [m], from left to right; empty in flight.
    """
    b = block.flat
    depth, slope, rate, spin = _along_base(state)
    force = _force_coefficients(foundation, state)
    cuts = {-b, b, *_roots(depth, slope)}
    if rules.debonding == "tensionless":
        # f = z (k + λ ż) without c: the first factor is cut already
        k, lam = foundation.k, foundation.lam
        cuts |= set(_roots(*force) if foundation.c else _roots(k + lam * rate, lam * spin))
    inside = sorted(u for u in cuts if -b <= u <= b)
    intervals: list[tuple[float, float]] = []
    for u0, u1 in pairwise(inside):
        middle = 0.5 * (u0 + u1)
        touches = depth + slope * middle > 0
        pushes = force[0] + middle * (force[1] + middle * force[2]) > 0
        if touches and (pushes or rules.debonding == "geometric"):
            if intervals and intervals[-1][1] == u0:
                u0 = intervals.pop()[0]
            intervals.append((u0, u1))
    return intervals


def contact_force(
    block: Block, foundation: Foundation, state: State, rules: Rules = GEOMETRIC
) -> tuple[float, float]:
    """Resultant of the contact law: eqs (2)-(3) of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024.

    Parameters as in `contact_intervals`.

    Returns
    -------
    force : float
        F_cb = ∫ f du, positive upward on the block [N].
    moment : float
        M_cb = ∫ f u cosθ du about the base centre, positive anticlockwise on the block [N·m].
    """
    f0, f1, f2 = _force_coefficients(foundation, state)
    force = moment = 0.0
    for u0, u1 in contact_intervals(block, foundation, state, rules):
        # Simpson's rule is exact: f is quadratic and f u cubic in u
        middle, width = 0.5 * (u0 + u1), u1 - u0
        for u, weight in ((u0, width / 6), (middle, 2 * width / 3), (u1, width / 6)):
            f = f0 + u * (f1 + u * f2)
            force += weight * f
            moment += weight * f * u
    for side in (1, -1) if block.edge_radius else ():
        of_edge = _edge_force(block, foundation, state, side)
        force, moment = force + of_edge[0], moment + of_edge[1]
    return force, moment * math.cos(state.theta)


def sideways(block: Block, theta: float, rules: Rules) -> tuple[float, float]:
    """Derivatives x_G′ and x_G″ [m] by θ of the place of the centre of mass over the ground.

    A guided base centre keeps its place (Spanos et al. 2017, section 2, doi:10.1016/j.proeng.2017.09.024),
    x_G = h sinθ + e cosθ. A pivoting block keeps the end of its flat base that is down in its place, which
    adds ± (b - ρ) (1 - cosθ): docs/equations.md, sections 4 and 11. The right corner is down where theta
    [rad] is not negative.
    """
    s, cos = math.sin(theta), math.cos(theta)
    arm = math.copysign(block.flat, theta + 0.0) if rules.kinematics == "pivoting" else 0.0
    along, above = block.com(s, cos)
    return above + arm * s, arm * cos - along


def accelerations(
    block: Block,
    foundation: Foundation,
    state: State,
    rules: Rules = GEOMETRIC,
    *,
    x_ground: float = 0.0,
    z_ground: float = 0.0,
    hand: float = 0.0,
) -> tuple[float, float]:
    """Solve eq. (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) for z̈_cb and θ̈.

    With the x_G(θ) of a pivoting block it is solved for that one: docs/equations.md, section 4.

    The vertical ground acceleration z̈_g, positive upward, acts as a change of gravity,
    g + z̈_g in both equations; the paper prints the opposite sign in (1b), which contradicts (1a).
    A positive horizontal ground acceleration ẍ_g keeps the paper's sign: the ground accelerates to
    the left and the block is tilted clockwise, to the right.

    Parameters
    ----------
    x_ground, z_ground : float
        Ground accelerations ẍ_g and z̈_g [m/s²].
    hand : float
        Moment of a hand on the block, positive clockwise [N·m]. The others as in `contact_intervals`.

    Returns
    -------
    z_cb_acceleration : float
        [m/s²]
    theta_acceleration : float
        [rad/s²]
    """
    force, moment = contact_force(block, foundation, state, rules)
    m, w = block.mass_kg, state.theta_rate
    along, above = block.com(math.sin(state.theta), math.cos(state.theta))
    lever, lever_slope = sideways(block, state.theta, rules)
    turning = hand - moment + along * force + m * lever * (x_ground - lever_slope * w**2)
    theta_acceleration = turning / (block.inertia_cm + m * lever**2)
    return block.g + z_ground - force / m - above * w**2 - along * theta_acceleration, theta_acceleration


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


def _edge_force(block: Block, foundation: Foundation, state: State, side: int) -> tuple[float, float]:
    """Force [N] and moment/cosθ [N·m] on the right (1) or left (-1) edge of the base, rounded with radius ρ.

    With v = ρ sin φ the depth z + u sinθ - ρ (1 - cos φ) is smooth in φ: Gauss's rule of 12 nodes.
    """
    radius, (z, slope, rate, spin) = block.edge_radius, _along_base(state)
    v0, v1 = _edge_ends(z + side * block.flat * slope, side * slope, radius)
    first, last = math.asin(v0 / radius), math.asin(v1 / radius)
    force = moment = 0.0
    for node, weight in _gauss(12):
        phi = 0.5 * (first + last) + 0.5 * (last - first) * node
        u = side * (block.flat + radius * math.sin(phi))
        depth = z + u * slope - radius * (1 - math.cos(phi))
        law = foundation.k * depth + (foundation.c + foundation.lam * depth) * (rate + u * spin)
        f = 0.5 * (last - first) * weight * radius * math.cos(phi) * law
        force += f
        moment += f * u
    return force, moment


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


def _along_base(state: State) -> tuple[float, float, float, float]:
    """z and ż of the base as functions of u: depth + slope u, rate + spin u."""
    return state.z, math.sin(state.theta), state.z_rate, state.theta_rate * math.cos(state.theta)


def _force_coefficients(foundation: Foundation, state: State) -> tuple[float, float, float]:
    """Coefficients of f(u) = f0 + f1 u + f2 u²."""
    k, c, lam = foundation.k, foundation.c, foundation.lam
    depth, slope, rate, spin = _along_base(state)
    return (
        k * depth + c * rate + lam * depth * rate,
        k * slope + c * spin + lam * (slope * rate + depth * spin),
        lam * slope * spin,
    )


def _roots(a0: float, a1: float, a2: float = 0.0) -> list[float]:
    """Real roots of a0 + a1 u + a2 u², without loss of digits."""
    if a2 == 0:
        return [-a0 / a1] if a1 else []
    discriminant = a1 * a1 - 4 * a0 * a2
    if discriminant < 0:
        return []
    q = -0.5 * (a1 + math.copysign(math.sqrt(discriminant), a1))
    return [q / a2, a0 / q] if q else [0.0]
