"""The compiled integrator of the rocking models: one call tree, all of it in this file.

Equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024), divided by the mass, is solved for
the state z_cb, ż_cb, θ, θ̇, of a guided block as there or of one that pivots: what keeps its place sideways
is the base centre, or the corner that stays down, which is another one on either side of θ = 0. The contact
law is a polynomial of the ends of the contact interval, one formula per regime (which end is a corner of the
base, which a root of z(u) or of f(u)). A step uses the formula of the regime and the corner it starts with,
smoothly continued; where an event function (the depth of a corner, for example) changes its sign inside a
step, the root is found on the dense output and the step is taken again to end there. So the method keeps
its order across impacts.

Two methods of order 5 with dense output of order 4 take the steps: Dormand and Prince's explicit 5(4) pair
(doi:10.1016/0771-050X(80)90013-3) and, where the law is stiff, Steinebach's L-stable Rosenbrock method
Rodas5P (doi:10.1007/s10543-023-00967-x) with the analytic Jacobian.
"""

import math
from pathlib import Path

import numpy as np

from freerock.models.compiled import compiled
from freerock.models.ground import VARYING

COMPLETED, AT_REST, OVERTURNED, STEP_LIMIT, NON_FINITE = range(5)

# Regimes of contact: 3 × lower end + upper end of the interval; an end is 0 a corner of the base,
# 1 the root of z(u), 2 the root of the second factor of f(u) (tensionless only).
FULL, LEFT, RIGHT, FLIGHT = 0, 1, 3, 9
# Regimes of Housner's block: turning about a corner, or at rest on its base.
HOUSNER, HOUSNER_REST = 10, 11

# Places of the numbers of a law and its block, in the order of `integrate`.
K, C, LAMBDA, HALF_BASE, HEIGHT, INERTIA, GRAVITY, CORNER, RADIUS, OFFSET = range(10)

A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51, A52, A53, A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A61, A62, A63, A64, A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
A71, A73, A74, A75, A76 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
E1, E3, E4 = 71 / 57600, -71 / 16695, 71 / 1920
E5, E6, E7 = -17253 / 339200, 22 / 525, -1 / 40
D1, D3, D4 = -12715105075 / 11282082432, 87487479700 / 32700410799, -10690763975 / 1880347072
D5, D6, D7 = 701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423

# Rodas5P, in the form in which W k_i = f(y + Σ a_ij k_j) + Σ c_ij k_j / h + h d_i ∂f/∂t, W = I/(γ h) - J
GAMMA = 0.21193756319429014
# Gauss's rule on [0, 1]: f is quadratic and f u cubic in u
NODES = np.array([0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15)])
WEIGHTS = np.array([5 / 18, 8 / 18, 5 / 18])

R_TABLE = np.loadtxt(Path(__file__).with_name("rodas5p.csv"), delimiter=",")
R_A, R_C, R_NODES, R_D, R_H = R_TABLE[:8], R_TABLE[8:16], R_TABLE[16], R_TABLE[17], R_TABLE[18:]


@compiled(forceinline=True)
def sincos(x):
    """sin and cos; the Taylor polynomials are exact to the last digit for |x| < 0.6."""
    if abs(x) < 0.6:
        q = x * x
        q2 = q * q
        q4 = q2 * q2
        s = x * (
            ((1 - q * (1 / 6)) + (1 / 120 - q * (1 / 5040)) * q2)
            + ((1 / 362880 - q * (1 / 39916800)) + (1 / 6227020800 - q * (1 / 1307674368000)) * q2) * q4
        )
        c = 1 - q * (
            ((1 / 2 - q * (1 / 24)) + (1 / 720 - q * (1 / 40320)) * q2)
            + ((1 / 3628800 - q * (1 / 479001600)) + (1 / 87178291200 - q * (1 / 20922789888000)) * q2) * q4
        )
        return s, c
    return math.sin(x), math.cos(x)


@compiled()
def _ground(coefficients, segment, tau, g):
    """Horizontal acceleration and effective gravity at tau since the start of a segment of ground motion.

    Each is c0 + c1 τ + A sin(ω τ + φ).
    """
    if segment < 0 or segment >= coefficients.shape[0]:
        return 0.0, g
    q = coefficients[segment]
    x, z = q[0] + tau * q[1], q[5] + tau * q[6]
    if q[2] != 0:
        x += q[2] * math.sin(q[3] * tau + q[4])
    if q[7] != 0:
        z += q[7] * math.sin(q[8] * tau + q[9])
    return x, g + z


@compiled()
def _ground_rate(coefficients, segment, tau):
    """Time derivative of `_ground`."""
    if segment < 0 or segment >= coefficients.shape[0]:
        return 0.0, 0.0
    q = coefficients[segment]
    x = q[1] + q[2] * q[3] * math.cos(q[3] * tau + q[4])
    z = q[6] + q[7] * q[8] * math.cos(q[8] * tau + q[9])
    return x, z


@compiled(forceinline=True)
def _pressure(depth, rate, law):
    """The contact law f(z, ż) per unit width and mass, and its derivatives by z and by ż."""
    k, c, lam = law[K], law[C], law[LAMBDA]
    return k * depth + (c + lam * depth) * rate, k + lam * rate, c + lam * depth


@compiled()
def _second_root(z, v, s, spin, law):
    """Root of the second factor of f: of k z + c ż, or of k + λ ż."""
    k, c, lam = law[K], law[C], law[LAMBDA]
    if lam > 0:
        return -(k + lam * v) / (lam * spin)
    return -(k * z + c * v) / (k * s + c * spin)


@compiled()
def _ends(regime, z, v, s, spin, law):
    """Ends of the contact interval by the formula of a regime; NaN where it cannot be continued."""
    b = law[HALF_BASE]
    lower, upper = regime // 3, regime % 3
    u0, u1 = -b, b
    if lower == 1:
        u0 = -z / s if s > 0 else math.nan
    elif lower == 2:
        u0 = _second_root(z, v, s, spin, law)
    if upper == 1:
        u1 = -z / s if s < 0 else math.nan
    elif upper == 2:
        u1 = _second_root(z, v, s, spin, law)
    if abs(u0) < 8 * b and abs(u1) < 8 * b:
        return u0, u1
    return math.nan, math.nan


