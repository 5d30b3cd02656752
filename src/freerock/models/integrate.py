"""The compiled integrator of the rocking models: one call tree, all of it in this file.

Equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024), divided by the mass, is solved for
the state z_cb, ż_cb, θ, θ̇. The contact law is a polynomial of the ends of the contact interval, one
formula per regime (which end is a corner of the base, which a root of z(u) or of f(u)). A step uses the
formula of the regime it starts in, smoothly continued; where an event function (the depth of a corner,
for example) changes its sign inside a step, the root is found on the dense output and the step is taken
again to end there. So the method keeps its order across impacts.

Dormand and Prince's 5(4) pair (doi:10.1016/0771-050X(80)90013-3) with its fourth-order dense output.
"""

import math

import numpy as np
from numba import njit

COMPLETED, AT_REST, OVERTURNED, STEP_LIMIT, NON_FINITE = range(5)

# Regimes of contact: 3 × lower end + upper end of the interval; an end is 0 a corner of the base,
# 1 the root of z(u), 2 the root of the second factor of f(u) (tensionless only).
FULL, LEFT, RIGHT, FLIGHT = 0, 1, 3, 9
# Regimes of Housner's block: turning about a corner, or at rest on its base.
HOUSNER_RIGHT, HOUSNER_LEFT, HOUSNER_REST = 10, 11, 12

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


@njit(cache=True, nogil=True)
def _sincos(x):
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


@njit(cache=True, nogil=True)
def _ground(coefficients, segment, tau):
    """Ground accelerations at tau since the start of a segment: cubic plus a harmonic, in x and in z."""
    if segment < 0 or segment >= coefficients.shape[0]:
        return 0.0, 0.0
    q = coefficients[segment]
    x = q[0] + tau * (q[1] + tau * (q[2] + tau * q[3]))
    z = q[7] + tau * (q[8] + tau * (q[9] + tau * q[10]))
    if q[4] != 0:
        x += q[4] * math.sin(q[5] * tau + q[6])
    if q[11] != 0:
        z += q[11] * math.sin(q[12] * tau + q[13])
    return x, z


@njit(cache=True, nogil=True)
def _second_root(z, v, s, spin, law):
    """Root of the second factor of f: of k z + c ż, or of k + λ ż."""
    k, c, lam = law[0], law[1], law[2]
    if lam > 0:
        return -(k + lam * v) / (lam * spin)
    return -(k * z + c * v) / (k * s + c * spin)


