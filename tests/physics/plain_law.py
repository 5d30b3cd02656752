"""The law of a bed and the equation of motion in plain Python, by which the compiled kernel is checked.

With u in [-b, b] measured from the base centre, positive to the right, z(u) = z_cb + u sinθ and
ż(u) = ż_cb + u θ̇ cosθ are linear in u, so that contact is an interval of u (at most two for c λ > 0) and
force and moment are polynomial moments over it. What the base does sideways enters by `sideways` alone.
Rounded edges of radius ρ lie w = ρ - sqrt(ρ² - v²) higher at v beyond the flat part of the base.
"""

import math
from itertools import pairwise

from numpy.polynomial.legendre import leggauss

from freerock.models.block import Block
from freerock.models.block_on_bed import State
from freerock.models.laws import GEOMETRIC, Foundation, Rules


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
    for side in (1, -1) if block.edge_radius_m else ():
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


def _edge_force(block: Block, foundation: Foundation, state: State, side: int) -> tuple[float, float]:
    """Force [N] and moment/cosθ [N·m] on the right (1) or left (-1) edge of the base, rounded with radius ρ.

    With v = ρ sin φ the depth z + u sinθ - ρ (1 - cos φ) is smooth in φ: Gauss's rule of 12 nodes.
    """
    radius, (z, slope, rate, spin) = block.edge_radius_m, _along_base(state)
    v0, v1 = _edge_ends(z + side * block.flat * slope, side * slope, radius)
    first, last = math.asin(v0 / radius), math.asin(v1 / radius)
    force = moment = 0.0
    for node, weight in zip(*map(list, leggauss(12)), strict=True):
        phi = 0.5 * (first + last) + 0.5 * (last - first) * node
        u = side * (block.flat + radius * math.sin(phi))
        depth = z + u * slope - radius * (1 - math.cos(phi))
        law = foundation.k * depth + (foundation.c + foundation.lam * depth) * (rate + u * spin)
        f = 0.5 * (last - first) * weight * radius * math.cos(phi) * law
        force += f
        moment += f * u
    return force, moment


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