@compiled()
def _moments(u0, u1, z, v, s, spin, law):
    """Integrals over a contact interval of f, of f u, of ∂f/∂z and ∂f/∂ż, and of these by u and by u²."""
    force = moment = f_z = f_v = f_s = f_spin = m_s = m_spin = 0.0
    for i in range(NODES.size):
        u, weight = u0 + NODES[i] * (u1 - u0), WEIGHTS[i] * (u1 - u0)
        f, by_depth, by_rate = _pressure(z + s * u, v + spin * u, law)
        force += weight * f
        moment += weight * f * u
        f_z += weight * by_depth
        f_v += weight * by_rate
        f_s += weight * by_depth * u
        f_spin += weight * by_rate * u
        m_s += weight * by_depth * u * u
        m_spin += weight * by_rate * u * u
    return force, moment, f_z, f_v, f_s, f_spin, m_s, m_spin


@compiled(forceinline=True)
def _force_factors(regime, z, s, cos, law):
    """What the law of the foundation makes of the base in the whole, partial or no contact of a regime.

    Force = f_0 + f_v ż + f_w θ̇ and moment / cosθ = m_0 + m_v ż + m_w θ̇, per unit mass: linear in the rates,
    so that these factors are ready before the rates of a stage are. NaN where the formula can't be continued.
    """
    k, c, lam, b = law[K], law[C], law[LAMBDA], law[HALF_BASE]
    f_0 = f_v = f_w = m_0 = m_v = m_w = 0.0
    if regime in (RIGHT, LEFT):
        sigma = 1.0 if regime == RIGHT else -1.0
        slope = sigma * s
        # seen from the sunken corner: its depth, the length of contact
        depth = z + b * slope
        if not slope > 0 or abs(depth) > 8 * b * slope:
            return math.nan, math.nan, math.nan, math.nan, math.nan, math.nan
        length = depth / slope
        turning = sigma * cos
        by_rate, by_loss = c + 0.5 * lam * depth, 0.5 * c + (1 / 6) * lam * depth
        f_0 = length * (0.5 * k * depth)
        f_v = length * by_rate
        f_w = length * turning * (b * by_rate - length * by_loss)
        area = length * length
        by_length = (1 / 3) * c + (1 / 12) * lam * depth
        m_0 = sigma * (b * f_0 - area * ((1 / 6) * k * depth))
        m_v = sigma * (b * f_v - area * by_loss)
        m_w = sigma * (b * f_w - area * turning * (b * by_loss - length * by_length))
    elif regime == FULL:
        second = (2 / 3) * b * b * b
        f_0 = 2 * b * k * z
        f_v = 2 * b * (c + lam * z)
        f_w = second * lam * s * cos
        m_0 = second * k * s
        m_v = second * lam * s
        m_w = second * (c + lam * z) * cos
    return f_0, f_v, f_w, m_0, m_v, m_w


@compiled()
def _risen(v, radius):
    """Integrals from 0 to v of w, w v and w v², w(v) = ρ - sqrt(ρ² - v²) the rise of an edge."""
    chord = math.sqrt(max(radius * radius - v * v, 0.0))
    cube, sector = chord * chord * chord, v * chord + radius * radius * math.asin(min(v / radius, 1.0))
    return (
        radius * v - 0.5 * sector,
        0.5 * radius * v * v + (cube - radius * radius * radius) * (1 / 3),
        (1 / 3) * radius * v * v * v + 0.25 * v * cube - 0.125 * radius * radius * sector,
    )


@compiled()
def _edge_ends(depth, slope, radius):
    """From where to where an edge touches that begins so deep; equal where it does not."""
    v0, v1 = 0.0, radius
    rest, grown = radius - depth, 1 + slope * slope
    if radius * slope < rest or depth < 0:
        root = radius * radius * slope * slope + depth * (2 * radius - depth)
        if root <= 0 or (depth < 0 and slope <= 0):
            return 0.0, 0.0
        half = math.sqrt(root)
        if radius * slope < rest:
            v1 = min((rest * slope + half) / grown, radius)
        if depth < 0:
            v0 = (rest * slope - half) / grown
    return v0, max(v0, v1)


@compiled()
def _edges(z, s, cos, law):
    """What the rounded edges add to `_force_factors`, by the integrals of depth and of 1, v and v²; at last
    the derivative of f_0 by z."""
    k, c, lam, flat, radius = law[K], law[C], law[LAMBDA], law[HALF_BASE], law[RADIUS]
    f_0 = f_v = f_w = m_0 = m_v = m_w = f_z = 0.0
    for side in (1.0, -1.0):
        depth, slope = z + side * flat * s, side * s
        v0, v1 = _edge_ends(depth, slope, radius)
        if not v1 > v0:
            continue
        low, high = _risen(v0, radius), _risen(v1, radius)
        n_0, n_1, n_2 = v1 - v0, (v1**2 - v0**2) * (1 / 2), (v1**3 - v0**3) * (1 / 3)
        n_3 = (v1**4 - v0**4) * (1 / 4)
        d_0 = depth * n_0 + slope * n_1 - (high[0] - low[0])
        d_1 = depth * n_1 + slope * n_2 - (high[1] - low[1])
        d_2 = depth * n_2 + slope * n_3 - (high[2] - low[2])
        # about the base centre, |u| = flat + v
        d_2 += flat * (2 * d_1 + flat * d_0)
        n_2 += flat * (2 * n_1 + flat * n_0)
        d_1 += flat * d_0
        n_1 += flat * n_0
        f_0 += k * d_0
        f_z += k * n_0
        f_v += c * n_0 + lam * d_0
        f_w += side * (c * n_1 + lam * d_1) * cos
        m_0 += side * k * d_1
        m_v += side * (c * n_1 + lam * d_1)
        m_w += (c * n_2 + lam * d_2) * cos
    return f_0, f_v, f_w, m_0, m_v, m_w, f_z


@compiled()
def depth_at_rest(s, law):
    """Depth of the base centre at which the bed carries a block held still, s = |sinθ|, and the bed's force
    per depth there, over the mass; by Newton's method from below that depth, where the force is convex."""
    b, g, radius = law[HALF_BASE], law[GRAVITY], law[RADIUS]
    z, stiffness = b * s + radius + g / (2 * b * law[K]), 0.0
    for _ in range(100):
        moments = _moments(-z / s if abs(z) < b * s else -b, b, z, 0.0, s, 0.0, law)
        force, stiffness = moments[0], moments[2]
        if radius > 0:
            of_edges = _edges(z, s, 1.0, law)
            force += of_edges[0]
            stiffness += of_edges[6]
        step = (force - g) / stiffness
        z -= step
        if abs(step) <= 1e-15 * b:
            break
    return z, stiffness