@njit(cache=True, nogil=True)
def _accelerations(regime, z, v, theta, w, gx, gz, law):
    """z̈_cb and θ̈ of eq. (1); NaN where the regime's formula cannot be continued to this state."""
    k, c, lam, b, h, inertia = law[0], law[1], law[2], law[3], law[4], law[5]
    s, cos = _sincos(theta)
    if regime >= HOUSNER_RIGHT:
        if regime == HOUSNER_REST:
            return 0.0, 0.0
        side = b if regime == HOUSNER_RIGHT else -b
        return 0.0, (gx * (h * cos + side * s) - gz * (side * cos - h * s)) / (inertia + b * b)
    spin = w * cos
    if regime in (RIGHT, LEFT):
        sigma = 1.0 if regime == RIGHT else -1.0
        slope = sigma * s
        # from the sunken corner: depth d, rate e, length of contact d / slope
        d = z + b * slope
        if not slope > 0 or abs(d) > 8 * b * slope:
            return math.nan, math.nan
        e = v + b * sigma * spin
        length = d / slope
        loss = length * sigma * spin
        force = length * (0.5 * k * d + c * (e - 0.5 * loss) + lam * d * (0.5 * e - loss * (1 / 6)))
        first = (length * length) * (
            k * d * (1 / 6) + c * (0.5 * e - loss * (1 / 3)) + lam * d * (e * (1 / 6) - loss * (1 / 12))
        )
        moment = sigma * cos * (b * force - first)
    elif regime == FULL:
        second = (2 / 3) * b * b * b
        force = 2 * b * (k * z + c * v + lam * z * v) + second * lam * s * spin
        moment = cos * second * (k * s + c * spin + lam * (s * v + z * spin))
    elif regime == FLIGHT:
        force = 0.0
        moment = 0.0
    else:
        lower, upper = regime // 3, regime % 3
        u0 = -b
        if lower == 1:
            u0 = -z / s if s > 0 else math.nan
        elif lower == 2:
            u0 = _second_root(z, v, s, spin, law)
        u1 = b
        if upper == 1:
            u1 = -z / s if s < 0 else math.nan
        elif upper == 2:
            u1 = _second_root(z, v, s, spin, law)
        if not (abs(u0) < 8 * b and abs(u1) < 8 * b):
            return math.nan, math.nan
        # Simpson's rule is exact: f is quadratic and f u cubic in u
        um = 0.5 * (u0 + u1)
        z0, zm, z1 = z + s * u0, z + s * um, z + s * u1
        v0, vm, v1 = v + spin * u0, v + spin * um, v + spin * u1
        f0 = (k + lam * v0) * z0 + c * v0
        fm = 4 * ((k + lam * vm) * zm + c * vm)
        f1 = (k + lam * v1) * z1 + c * v1
        length = (u1 - u0) * (1 / 6)
        force = length * (f0 + fm + f1)
        moment = cos * length * (f0 * u0 + fm * um + f1 * u1)
    hs = h * s
    turn = (h * cos * (gx + hs * w * w) + hs * force - moment) / (inertia - hs * hs)
    return gz - force - h * cos * w * w - hs * turn, turn


@njit(cache=True, nogil=True)
def _event(i, regime, z, v, theta, w, law):
    """Event functions; the signs of the first five make up the regime of contact.

    0, 1: depth of the right and left corner; 2, 3: second factor of f there;
    4: distance between the roots of the two factors; 5: rotation of Housner's block.
    """
    if i == 5:
        return theta if regime == HOUSNER_RIGHT else -theta
    k, c, lam, b = law[0], law[1], law[2], law[3]
    s, cos = _sincos(theta)
    spin = w * cos
    if i == 4:
        return _second_root(z, v, s, spin, law) + z / s
    u = -b if i % 2 else b
    if i < 2:
        return z + u * s
    if lam > 0:
        return k + lam * (v + u * spin)
    return k * (z + u * s) + c * (v + u * spin)


@njit(cache=True, nogil=True)
def _event_count(regime, tensionless):
    if regime >= HOUSNER_RIGHT:
        return 5, 6
    return 0, 5 if tensionless else 2


@njit(cache=True, nogil=True)
def _watched(i, bits):
    """The distance between two roots counts only while both lie inside the base."""
    return i != 4 or ((bits ^ (bits >> 1)) & 5) == 5