@compiled()
def stored(z, s, law):
    """Energy in the bed over the mass, ∫ k z²/2 du over the contact z > 0."""
    k, b, radius = law[K], law[HALF_BASE], law[RADIUS]
    energy, slope = 0.0, abs(s)
    u0 = -z / slope if abs(z) < b * slope else math.copysign(b, -z)
    for i in range(NODES.size):
        depth = z + slope * (u0 + NODES[i] * (b - u0))
        energy += WEIGHTS[i] * (b - u0) * (0.5 * k * depth * depth)
    for side in (1.0, -1.0):
        depth, tilt = z + side * b * s, side * s
        v0, v1 = _edge_ends(depth, tilt, radius)
        if radius > 0 and v1 > v0:
            # the rise w has w² = 2 ρ w - v²
            low, high = _risen(v0, radius), _risen(v1, radius)
            square = depth * depth * (v1 - v0) + depth * tilt * (v1 * v1 - v0 * v0)
            square += (tilt * tilt - 1) * (v1**3 - v0**3) * (1 / 3)
            square -= 2 * (depth - radius) * (high[0] - low[0]) + 2 * tilt * (high[1] - low[1])
            energy += 0.5 * k * square
    return energy


@compiled(forceinline=True)
def _com(s, cos, law):
    """Centre of mass to the right of and above the base centre."""
    h, e = law[HEIGHT], law[OFFSET]
    hs, hc = h * s, h * cos
    if e != 0:
        hs, hc = hs + e * cos, hc - e * s
    return hs, hc


@compiled(forceinline=True)
def _inertia(s, cos, law):
    """x_G′ = h cosθ + a sinθ, -x_G″ and (I_cm + m x_G′²)/m, x_G(θ) the centre of mass over the ground.

    The point that keeps its place sideways lies at a from the base centre: 0, or ±b of the corner.
    """
    a = law[CORNER]
    hs, hc = _com(s, cos, law)
    lever, fall, reduced = hc, hs, law[INERTIA] - hs * hs
    if a != 0:
        rise = a * s
        lever, fall = hc + rise, hs - a * cos
        reduced += rise * (hc + lever)
    return lever, fall, reduced


@compiled(forceinline=True)
def _about_corner(law):
    """Moment of inertia over the mass about the corner turned about."""
    return law[INERTIA] + law[HALF_BASE] * law[HALF_BASE] - 2 * law[OFFSET] * law[CORNER]


@compiled(forceinline=True)
def _accelerations(regime, z, v, theta, w, x_ground, gravity, law):
    """z̈_cb and θ̈ of eq. (1); NaN where the regime's formula cannot be continued to this state."""
    s, cos = sincos(theta)
    lever, fall, reduced = _inertia(s, cos, law)
    if regime >= HOUSNER:
        return 0.0, (x_ground * lever + gravity * fall) / _about_corner(law)
    f_0, f_v, f_w, m_0, m_v, m_w = _force_factors(regime, z, s, cos, law)
    if regime not in (RIGHT, LEFT, FULL, FLIGHT):
        u0, u1 = _ends(regime, z, v, s, w * cos, law)
        moments = _moments(u0, u1, z, v, s, w * cos, law)
        f_0, m_0 = moments[0], moments[1]
    if law[RADIUS] > 0:
        of_edges = _edges(z, s, cos, law)
        f_0 += of_edges[0]
        f_v += of_edges[1]
        f_w += of_edges[2]
        m_0 += of_edges[3]
        m_v += of_edges[4]
        m_w += of_edges[5]
    hs, hc = _com(s, cos, law)
    inverse = 1 / reduced
    t_0 = (lever * x_ground + hs * f_0 - cos * m_0) * inverse
    t_v = (hs * f_v - cos * m_v) * inverse
    t_w = (hs * f_w - cos * m_w) * inverse
    t_ww = lever * fall * inverse
    a_0 = gravity - f_0 - hs * t_0
    a_v = f_v + hs * t_v
    a_w = f_w + hs * t_w
    a_ww = hc + hs * t_ww
    return a_0 - a_v * v - w * (a_w + a_ww * w), t_0 + t_v * v + w * (t_w + t_ww * w)