@njit(cache=True, nogil=True)
def _signs(tensionless, z, v, theta, w, law):
    """Signs of the event functions of contact as bits."""
    bits = 0
    for i in range(5 if tensionless else 2):
        if _watched(i, bits) and _event(i, FULL, z, v, theta, w, law) > 0:
            bits |= 1 << i
    return bits


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _step(regime, h, z, v, t, w, a1, b1, coefficients, segment, tau, gx, gz, law, weights, dense):
    """One step of the 5(4) pair: new state, its accelerations, square of the error over the tolerance."""
    excited = coefficients.shape[0] > 0
    g = law[6]
    if excited:
        gx, gz = _ground(coefficients, segment, tau + h * (1 / 5))
        gz += g
    q1 = h * A21
    v2 = v + q1 * a1
    w2 = w + q1 * b1
    a2, b2 = _accelerations(regime, z + q1 * v, v2, t + q1 * w, w2, gx, gz, law)
    if excited:
        gx, gz = _ground(coefficients, segment, tau + h * (3 / 10))
        gz += g
    q1, q2 = h * A31, h * A32
    v3 = v + q1 * a1 + q2 * a2
    w3 = w + q1 * b1 + q2 * b2
    a3, b3 = _accelerations(regime, z + q1 * v + q2 * v2, v3, t + q1 * w + q2 * w2, w3, gx, gz, law)
    if excited:
        gx, gz = _ground(coefficients, segment, tau + h * (4 / 5))
        gz += g
    q1, q2, q3 = h * A41, h * A42, h * A43
    v4 = v + q1 * a1 + q2 * a2 + q3 * a3
    w4 = w + q1 * b1 + q2 * b2 + q3 * b3
    z4 = z + q1 * v + q2 * v2 + q3 * v3
    t4 = t + q1 * w + q2 * w2 + q3 * w3
    a4, b4 = _accelerations(regime, z4, v4, t4, w4, gx, gz, law)
    if excited:
        gx, gz = _ground(coefficients, segment, tau + h * (8 / 9))
        gz += g
    q1, q2, q3, q4 = h * A51, h * A52, h * A53, h * A54
    v5 = v + q1 * a1 + q2 * a2 + q3 * a3 + q4 * a4
    w5 = w + q1 * b1 + q2 * b2 + q3 * b3 + q4 * b4
    z5 = z + q1 * v + q2 * v2 + q3 * v3 + q4 * v4
    t5 = t + q1 * w + q2 * w2 + q3 * w3 + q4 * w4
    a5, b5 = _accelerations(regime, z5, v5, t5, w5, gx, gz, law)
    if excited:
        gx, gz = _ground(coefficients, segment, tau + h)
        gz += g
    q1, q2, q3, q4, q5 = h * A61, h * A62, h * A63, h * A64, h * A65
    v6 = v + q1 * a1 + q2 * a2 + q3 * a3 + q4 * a4 + q5 * a5
    w6 = w + q1 * b1 + q2 * b2 + q3 * b3 + q4 * b4 + q5 * b5
    z6 = z + q1 * v + q2 * v2 + q3 * v3 + q4 * v4 + q5 * v5
    t6 = t + q1 * w + q2 * w2 + q3 * w3 + q4 * w4 + q5 * w5
    a6, b6 = _accelerations(regime, z6, v6, t6, w6, gx, gz, law)
    q1, q3, q4, q5, q6 = h * A71, h * A73, h * A74, h * A75, h * A76
    v7 = v + q1 * a1 + q3 * a3 + q4 * a4 + q5 * a5 + q6 * a6
    w7 = w + q1 * b1 + q3 * b3 + q4 * b4 + q5 * b5 + q6 * b6
    z7 = z + q1 * v + q3 * v3 + q4 * v4 + q5 * v5 + q6 * v6
    t7 = t + q1 * w + q3 * w3 + q4 * w4 + q5 * w5 + q6 * w6
    a7, b7 = _accelerations(regime, z7, v7, t7, w7, gx, gz, law)
    ez = weights[0] * (E1 * v + E3 * v3 + E4 * v4 + E5 * v5 + E6 * v6 + E7 * v7)
    ev = weights[1] * (E1 * a1 + E3 * a3 + E4 * a4 + E5 * a5 + E6 * a6 + E7 * a7)
    et = weights[0] * weights[2] * (E1 * w + E3 * w3 + E4 * w4 + E5 * w5 + E6 * w6 + E7 * w7)
    ew = weights[1] * weights[2] * (E1 * b1 + E3 * b3 + E4 * b4 + E5 * b5 + E6 * b6 + E7 * b7)
    _dense(dense, 0, h, z, z7, v, v7, D1 * v + D3 * v3 + D4 * v4 + D5 * v5 + D6 * v6 + D7 * v7)
    _dense(dense, 1, h, v, v7, a1, a7, D1 * a1 + D3 * a3 + D4 * a4 + D5 * a5 + D6 * a6 + D7 * a7)
    _dense(dense, 2, h, t, t7, w, w7, D1 * w + D3 * w3 + D4 * w4 + D5 * w5 + D6 * w6 + D7 * w7)
    _dense(dense, 3, h, w, w7, b1, b7, D1 * b1 + D3 * b3 + D4 * b4 + D5 * b5 + D6 * b6 + D7 * b7)
    return z7, v7, t7, w7, a7, b7, h * h * (ez * ez + ev * ev + et * et + ew * ew)