@compiled()
def _jacobian(regime, y, x_ground, gravity, law):
    """Derivatives of z̈_cb and of θ̈ of a block on a bed with respect to z_cb, ż_cb, θ, θ̇."""
    z, v, theta, w = y
    s, cos = sincos(theta)
    lever, fall, reduced = _inertia(s, cos, law)
    spin = w * cos
    # force, moment/cosθ and their derivatives with respect to z, ż, sinθ, θ̇ cosθ
    u0, u1 = (0.0, 0.0) if regime == FLIGHT else _ends(regime, z, v, s, spin, law)
    force, moment, f_z, f_v, f_s, f_spin, m_s, m_spin = _moments(u0, u1, z, v, s, spin, law)
    m_z, m_v = f_s, f_spin
    # an end at a root of z(u) moves, and f is not zero there
    for is_root, u, slope in ((regime // 3 == 1, u0, s), (regime % 3 == 1, u1, -s)):
        if is_root:
            by_end = _pressure(0.0, v + spin * u, law)[0] / slope
            f_z += by_end
            f_s += by_end * u
            m_z += by_end * u
            m_s += by_end * u * u
    hs, hc = _com(s, cos, law)
    rise, shift = law[CORNER] * s, law[CORNER] * cos
    turn = (lever * (x_ground + fall * w * w) + hs * force - cos * moment) / reduced
    f_theta = f_s * cos - f_spin * w * s
    m_theta = m_s * cos - m_spin * w * s
    b_z = (hs * f_z - cos * m_z) / reduced
    b_v = (hs * f_v - cos * m_v) / reduced
    b_w = (2 * lever * fall * w + (hs * f_spin - cos * m_spin) * cos) / reduced
    b_theta = (
        (hc * hc - hs * hs + rise * (hc + lever) + shift * (hs + fall)) * w * w
        - fall * x_ground
        + hc * force
        + hs * f_theta
        + s * moment
        - cos * m_theta
        + 2 * fall * lever * turn
    ) / reduced
    a_theta = hs * w * w - f_theta - hc * turn - hs * b_theta
    return (
        -f_z - hs * b_z,
        -f_v - hs * b_v,
        a_theta,
        -f_spin * cos - 2 * hc * w - hs * b_w,
        b_z,
        b_v,
        b_theta,
        b_w,
    )


@compiled()
def _event(i, y, law):
    """Event functions; the signs of the first five make up the regime of contact.

    0, 1: depth of the right and left corner; 2, 3: second factor of f there;
    4: distance between the roots of the two factors; 5: θ towards the corner turned about.
    """
    z, v, theta, w = y
    if i == 5:
        return theta * math.copysign(1.0, law[CORNER])
    k, c, lam, b = law[K], law[C], law[LAMBDA], law[HALF_BASE]
    s, cos = sincos(theta)
    spin = w * cos
    if i == 4:
        return _second_root(z, v, s, spin, law) + z / s
    u = -b if i % 2 else b
    if i < 2:
        return z + u * s
    if lam > 0:
        return k + lam * (v + u * spin)
    return k * (z + u * s) + c * (v + u * spin)


@compiled()
def _event_rate(i, y, law):
    """Rate of event functions 0, 1 and 5."""
    if i == 5:
        return y[3] * math.copysign(1.0, law[CORNER])
    swing = law[HALF_BASE] * y[3] * sincos(y[2])[1]
    return y[1] - swing if i == 1 else y[1] + swing


@compiled()
def _watched(i, bits):
    """The distance between two roots counts only while both lie inside the base."""
    return i != 4 or ((bits ^ (bits >> 1)) & 5) == 5


@compiled()
def _signs(tensionless, y, law):
    """Signs of the event functions of contact as bits."""
    bits = 0
    for i in range(5 if tensionless else 2):
        if _watched(i, bits) and _event(i, y, law) > 0:
            bits |= 1 << i
    return bits


@compiled()
def _regime(bits, tensionless):
    """Regime of contact from the signs of the event functions."""
    right, left = bits & 1, bits & 2
    lower = 1 if right and not left else 0
    upper = 1 if left and not right else 0
    if not (right or left):
        return FLIGHT
    if tensionless:
        right, left, beyond = bits & 4, bits & 8, bits & 16
        if not (right or left):
            return FLIGHT
        if right and not left:
            if upper == 1 and beyond:
                return FLIGHT
            if lower == 0 or beyond:
                lower = 2
        elif left and not right:
            if lower == 1 and not beyond:
                return FLIGHT
            if upper == 0 or not beyond:
                upper = 2
    return 3 * lower + upper


@compiled(forceinline=True)
def _step_explicit(regime, h, y, f, ground, law, weights, dense):
    """One step of the 5(4) pair.

    Returns the new state, its accelerations, the square of the error over the tolerance, and an estimate
    of (h times the largest eigenvalue) squared.
    """
    coefficients, segment, tau = ground
    z, v, t, w = y
    a1, b1 = f
    excited = coefficients.shape[0] > 0
    g = law[GRAVITY]
    x, gravity = 0.0, g
    if excited:
        x, gravity = _ground(coefficients, segment, tau + h * (1 / 5), g)
    q1 = h * A21
    v2 = v + q1 * a1
    w2 = w + q1 * b1
    a2, b2 = _accelerations(regime, z + q1 * v, v2, t + q1 * w, w2, x, gravity, law)
    if excited:
        x, gravity = _ground(coefficients, segment, tau + h * (3 / 10), g)
    q1, q2 = h * A31, h * A32
    v3 = v + q1 * a1 + q2 * a2
    w3 = w + q1 * b1 + q2 * b2
    a3, b3 = _accelerations(regime, z + q1 * v + q2 * v2, v3, t + q1 * w + q2 * w2, w3, x, gravity, law)
    if excited:
        x, gravity = _ground(coefficients, segment, tau + h * (4 / 5), g)
    q1, q2, q3 = h * A41, h * A42, h * A43
    v4 = v + q1 * a1 + q2 * a2 + q3 * a3
    w4 = w + q1 * b1 + q2 * b2 + q3 * b3
    z4 = z + q1 * v + q2 * v2 + q3 * v3
    t4 = t + q1 * w + q2 * w2 + q3 * w3
    a4, b4 = _accelerations(regime, z4, v4, t4, w4, x, gravity, law)
    if excited:
        x, gravity = _ground(coefficients, segment, tau + h * (8 / 9), g)
    q1, q2, q3, q4 = h * A51, h * A52, h * A53, h * A54
    v5 = v + q1 * a1 + q2 * a2 + q3 * a3 + q4 * a4
    w5 = w + q1 * b1 + q2 * b2 + q3 * b3 + q4 * b4
    z5 = z + q1 * v + q2 * v2 + q3 * v3 + q4 * v4
    t5 = t + q1 * w + q2 * w2 + q3 * w3 + q4 * w4
    a5, b5 = _accelerations(regime, z5, v5, t5, w5, x, gravity, law)
    if excited:
        x, gravity = _ground(coefficients, segment, tau + h, g)
    q1, q2, q3, q4, q5 = h * A61, h * A62, h * A63, h * A64, h * A65
    v6 = v + q1 * a1 + q2 * a2 + q3 * a3 + q4 * a4 + q5 * a5
    w6 = w + q1 * b1 + q2 * b2 + q3 * b3 + q4 * b4 + q5 * b5
    z6 = z + q1 * v + q2 * v2 + q3 * v3 + q4 * v4 + q5 * v5
    t6 = t + q1 * w + q2 * w2 + q3 * w3 + q4 * w4 + q5 * w5
    a6, b6 = _accelerations(regime, z6, v6, t6, w6, x, gravity, law)
    q1, q3, q4, q5, q6 = h * A71, h * A73, h * A74, h * A75, h * A76
    v7 = v + q1 * a1 + q3 * a3 + q4 * a4 + q5 * a5 + q6 * a6
    w7 = w + q1 * b1 + q3 * b3 + q4 * b4 + q5 * b5 + q6 * b6
    z7 = z + q1 * v + q3 * v3 + q4 * v4 + q5 * v5 + q6 * v6
    t7 = t + q1 * w + q3 * w3 + q4 * w4 + q5 * w5 + q6 * w6
    a7, b7 = _accelerations(regime, z7, v7, t7, w7, x, gravity, law)
    ez = weights[0] * (E1 * v + E3 * v3 + E4 * v4 + E5 * v5 + E6 * v6 + E7 * v7)
    ev = weights[1] * (E1 * a1 + E3 * a3 + E4 * a4 + E5 * a5 + E6 * a6 + E7 * a7)
    et = weights[0] * weights[2] * (E1 * w + E3 * w3 + E4 * w4 + E5 * w5 + E6 * w6 + E7 * w7)
    ew = weights[1] * weights[2] * (E1 * b1 + E3 * b3 + E4 * b4 + E5 * b5 + E6 * b6 + E7 * b7)
    _dense(dense, 0, h, z, z7, v, v7, D1 * v + D3 * v3 + D4 * v4 + D5 * v5 + D6 * v6 + D7 * v7)
    _dense(dense, 1, h, v, v7, a1, a7, D1 * a1 + D3 * a3 + D4 * a4 + D5 * a5 + D6 * a6 + D7 * a7)
    _dense(dense, 2, h, t, t7, w, w7, D1 * w + D3 * w3 + D4 * w4 + D5 * w5 + D6 * w6 + D7 * w7)
    _dense(dense, 3, h, w, w7, b1, b7, D1 * b1 + D3 * b3 + D4 * b4 + D5 * b5 + D6 * b6 + D7 * b7)
    change = (v7 - v6) ** 2 + (weights[2] * (w7 - w6)) ** 2
    stiffness = h * h * ((a7 - a6) ** 2 + (weights[2] * (b7 - b6)) ** 2) / change if change > 0 else 0.0
    return (z7, v7, t7, w7), (a7, b7), h * h * (ez * ez + ev * ev + et * et + ew * ew), stiffness


@compiled()
def _step_implicit(regime, h, y, f, ground, law, weights, dense, stages):
    """One step of Rodas5P, of a block on a bed; arguments and results as in `_step_explicit`."""
    coefficients, segment, tau = ground
    z, v, t, w = y
    g = law[GRAVITY]
    x, gravity = _ground(coefficients, segment, tau, g)
    a_z, a_v, a_t, a_w, b_z, b_v, b_t, b_w = _jacobian(regime, y, x, gravity, law)
    x_rate, z_rate = _ground_rate(coefficients, segment, tau)
    s, cos = sincos(t)
    lever, _, reduced = _inertia(s, cos, law)
    b_time = lever * x_rate / reduced
    a_time = z_rate - _com(s, cos, law)[0] * b_time
    # W k = r, reduced to the two accelerations since the rates of z and θ are ż and θ̇
    q = 1 / (GAMMA * h)
    m11, m12 = q * q - a_z - q * a_v, -a_t - q * a_w
    m21, m22 = -b_z - q * b_v, q * q - b_t - q * b_w
    inverse = 1 / (m11 * m22 - m12 * m21)
    (zi, vi, ti, wi), (ai, bi) = y, f
    for i in range(8):
        if i > 0:
            zi, vi, ti, wi = y
            for j in range(i):
                r = R_A[i, j]
                zi += r * stages[j, 0]
                vi += r * stages[j, 1]
                ti += r * stages[j, 2]
                wi += r * stages[j, 3]
            x, gravity = _ground(coefficients, segment, tau + R_NODES[i] * h, g)
            ai, bi = _accelerations(regime, zi, vi, ti, wi, x, gravity, law)
        rz, rv, rt, rw = vi, ai + h * R_D[i] * a_time, wi, bi + h * R_D[i] * b_time
        for j in range(i):
            r = R_C[i, j] / h
            rz += r * stages[j, 0]
            rv += r * stages[j, 1]
            rt += r * stages[j, 2]
            rw += r * stages[j, 3]
        r1 = rv + (q - a_v) * rz - a_w * rt
        r2 = rw + (q - b_w) * rt - b_v * rz
        stages[i, 0] = (m22 * r1 - m12 * r2) * inverse
        stages[i, 2] = (m11 * r2 - m21 * r1) * inverse
        stages[i, 1] = q * stages[i, 0] - rz
        stages[i, 3] = q * stages[i, 2] - rt
    z1, v1, t1, w1 = zi + stages[7, 0], vi + stages[7, 1], ti + stages[7, 2], wi + stages[7, 3]
    f1 = _accelerations(regime, z1, v1, t1, w1, x, gravity, law)
    ez, ev = weights[0] * stages[7, 0], weights[1] * stages[7, 1]
    et, ew = weights[0] * weights[2] * stages[7, 2], weights[1] * weights[2] * stages[7, 3]
    for i in range(4):
        d2 = d3 = d4 = 0.0
        for j in range(8):
            d2 += R_H[0, j] * stages[j, i]
            d3 += R_H[1, j] * stages[j, i]
            d4 += R_H[2, j] * stages[j, i]
        dense[i, 2], dense[i, 3], dense[i, 4] = d2, d3 + d4, -d4
    dense[0, 0], dense[1, 0], dense[2, 0], dense[3, 0] = z, v, t, w
    dense[0, 1], dense[1, 1], dense[2, 1], dense[3, 1] = z1 - z, v1 - v, t1 - t, w1 - w
    stiffness = h * h * max((abs(a_v) + abs(b_w)) ** 2, abs(a_z) + abs(b_t))
    return (z1, v1, t1, w1), f1, ez * ez + ev * ev + et * et + ew * ew, stiffness


@compiled()
def _step(stiff, regime, h, y, f, ground, law, weights, dense, stages):
    """One step of the method in use."""
    if stiff:
        return _step_implicit(regime, h, y, f, ground, law, weights, dense, stages)
    return _step_explicit(regime, h, y, f, ground, law, weights, dense)


@compiled()
def _dense(dense, i, h, y0, y1, rate0, rate1, last):
    """Coefficients of component i: y0 + x (Δ + (1 - x) (d2 + x (d3 + (1 - x) d4)))."""
    change = y1 - y0
    d2 = h * rate0 - change
    dense[i, 0] = y0
    dense[i, 1] = change
    dense[i, 2] = d2
    dense[i, 3] = change - h * rate1 - d2
    dense[i, 4] = h * last


@compiled()
def _at(dense, i, x):
    """Dense output of component i at the fraction x of the step."""
    r = 1 - x
    return dense[i, 0] + x * (dense[i, 1] + r * (dense[i, 2] + x * (dense[i, 3] + r * dense[i, 4])))


@compiled()
def _state_at(dense, x):
    return _at(dense, 0, x), _at(dense, 1, x), _at(dense, 2, x), _at(dense, 3, x)


@compiled()
def _crossing(i, positive, dense, right, law):
    """First fraction x <= right of the step at which event function i leaves its sign, or 0."""
    sign = 1.0 if positive else -1.0
    f_right = sign * _event(i, _state_at(dense, right), law)
    left = 0.0
    f_left = sign * _event(i, _state_at(dense, left), law)
    if not f_left > 1e-12 * abs(f_right):
        # just after an event the residual may have either sign: look for the excursion
        left = right
        f_left = 0.0
        while not f_left > 0:
            left *= 0.5
            if left < 1e-9:
                return 0.0
            f_left = sign * _event(i, _state_at(dense, left), law)
    kept = 0
    for n in range(60):
        # regula falsi (Illinois), with a bisection now and then
        x = (left * f_right - right * f_left) / (f_right - f_left) if n % 4 != 3 else 0.5 * (left + right)
        f = sign * _event(i, _state_at(dense, x), law)
        if f > 0:
            if kept == 1:
                f_right *= 0.5
            left, f_left, kept = x, f, 1
        else:
            if kept == -1:
                f_left *= 0.5
            right, f_right, kept = x, f, -1
        if right - left < 1e-13 or f == 0:
            break
    return right


@compiled()
def _excursion(i, positive, dense, law):
    """Fraction of the step at which event function i has left the sign it has at both ends, or 0."""
    if 2 <= i < 5:
        for n in range(1, 4):
            if (_event(i, _state_at(dense, 0.25 * n), law) > 0) != positive:
                return 0.25 * n
        return 0.0
    rate0 = _event_rate(i, _state_at(dense, 0.0), law)
    rate1 = _event_rate(i, _state_at(dense, 1.0), law)
    if rate0 * rate1 < 0 and (rate0 < 0) == positive:
        x = rate0 / (rate0 - rate1)
        if (_event(i, _state_at(dense, x), law) > 0) != positive:
            return x
    return 0.0


@compiled()
def _first_event(regime, bits, tensionless, pivots, dense, law):
    """Fraction of the step at which its first event happens, and which; (2, -1) without one.

    `pivots`: whether a change of corner counts.
    """
    first, which = 2.0, -1
    for i in range(5 if regime == HOUSNER else 0, 6 if pivots else 5 if tensionless else 2):
        if (2 <= i < 5 and not tensionless) or not _watched(i, bits):
            continue
        positive = i == 5 or (bits >> i) & 1 == 1
        right = 1.0
        if (_event(i, _state_at(dense, 1.0), law) > 0) == positive:
            right = _excursion(i, positive, dense, law)
        if right > 0:
            x = _crossing(i, positive, dense, right, law)
            if x < first:
                first, which = x, i
    return first, which


@compiled()
def _may_cross(bits, pivots, y, swing, v_before, swing_before, law):
    """Whether a corner's depth, or a θ that counts, has changed its sign over a step, or its rate has."""
    z, v, theta, _ = y
    reach, a = law[HALF_BASE] * sincos(theta)[0], math.copysign(1.0, law[CORNER])
    return (
        (z + reach > 0) != (bits & 1 > 0)
        or (z - reach > 0) != (bits & 2 > 0)
        or (v + swing) * (v_before + swing_before) < 0
        or (v - swing) * (v_before - swing_before) < 0
        or (pivots and (a * theta <= 0 or a * swing_before < 0 < a * swing))
    )


@compiled()
def _lift(coefficients, segment, tau, duration, law):
    """Time from tau until Housner's block at rest lifts within the segment, at most `duration`."""
    slope, off = law[HALF_BASE] / law[HEIGHT], law[OFFSET] / law[HEIGHT]
    parts = 64 if coefficients[segment, 2] != 0 or coefficients[segment, 7] != 0 else 4
    left = 0.0
    for i in range(parts + 1):
        right = duration * i / parts
        x, gravity = _ground(coefficients, segment, tau + right, law[GRAVITY])
        if abs(x + gravity * off) > gravity * slope:
            for _ in range(60):
                middle = 0.5 * (left + right)
                x, gravity = _ground(coefficients, segment, tau + middle, law[GRAVITY])
                if abs(x + gravity * off) > gravity * slope:
                    right = middle
                else:
                    left = middle
            return right
        left = right
    return duration


@compiled()
def _sample(dense, t, step, end, time, n, out, rates):
    """Fill the samples from the n-th up to `end` from the dense output; the number of the next one."""
    scale = 1 / step
    while n < time.size and time[n] <= end:
        x = (time[n] - t) * scale
        out[n] = _at(dense, 2, x)
        if rates.size > 0:
            rates[n, 0], rates[n, 1], rates[n, 2] = _at(dense, 0, x), _at(dense, 1, x), _at(dense, 3, x)
        n += 1
    return n


@compiled()
def _fill(n, theta, z, rate, out, rates):
    """Fill all samples from the n-th with one state."""
    for i in range(n, out.size):
        out[i] = theta
        if rates.size > 0:
            rates[i, 0], rates[i, 1], rates[i, 2] = z, rate, rate


@compiled()
def _begun(y, time, breaks, out, rates):
    """Fill the samples up to t = 0 with the start; the number of the next one, and the segment of ground
    motion: -1 before the first, as many as there are after the last."""
    n, n_segments = 0, max(breaks.size - 1, 0)
    while n < time.size and time[n] <= 0:
        out[n] = y[2]
        if rates.size > 0:
            rates[n, 0], rates[n, 1], rates[n, 2] = y[0], y[1], y[3]
        n += 1
    segment = -1 if n_segments > 0 else 0
    while segment < n_segments and n_segments > 0 and breaks[segment + 1] <= 0:
        segment += 1
    return n, segment


@compiled()
def _is_over(y, theta_cr, moves):
    """Whether a block is beyond return, or lies on a side while the ground moves."""
    if moves:
        return abs(y[2]) > 0.5 * math.pi
    return abs(y[2]) > theta_cr and y[2] * y[3] >= 0


@compiled()
def _is_steady(coefficients, segment):
    """Whether the ground accelerates evenly, or not at all, in a segment."""
    if 0 <= segment < coefficients.shape[0]:
        for i in VARYING:
            if coefficients[segment, i] != 0:
                return False
    return True


@compiled()
def integrate(
    law,
    restitution,
    tensionless,
    y,
    time,
    breaks,
    coefficients,
    tolerance,
    max_steps,
    factors,
    passages,
    out,
    rates,
):
    """Integrate from t = 0 and sample at `time`.

    Parameters
    ----------
    law : tuple of 10 floats, at the places K to OFFSET
        k/m, c/m, λ/m, half the flat part of the base (b, where its edges are sharp), h, (I_cm + m h²)/m, g, b
        where the block turns about its corners or 0 where it is guided, the radius of its edges, which
        requires a guided block and the geometric rule of debonding, and the offset e of the centre of mass to
        the right of the middle (I_cm + m (h² + e²) is then the moment of inertia).
    restitution : float
        r of Housner's block; negative for a contact law.
    tensionless : bool
        Rule of debonding; needs c = 0 or λ = 0.
    y : tuple of 4 floats
        z_cb, ż_cb, θ, θ̇ at t = 0.
    time : ndarray, shape (n_time,)
        Increasing; negative times get the initial state.
    breaks : ndarray, shape (n_segments + 1,); coefficients : ndarray, shape (n_segments, 10)
        Ground motion, as in `_ground`; no segments for free rocking.
    tolerance : float
        Error allowed in θ per step [rad]; that of the other components is scaled by b and p.
    max_steps : int
        Steps, taken or rejected, after which to give up.
    factors : ndarray, shape (n_impacts,)
        What the rate is multiplied with at the first passages of θ = 0, be a side lifted before or not;
        beside the restitution of Housner's block.
    passages : ndarray, shape (n_impacts, 5)
        Receives instant [s], z_cb, ż_cb, the factor and θ̇ just after each of these passages; without rows
        they are not wanted. Where it holds a θ̇ > 0, that is the rate after the passage, whatever its factor.
    out : ndarray, shape (n_time,)
        Receives θ.
    rates : ndarray, shape (n_time, 3)
        Receives z_cb, ż_cb, θ̇; without rows these and the impacts are not wanted.

    Returns
    -------
    outcome, steps, rejected, implicit, evaluations : int
    impacts : ndarray
        Instants at which θ changes its sign [s], if `rates` has rows.
    """
    k, c, lam, b, h, inertia, g, corner, radius, e = law
    housner = restitution >= 0
    p = math.sqrt(g * math.sqrt(b * b + h * h) / (inertia + b * b))
    theta_cr = math.atan2(b + radius + abs(e), h)
    weights = (1 / (tolerance * b), 1 / (tolerance * b * p), b)
    # where the block changes its corner, θ̈ jumps by w² times this; a step must make more of it to count
    kick = 2 * corner * h / inertia
    least = 0.01 * tolerance * p
    flat, sinking = (0.0, 0.0) if housner else depth_at_rest(0.0, law)
    # stiffness of the upright block against turning, and the energy below which it is at rest
    turning = sinking * b * b * (1 / 3) - g * h
    rest = 0.5 * turning * (0.03 * tolerance) ** 2 if c > 0 or lam > 0 else -1.0
    dense = np.zeros((4, 5))
    stages = np.empty((8, 4))
    record = rates.size > 0
    impacts = np.empty(0)
    n_time, n_segments = time.size, coefficients.shape[0]
    steps = rejected = implicit = evaluations = n_passed = 0
    n, segment = _begun(y, time, breaks, out, rates)
    right = y[2] > 0 or (y[2] == 0 and y[3] > 0)
    sign = 1.0 if right else -1.0
    law = (k, c, lam, b, h, inertia, g, sign * corner, radius, e)
    bits = 0
    if not housner:
        bits = _signs(tensionless, y, law)
        regime = _regime(bits, tensionless)
    elif y[2] == 0 and y[3] == 0:
        regime = HOUSNER_REST
    else:
        regime = HOUSNER
    t = 0.0
    size = 0.01 / p
    error_before = 1.0
    stiffness_count = 0
    stiff = False
    fresh = True
    f = (0.0, 0.0)
    swing = 0.0
    outcome = COMPLETED

    while n < n_time:
        if steps + rejected >= max_steps:
            outcome = STEP_LIMIT
            break
        t_segment = breaks[segment] if 0 <= segment < n_segments else 0.0
        left_in_segment = breaks[segment + 1] - t if segment < n_segments else math.inf

        if regime == HOUSNER_REST:
            if segment >= n_segments:
                outcome = AT_REST
                break
            step = left_in_segment
            if segment >= 0:
                step = _lift(coefficients, segment, t - t_segment, left_in_segment, law)
            end = breaks[segment + 1] if step >= left_in_segment else t + step
            for i in range(4):
                for j in range(5):
                    dense[i, j] = 0.0
            if step > 0:
                n = _sample(dense, t, step, end, time, n, out, rates)
            t = end
            steps += 1
            if step >= left_in_segment:
                segment += 1
                t_segment = t
            x, gravity = _ground(coefficients, segment, t - t_segment, g)
            push = x + gravity * e / h
            if step < left_in_segment or abs(push) * h > gravity * b:
                regime = HOUSNER
                sign = 1.0 if push > 0 else -1.0
                law = (k, c, lam, b, h, inertia, g, sign * corner, radius, e)
                size = 0.01 / p
                fresh = True
            continue

        if fresh:
            x, gravity = _ground(coefficients, segment, t - t_segment, g)
            f = _accelerations(regime, y[0], y[1], y[2], y[3], x, gravity, law)
            swing = b * y[3] * sincos(y[2])[1]
            evaluations += 1
            fresh = False
        whole = size >= left_in_segment
        step = left_in_segment if whole else size
        # the step; where an event happens inside it, the step to there
        which = -1
        accepted = False
        for attempt in range(5):
            ground = coefficients, segment, t - t_segment
            y1, f1, error, stiffness = _step(stiff, regime, step, y, f, ground, law, weights, dense, stages)
            evaluations += 9 if stiff else 6
            if attempt == 0:
                accepted = error <= 1
                if not accepted:
                    break
                # proportional-integral control
                error = max(error, 1e-12)
                growth = min(5.0, 0.9 * error_before**0.02 / error**0.06)
                size = max(step * growth, size if whole else 0.0)
                error_before = error
                swing1 = b * y1[3] * sincos(y1[2])[1]
                counts = n_passed < factors.size
                pivots = housner or counts or kick * step * max(y[3] * y[3], y1[3] * y1[3]) > least
                if tensionless or housner or _may_cross(bits, pivots, y1, swing1, y[1], swing, law):
                    first, which = _first_event(regime, bits, tensionless, pivots, dense, law)
                if which < 0:
                    break
                whole = False
                step *= first
                if step * p < 1e-15:
                    step = 0.0
                    y1 = y
                    break
            elif not error <= 1:
                accepted = False
                break
            elif 2 <= which < 5:
                break
            else:
                residual = _event(which, y1, law)
                if abs(residual) <= 0.01 * tolerance * (1.0 if which == 5 else b):
                    break
                correction = -residual / _event_rate(which, y1, law)
                if not abs(correction) < 0.1 * step:
                    break
                step += correction
        if not accepted:
            rejected += 1
            size = step * (max(0.2, 0.9 * error**-0.1) if error < 1e20 else 0.2)
            if size * p < 1e-15:
                outcome = NON_FINITE
                break
            continue
        if stiffness > (1.0 if stiff else 6.25) and radius == 0 and not housner:
            stiffness_count = min(stiffness_count + 1, 4)
            stiff = stiff or stiffness_count == 4
        elif stiffness_count > 0:
            stiffness_count -= 1
            stiff = stiff and stiffness_count > 0

        end = breaks[segment + 1] if whole else t + step
        if step > 0:
            n = _sample(dense, t, step, end, time, n, out, rates)
        if turned := which == 5 or sign * y1[2] < 0:
            # a block upright at rest has no side to leave
            if record and (y[2] != 0 or y[3] != 0):
                impacts = np.append(
                    impacts, end if which == 5 else t + step * _crossing(5, True, dense, 1.0, law)
                )
            sign = -sign
            law = (k, c, lam, b, h, inertia, g, sign * corner, radius, e)
        steps += 1
        implicit += stiff
        t, y, f, swing = end, y1, f1, swing1
        fresh = whole or which >= 0 or (turned and corner > 0)
        counted = which == 5 and n_passed < factors.size
        factor = factors[n_passed] if counted else 1.0
        held = passages[n_passed, 4] if counted and n_passed < passages.shape[0] else 0.0
        if which == 5 and not housner:
            factor = held / abs(y[3]) if held > 0 else factor
            y = (y[0], y[1], 0.0, factor * y[3])
        elif which == 5:
            x, gravity = _ground(coefficients, segment, t - t_segment, g)
            hold = gravity * b - abs(x + gravity * e / h) * h
            # the impact is located within a tolerance: the rate where θ is zero, by the work done since
            w = restitution * math.copysign(math.sqrt(max(y[3] * y[3] - 2 * f[1] * y[2], 0.0)), y[3])
            factor = held / abs(w) if held > 0 else factor
            w *= factor
            # of a swing whose top is hardly beyond what an impact is located to, none is told from rest
            if hold > 0 and w * w * (inertia + b * b) < 0.05 * tolerance * hold:
                w = 0.0
                regime = HOUSNER_REST
            y = (0.0, 0.0, 0.0, w)
        if counted:
            if n_passed < passages.shape[0]:
                passages[n_passed, 0], passages[n_passed, 1], passages[n_passed, 2] = end, y[0], y[1]
                passages[n_passed, 3], passages[n_passed, 4] = factor, y[3]
            n_passed += 1
        if 0 <= which < 5:
            bits ^= 1 << which
            if which < 4 and y[2] == 0 and y[3] == 0:
                # upright and not turning: what happens at one corner happens at the other
                bits ^= 1 << (which ^ 1)
            if tensionless and which != 4 and _watched(4, bits):
                bits &= 15
                if _event(4, y, law) > 0:
                    bits |= 16
            regime = _regime(bits, tensionless)
        if whole:
            segment += 1

        if _is_over(y, theta_cr, segment < n_segments):
            outcome = OVERTURNED
            break
        if regime == FULL and turning > 0 and _is_steady(coefficients, segment):
            energy = 0.5 * y[1] * y[1] + 0.5 * inertia * y[3] * y[3] + h * sincos(y[2])[0] * y[1] * y[3]
            if energy < rest:
                # what bed and weight store, seen from where they balance: by how much they do not yet
                x, gravity = _ground(coefficients, segment, 0.0, g)
                rise, turn = _accelerations(regime, y[0], 0.0, y[2], 0.0, x, gravity, law)
                energy += 0.5 * rise * rise / sinking + 0.5 * (inertia * turn) ** 2 / turning
            if energy < rest:
                y = (y[0], 0.0, y[2], 0.0) if e != 0 or 0 <= segment < n_segments else (flat, 0.0, 0.0, 0.0)
                if segment >= n_segments:
                    outcome = AT_REST
                    break
                dense[:, 1:] = 0.0
                dense[0, 0], dense[1, 0], dense[2, 0], dense[3, 0] = y
                end = breaks[segment + 1]
                if end > t:
                    n = _sample(dense, t, end - t, end, time, n, out, rates)
                t = end
                segment += 1
                fresh = True
    if outcome == AT_REST:
        _fill(n, y[2], y[0], 0.0, out, rates)
    else:
        _fill(n, math.nan, math.nan, math.nan, out, rates)
    return outcome, steps, rejected, implicit, evaluations, impacts


def accelerations(
    law: tuple[float, ...],
    tensionless: bool,
    y: tuple[float, float, float, float],
    x_ground: float = 0.0,
    z_ground: float = 0.0,
) -> tuple[float, float]:
    """z̈_cb [m/s²] and θ̈ [rad/s²] of a block on a bed: eq. (1) of Spanos et al. 2017.

    doi:10.1016/j.proeng.2017.09.024. A vertical acceleration of the ground, positive upward, acts as a change
    of gravity; the paper prints the opposite sign in (1b), which contradicts (1a). A positive horizontal one
    keeps the paper's sign: the ground accelerates to the left and tilts the block clockwise.

    Parameters
    ----------
    law, tensionless, y :
        As for `integrate`.
    x_ground, z_ground : float
        Accelerations of the ground [m/s²].
    """
    law = (*law[:CORNER], math.copysign(law[CORNER], y[2]) if law[CORNER] else 0.0, *law[CORNER + 1 :])
    regime = _regime(_signs(tensionless, y, law), tensionless)
    found: tuple[float, float] = _accelerations(
        regime, y[0], y[1], y[2], y[3], x_ground, law[GRAVITY] + z_ground, law
    )
    return found