@njit(cache=True, nogil=True)
def _dense(dense, i, h, y0, y1, rate0, rate1, last):
    """Coefficients of component i: y0 + x (Δ + (1 - x) (d2 + x (d3 + (1 - x) d4)))."""
    change = y1 - y0
    d2 = h * rate0 - change
    dense[i, 0] = y0
    dense[i, 1] = change
    dense[i, 2] = d2
    dense[i, 3] = change - h * rate1 - d2
    dense[i, 4] = h * last


@njit(cache=True, nogil=True)
def _at(dense, i, x):
    """Dense output of component i at the fraction x of the step."""
    r = 1 - x
    return dense[i, 0] + x * (dense[i, 1] + r * (dense[i, 2] + x * (dense[i, 3] + r * dense[i, 4])))


@njit(cache=True, nogil=True)
def _event_at(i, regime, dense, x, law):
    return _event(i, regime, _at(dense, 0, x), _at(dense, 1, x), _at(dense, 2, x), _at(dense, 3, x), law)


@njit(cache=True, nogil=True)
def _crossing(i, regime, positive, dense, right, law):
    """First fraction x <= right of the step at which event function i leaves its sign, or 0."""
    sign = 1.0 if positive else -1.0
    f_right = sign * _event_at(i, regime, dense, right, law)
    left = 0.0
    f_left = sign * _event_at(i, regime, dense, 0.0, law)
    if not f_left > 0:
        # just after an event the residual may have either sign: look for the excursion
        left = 0.5 * right
        f_left = sign * _event_at(i, regime, dense, left, law)
        while not f_left > 0:
            left *= 0.5
            if left < 1e-9:
                return 0.0
            f_left = sign * _event_at(i, regime, dense, left, law)
    kept = 0
    for n in range(60):
        # Illinois with a bisection now and then
        x = (left * f_right - right * f_left) / (f_right - f_left) if n % 4 != 3 else 0.5 * (left + right)
        f = sign * _event_at(i, regime, dense, x, law)
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


@njit(cache=True, nogil=True)
def integrate(
    law,
    housner,
    tensionless,
    restitution,
    z,
    v,
    theta,
    w,
    time,
    breaks,
    coefficients,
    tolerance,
    max_steps,
    out,
    rates,
    record,
):
    """Integrate from t = 0 and sample at `time`.

    Parameters
    ----------
    law : tuple of 7 floats
        k/m, c/m, λ/m, b, h, (I_cm + m h²)/m, g.
    housner, tensionless : bool
        The block of Housner instead of a contact law; the rule of debonding.
    restitution : float
        r of Housner's impacts.
    z, v, theta, w : float
        State at t = 0.
    time : ndarray, shape (n_time,)
        Increasing; negative times get the initial state.
    breaks : ndarray, shape (n_segments + 1,); coefficients : ndarray, shape (n_segments, 14)
        Ground motion, as in `_ground`; no segments for free rocking.
    tolerance : float
        Error allowed in θ per step [rad]; the other components are scaled by b and p.
    max_steps : int
        Steps after which to give up.
    out : ndarray, shape (n_time,)
        Receives θ.
    rates : ndarray, shape (n_time, 3)
        Receives z_cb, ż_cb, θ̇ if `record`.
    record : bool
        Whether to fill `rates` and note the impacts.

    Returns
    -------
    outcome, accepted, rejected, evaluations : int
    impacts : ndarray
        Instants at which θ changes its sign [s], if `record`.
    """
    k, c, lam, b, h_half, inertia, g = law
    p = math.sqrt(g * b / ((inertia + b * b) * math.sin(math.atan2(b, h_half))))
    theta_cr = math.atan2(b, h_half)
    weights = (1 / (tolerance * b), 1 / (tolerance * b * p), b)
    dense = np.zeros((4, 5))
    impacts = np.empty(256 if record else 0)
    n_impacts = 0
    n_time = time.size
    n = 0
    while n < n_time and time[n] <= 0:
        out[n] = theta
        if record:
            rates[n, 0], rates[n, 1], rates[n, 2] = z, v, w
        n += 1
    n_segments = coefficients.shape[0]
    segment = -1
    while segment < n_segments and n_segments > 0 and breaks[segment + 1] <= 0:
        segment += 1
    if n_segments == 0:
        segment = 0
    last_sign = 1.0 if theta > 0 else -1.0
    t = 0.0
    h = 0.02 / p
    steps = rejected = evaluations = 0
    if housner:
        regime = HOUSNER_RIGHT if theta > 0 or (theta == 0 and w > 0) else HOUSNER_LEFT
        bits = 1 << 5
    else:
        bits = _signs(tensionless, z, v, theta, w, law)
        regime = _regime(bits, tensionless)
    first_event, end_event = _event_count(regime, tensionless)
    fresh = True
    a = turn = gx = 0.0
    gz = g
    stiffness = 2 * k * b**3 / 3 - g * h_half
    dissipative = c > 0 or lam > 0
    while n < n_time:
        if steps + rejected >= max_steps:
            out[n:] = math.nan
            return STEP_LIMIT, steps, rejected, evaluations, impacts[:n_impacts]
        to_break = math.inf
        if segment < n_segments:
            to_break = breaks[segment + 1] - t
        clipped = h >= to_break
        size = to_break if clipped else h
        if fresh:
            if n_segments > 0:
                gx, gz = _ground(coefficients, segment, t - breaks[max(segment, 0)])
                gz += g
            a, turn = _accelerations(regime, z, v, theta, w, gx, gz, law)
            evaluations += 1
            fresh = False
        tau = t - breaks[max(segment, 0)] if n_segments > 0 else 0.0
        z1, v1, theta1, w1, a1, turn1, error = _step(
            regime, size, z, v, theta, w, a, turn, coefficients, segment, tau, gx, gz, law, weights, dense
        )
        evaluations += 6
        if not error <= 1:
            rejected += 1
            factor = 0.25
            if error > 1 and error < 1e30:
                factor = max(0.2, 0.9 * error**-0.1)
            h = size * factor
            if h < 1e-15 / p:
                out[n:] = math.nan
                return NON_FINITE, steps, rejected, evaluations, impacts[:n_impacts]
            continue
        factor = min(5.0, 0.9 * max(error, 1e-30) ** -0.1)
        grown = size * factor
        # events
        first = 2.0
        which = -1
        for i in range(first_event, end_event):
            if not _watched(i, bits):
                continue
            positive = (bits >> i) & 1 == 1
            upper = 0.0
            if (_event(i, regime, z1, v1, theta1, w1, law) > 0) != positive:
                upper = 1.0
            else:
                upper = _excursion(i, regime, positive, dense, v, theta, w, v1, theta1, w1, law)
            if upper > 0:
                x = _crossing(i, regime, positive, dense, upper, law)
                if x < first:
                    first = x
                    which = i
        if which >= 0:
            clipped = False
            if first * size > 1e-14 / p:
                size *= first
                for _ in range(3):
                    z1, v1, theta1, w1, a1, turn1, error = _step(
                        regime,
                        size,
                        z,
                        v,
                        theta,
                        w,
                        a,
                        turn,
                        coefficients,
                        segment,
                        tau,
                        gx,
                        gz,
                        law,
                        weights,
                        dense,
                    )
                    evaluations += 6
                    if which in (0, 1):
                        s, cos = _sincos(theta1)
                        u = -b if which == 1 else b
                        value = z1 + u * s
                        slope = v1 + u * w1 * cos
                    elif which == 5:
                        value, slope = theta1, w1
                    else:
                        break
                    correction = -value / slope if slope != 0 else 0.0
                    if abs(correction) <= 1e-12 * size or abs(correction) > 0.1 * size:
                        break
                    size += correction
            else:
                size = 0.0
                z1, v1, theta1, w1 = z, v, theta, w
        # samples
        end = t + size
        if size > 0:
            while n < n_time and time[n] <= end:
                x = (time[n] - t) / size
                out[n] = _at(dense, 2, x)
                if record:
                    rates[n, 0], rates[n, 1], rates[n, 2] = (
                        _at(dense, 0, x),
                        _at(dense, 1, x),
                        _at(dense, 3, x),
                    )
                n += 1
        if record and theta1 * last_sign < 0:
            if n_impacts == impacts.size:
                longer = np.empty(2 * n_impacts)
                longer[:n_impacts] = impacts
                impacts = longer
            x = 1.0
            if theta * theta1 < 0:
                left, x = 0.0, 1.0
                for _ in range(54):
                    middle = 0.5 * (left + x)
                    if _at(dense, 2, middle) * last_sign > 0:
                        left = middle
                    else:
                        x = middle
            impacts[n_impacts] = t + x * size
            n_impacts += 1
            last_sign = -last_sign
        steps += 1
        t = end
        z, v, theta, w, a, turn = z1, v1, theta1, w1, a1, turn1
        h = max(grown, size)
        if which >= 0:
            fresh = True
            bits ^= 1 << which
            if tensionless and which != 4 and _watched(4, bits):
                bits &= 15
                if _event(4, regime, z, v, theta, w, law) > 0:
                    bits |= 16
            regime = _regime(bits, tensionless)
        if clipped:
            t = breaks[segment + 1]
            segment += 1
            fresh = True
            h = grown
        if abs(theta) > theta_cr and theta * w >= 0 and segment >= n_segments:
            out[n:] = math.nan
            return OVERTURNED, steps, rejected, evaluations, impacts[:n_impacts]
        if regime == FULL and dissipative and stiffness > 0 and segment >= n_segments:
            s, cos = _sincos(theta)
            deep = z - g / (2 * b * k)
            energy = (
                k * b * deep * deep
                + 0.5 * stiffness * s * s
                + 0.5 * v * v
                + h_half * s * v * w
                + 0.5 * inertia * w * w
            )
            if energy < 0.5 * stiffness * (0.03 * tolerance) ** 2:
                out[n:] = 0.0
                return AT_REST, steps, rejected, evaluations, impacts[:n_impacts]
    return COMPLETED, steps, rejected, evaluations, impacts[:n_impacts]


@njit(cache=True, nogil=True)
def _excursion(i, regime, positive, dense, v, theta, w, v1, theta1, w1, law):
    """Fraction of the step at which event function i has left its sign although both ends have it, else 0."""
    if i >= 2 and i < 5:
        for x in (0.25, 0.5, 0.75):
            if (_event_at(i, regime, dense, x, law) > 0) != positive:
                return x
        return 0.0
    if i == 5:
        slope0, slope1 = (w, w1) if regime == HOUSNER_RIGHT else (-w, -w1)
    else:
        u = -law[3] if i == 1 else law[3]
        slope0 = v + u * w * _sincos(theta)[1]
        slope1 = v1 + u * w1 * _sincos(theta1)[1]
    if not positive:
        slope0, slope1 = -slope0, -slope1
    if slope0 < 0 and slope1 > 0:
        x = slope0 / (slope0 - slope1)
        if (_event_at(i, regime, dense, x, law) > 0) != positive:
            return x
    return 0.0
