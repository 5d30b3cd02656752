"""Rocking on a bed that relaxes, a standard linear solid of one relaxation time: an integrator of its own.

Per unit width the bed presses by k z + q where it touches the base, and remembers q:

    q̇ = (c/τ) ż - q/τ in contact,    q̇ = -q/τ out of it,

a spring k beside a spring c/τ in series with a dashpot c, the three-parameter solid (Flügge 1975, chapter 1,
doi:10.1007/978-3-662-02276-4). The bed recovers where the block has left it. k z is the `kernel`'s,
exactly.

The rate of z(u) is linear in u, so in contact q = Z + u S + D with Ḋ = -D/τ and

    Ż = (c/τ) ż_cb - Z/τ,    Ṡ = (c/τ) (sinθ)˙ - S/τ.

Of D the motion needs the integrals I and J of D and u D over the contact. They relax, too, and change where
the end x of the contact moves:

    İ = -I/τ + D(x) L̇,    J̇ = -J/τ + x D(x) L̇,    L the length of the contact.

Where the contact grows D(x) is q - Z - x S, with q as it was left there; where it shrinks D is what it was.
Both are known at the nodes of some cells of the base, as of when the end of the contact passed them, and lie
on straight lines between. The end of the contact at a node, its turning back, and another corner to turn
about are located on the dense output; the step ends there.
"""

import math

import numpy as np

from freerock.arrays import Floats
from freerock.models import kernel
from freerock.models.compiled import compiled
from freerock.models.kernel import (
    AT_REST,
    COMPLETED,
    FLIGHT,
    FULL,
    LEFT,
    NON_FINITE,
    OVERTURNED,
    RIGHT,
    STEP_LIMIT,
    _accelerations,
    _begun,
    _com,
    _dense,
    _exp2,
    _fill,
    _ground,
    _inertia,
    _is_over,
    _is_steady,
    _log2,
    _regime,
    _sample,
    _sign_change,
    _signs,
    _sincos,
    _state_at,
)

CELLS = 512
# states are z_cb, ż_cb, θ, θ̇, Z, S, I, J
CORNER, TURN = -2, -3  # events: another corner to turn about, the end of the contact turns back; else a node
NOTHING = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def nodes(half_width_m: float, cells: int = CELLS) -> Floats:
    """Places of the nodes from the middle of the base [m], shape (cells + 1,), denser towards its corners."""
    at = -half_width_m * np.cos(np.pi * np.arange(cells + 1) / cells)
    return np.asarray(0.5 * (at - at[::-1]))


@compiled(forceinline=True)
def _edge(y, s, cos, decay, cell):
    """Place of the end of a partial contact, D there, and the rate at which the contact grows.

    `cell` has whether it grows, a place and, there and by length, what is known: q out of contact where it
    grows, else D in contact. `decay` is what relaxing has left of it.
    """
    grows, place, known, slope = cell
    x = -y[0] / s
    d = decay * (known + slope * (x - place))
    if grows:
        d -= y[4] + x * y[5]
    return x, d, (y[1] + x * y[3] * cos) / abs(s)


@compiled(forceinline=True)
def _remembered(regime, y, s, b):
    """Force and moment / cosθ of q per unit mass."""
    if regime == FLIGHT:
        return 0.0, 0.0
    low, high = -b, b
    if regime == RIGHT:
        low = -y[0] / s
    elif regime == LEFT:
        high = -y[0] / s
    n_1, n_2 = 0.5 * (high * high - low * low), (1 / 3) * (high * high * high - low * low * low)
    return y[4] * (high - low) + y[5] * n_1 + y[6], y[4] * n_1 + y[5] * n_2 + y[7]


@compiled(forceinline=True)
def _rates(regime, y, x_ground, gravity, law, bed, decay, cell):
    """Rates of the states; `bed` is c/(τ m) and 1/τ."""
    s, cos = _sincos(y[2])
    a, turn = _accelerations(regime, y[0], y[1], y[2], y[3], x_ground, gravity, law)
    force, moment = _remembered(regime, y, s, law[3])
    _, _, reduced = _inertia(s, cos, law)
    hs, _ = _com(s, cos, law)
    more = (hs * force - cos * moment) / reduced
    of_level, of_slope = bed[0] * y[1] - bed[1] * y[4], bed[0] * y[3] * cos - bed[1] * y[5]
    of_total, of_moment = -bed[1] * y[6], -bed[1] * y[7]
    if regime in (RIGHT, LEFT):
        x, d, growth = _edge(y, s, cos, decay, cell)
        of_total += d * growth
        of_moment += x * d * growth
    return y[1], a - force - hs * more, y[3], turn + more, of_level, of_slope, of_total, of_moment


@compiled(forceinline=True)
def _plus(y, h, f):
    """y + h f."""
    return (
        y[0] + h * f[0],
        y[1] + h * f[1],
        y[2] + h * f[2],
        y[3] + h * f[3],
        y[4] + h * f[4],
        y[5] + h * f[5],
        y[6] + h * f[6],
        y[7] + h * f[7],
    )


@compiled()
def _stage(regime, h, y, ground, law, bed, cell):
    """Rates of the states so long after the beginning of a step [s]."""
    coefficients, segment, tau = ground
    x, gravity = _ground(coefficients, segment, tau + h, law[6])
    return _rates(regime, y, x, gravity, law, bed, math.exp(-h * bed[1]), cell)


@compiled()
def _step(regime, h, y, f1, ground, law, bed, cell, weights, dense):
    """One step of the 5(4) pair of the `kernel`: the state after it, its rates, and the square of the error
    over the tolerance; fills the dense output of z_cb, ż_cb, θ, θ̇."""
    on = ground, law, bed, cell
    f2 = _stage(regime, h * (1 / 5), _plus(y, h * kernel.A21, f1), *on)
    f3 = _stage(regime, h * (3 / 10), _plus(_plus(y, h * kernel.A31, f1), h * kernel.A32, f2), *on)
    y4 = _plus(_plus(_plus(y, h * kernel.A41, f1), h * kernel.A42, f2), h * kernel.A43, f3)
    f4 = _stage(regime, h * (4 / 5), y4, *on)
    y5 = _plus(
        _plus(_plus(_plus(y, h * kernel.A51, f1), h * kernel.A52, f2), h * kernel.A53, f3), h * kernel.A54, f4
    )
    f5 = _stage(regime, h * (8 / 9), y5, *on)
    y6 = _plus(_plus(_plus(y, h * kernel.A61, f1), h * kernel.A62, f2), h * kernel.A63, f3)
    f6 = _stage(regime, h, _plus(_plus(y6, h * kernel.A64, f4), h * kernel.A65, f5), *on)
    y7 = _plus(_plus(_plus(y, h * kernel.A71, f1), h * kernel.A73, f3), h * kernel.A74, f4)
    y7 = _plus(_plus(y7, h * kernel.A75, f5), h * kernel.A76, f6)
    f7 = _stage(regime, h, y7, *on)
    off = _plus(_plus(_plus(NOTHING, kernel.E1, f1), kernel.E3, f3), kernel.E4, f4)
    off = _plus(_plus(_plus(off, kernel.E5, f5), kernel.E6, f6), kernel.E7, f7)
    last = _plus(_plus(_plus(NOTHING, kernel.D1, f1), kernel.D3, f3), kernel.D4, f4)
    last = _plus(_plus(_plus(last, kernel.D5, f5), kernel.D6, f6), kernel.D7, f7)
    error = 0.0
    for n in range(8):
        error += (h * weights[n] * off[n]) ** 2
    for n in range(4):
        _dense(dense, n, h, y[n], y7[n], f1[n], f7[n], last[n])
    return y7, f7, error


@compiled()
def _beyond(regime, near):
    """The node out of contact beside the last one in contact."""
    return near - 1 if regime == RIGHT else near + 1


@compiled()
def _cell(regime, near, grows, fading, inside, outside, places):
    """The cell in which a partial contact ends, as `_edge` takes it."""
    if regime not in (RIGHT, LEFT):
        return False, 0.0, 0.0, 0.0
    beyond = _beyond(regime, near)
    known = outside if grows else inside
    slope = (known[near] - known[beyond]) / (places[near] - places[beyond])
    return grows, places[near], fading * known[near], fading * slope


@compiled()
def _turned(regime, near, y, fading, cell, inside, outside, places):
    """The cell after the end of the contact turned back: from a node to there, as it is now."""
    s, cos = _sincos(y[2])
    x, at_end, _ = _edge(y, s, cos, 1.0, cell)
    node = near if cell[0] else _beyond(regime, near)
    known = fading * (inside[node] if cell[0] else outside[node])
    if not cell[0]:
        at_end += y[4] + x * y[5]
    way = x - places[node]
    return not cell[0], places[node], known, (at_end - known) / way if way != 0 else 0.0


@compiled()
def _watched(regime, near, last):
    """The two nodes at which contact may change next."""
    if regime in (RIGHT, LEFT):
        return near, _beyond(regime, near)
    return 0, last


@compiled()
def _touches(regime, near, node):
    """Whether a node is in contact."""
    return regime == FULL or (regime == RIGHT and node >= near) or (regime == LEFT and node <= near)


@compiled()
def _contact_after(regime, near, node, last, upright):
    """Regime, and last node in contact, after a node is met or left; upright, all are together."""
    if upright:
        return (FLIGHT if regime == FULL else FULL), 0
    if regime == FULL:
        return (RIGHT, 1) if node == 0 else (LEFT, last - 1)
    if regime == FLIGHT:
        return (LEFT, 0) if node == 0 else (RIGHT, last)
    inward = 1 if regime == RIGHT else -1
    if node != near:
        return (FULL, 0) if node in (0, last) else (regime, node)
    return (FLIGHT, 0) if node in (0, last) else (regime, node + inward)


@compiled()
def _reached_in(sign, u, y, rates):
    """Time until sign × the depth of a place falls to zero, by two terms of its series."""
    s, cos = _sincos(y[2])
    depth = sign * (y[0] + u * s)
    rate = sign * (y[1] + u * y[3] * cos)
    half = 0.5 * sign * (rates[1] + u * (rates[3] * cos - y[3] * y[3] * s))
    square = rate * rate - 4 * depth * half
    if square < 0:
        return math.inf
    if rate <= 0:
        return max(2 * depth / (math.sqrt(square) - rate), 0.0) if square > 0 else math.inf
    return -(rate + math.sqrt(square)) / (2 * half) if half < 0 else math.inf


@compiled()
def _held(event, state, regime, near, grows, sign, places):
    """What is positive until an event: of a node its depth or height [m]; θ; the rate at the end of the
    contact [m/s]."""
    z, v, theta, w = state
    if event == CORNER:
        return sign * theta
    s, cos = _sincos(theta)
    if event == TURN:
        rate = v - z / s * w * cos
        return rate if grows else -rate
    depth = z + places[event] * s
    return depth if _touches(regime, near, event) else -depth


@compiled()
def _rate_of(event, state, regime, near, sign, places):
    """Rate of `_held`, of a node or a corner."""
    _, v, theta, w = state
    if event == CORNER:
        return sign * w
    rate = v + places[event] * w * _sincos(theta)[1]
    return rate if _touches(regime, near, event) else -rate


@compiled()
def _first_event(regime, near, grows, last, pivots, sign, dense, places, slack):
    """Fraction of the step at which its first event happens, and which; (2, -1) without one."""
    first, which = 2.0, -1
    one, other = _watched(regime, near, last)
    for part in (0.5, 1.0):
        at = _state_at(dense, part)
        for i in range(4):
            event = one if i == 0 else other if i == 1 else TURN if i == 2 else CORNER
            allowed = slack[max(i - 1, 0)]
            if (event == CORNER and not pivots) or (event == TURN and regime not in (RIGHT, LEFT)):
                continue
            if _held(event, at, regime, near, grows, sign, places) >= -allowed:
                continue
            left, right = part - 0.5, part
            for _ in range(40):
                middle = 0.5 * (left + right)
                if _held(event, _state_at(dense, middle), regime, near, grows, sign, places) > 0:
                    left = middle
                else:
                    right = middle
            if right < first:
                first, which = right, event
        if which != -1:
            break
    return first, which


@compiled()
def _integral(values, places):
    """Integrals of what is known at the nodes, and of it times u, over the base."""
    total = moment = 0.0
    for i in range(places.size - 1):
        u0, u1, d0, d1 = places[i], places[i + 1], values[i], values[i + 1]
        total += 0.5 * (u1 - u0) * (d0 + d1)
        moment += (1 / 6) * (u1 - u0) * (u0 * (2 * d0 + d1) + u1 * (d0 + 2 * d1))
    return total, moment


@compiled()
def _stored(y, inside, places, fast):
    """Energy per unit mass that the memory of a bed in whole contact holds."""
    total = 0.0
    for i in range(places.size - 1):
        q0 = inside[i] + y[4] + places[i] * y[5]
        q1 = inside[i + 1] + y[4] + places[i + 1] * y[5]
        total += (1 / 3) * (places[i + 1] - places[i]) * (q0 * q0 + q0 * q1 + q1 * q1)
    return 0.5 * total / fast if fast > 0 else 0.0


@compiled()
def _integrate(law, element, start, time, breaks, coefficients, tolerance, max_steps, out, rates, places):
    k, _, _, b, h, inertia, g, corner, _, e, _ = law
    c, relaxes_s = element
    bed = c / relaxes_s, 1 / relaxes_s
    law = (k, 0.0, 0.0, b, h, inertia, g, corner, 0.0, e, 0.0)
    p = math.sqrt(g * math.sqrt(b * b + h * h) / (inertia + b * b))
    theta_cr = math.atan2(b + abs(e), h)
    by_depth, by_angle, by_level = 1 / (tolerance * b), 1 / tolerance, 1 / (tolerance * b * (k + bed[0]))
    by_force = by_level / (2 * b)
    of_base = by_depth, by_depth / p, by_angle, by_angle / p
    weights = (*of_base, by_level, b * by_level, by_force, by_force / b)
    exact = 0.01 * tolerance
    slack = 2 * exact * b, 2 * exact * b * p, 2 * exact
    kick, least = 2 * corner * h / inertia, 0.01 * tolerance * p
    flat, turning = 0.5 * g / (b * k), (2 / 3) * k * b * b * b - g * h
    # the energy below which it is at rest; explicit steps ring up and down with less
    rest = 0.5 * turning * tolerance**2 if c > 0 else -1.0
    last = places.size - 1
    # D of nodes in contact, q of others; beside the end of the contact also what they were before
    inside, outside = np.zeros(last + 1), np.zeros(last + 1)
    dense = np.zeros((4, 5))
    y = start[0], start[1], start[2], start[3], 0.0, 0.0, 0.0, 0.0
    f = y1 = f1 = y
    record = rates.size > 0
    impacts = np.empty(0)
    n_time, n_segments = time.size, coefficients.shape[0]
    steps = rejected = evaluations = 0
    n, segment = _begun(y, time, breaks, out, rates)
    sign = 1.0 if y[2] > 0 or (y[2] == 0 and y[3] > 0) else -1.0
    law = (k, 0.0, 0.0, b, h, inertia, g, sign * corner, 0.0, e, 0.0)
    regime = _regime(_signs(False, y[:4], law), False)
    near = 0 if regime == LEFT else last
    if regime in (RIGHT, LEFT):
        inward = -1 if regime == RIGHT else 1
        while y[0] + places[near + inward] * math.sin(y[2]) > 0:
            near += inward
    fading = 1.0  # what is left of that
    cell = _cell(regime, near, True, fading, inside, outside, places)
    t, size, log_before = 0.0, 0.01 / p, 0.0
    fresh, outcome = True, COMPLETED

    while n < n_time:
        if steps + rejected >= max_steps:
            outcome = STEP_LIMIT
            break
        t_segment = breaks[segment] if 0 <= segment < n_segments else 0.0
        left_in_segment = breaks[segment + 1] - t if segment < n_segments else math.inf
        if fresh:
            x, gravity = _ground(coefficients, segment, t - t_segment, g)
            f = _rates(regime, y, x, gravity, law, bed, 1.0, cell)
            evaluations += 1
            fresh = False
        whole = size >= left_in_segment
        step = left_in_segment if whole else size
        aimed = -1
        one, other = _watched(regime, near, last)
        for node in (one, other):
            towards = 1.0 if _touches(regime, near, node) else -1.0
            until = _reached_in(towards, places[node], y, f)
            if until < step and until * p > 1e-15:
                step, aimed, whole = until, node, False
        which = -1
        accepted = False
        for attempt in range(6):
            ground = coefficients, segment, t - t_segment
            y1, f1, error = _step(regime, step, y, f, ground, law, bed, cell, weights, dense)
            evaluations += 6
            if attempt == 0:
                accepted = error <= 1
                if not accepted:
                    break
                log_error = _log2(max(error, 1e-12))
                growth = min(5.0, 0.9 * _exp2(0.02 * log_before - 0.06 * log_error))
                size = max(step * growth, size if whole or aimed >= 0 else 0.0)
                log_before = log_error
                pivots = kick * step * max(y[3] * y[3], y1[3] * y1[3]) > least
                first, which = _first_event(regime, near, cell[0], last, pivots, sign, dense, places, slack)
                if which == -1 and aimed >= 0:
                    first, which = 1.0, aimed
                if which == -1:
                    break
                if first < 1 and which != aimed:
                    whole = False
                    step *= first
                    if step * p < 1e-15:
                        step = 0.0
                        break
                    continue
            elif not error <= 1:
                accepted = False
                break
            if which == TURN:
                break
            residual = _held(which, y1[:4], regime, near, cell[0], sign, places)
            if abs(residual) <= exact * (1.0 if which == CORNER else b):
                break
            if first == 1.0:  # what was aimed at is not reached yet
                which = -1
                break
            correction = -residual / _rate_of(which, y1[:4], regime, near, sign, places)
            if abs(correction) < 0.1 * step:
                step += correction
            elif attempt == 0:
                step *= first
            else:
                break
        if not accepted:
            rejected += 1
            size = step * (max(0.2, 0.9 * error**-0.1) if error < 1e20 else 0.2)
            if size * p < 1e-15:
                outcome = NON_FINITE
                break
            continue
        end = breaks[segment + 1] if whole else t + step
        turned, before = which == CORNER, y
        if step > 0:
            n = _sample(dense, t, step, end, time, n, out, rates)
            turned = turned or sign * y1[2] < 0
            relaxed = math.exp(-step * bed[1])
            fading *= relaxed
            cell = cell[0], cell[1], relaxed * cell[2], relaxed * cell[3]
            if fading < 1e-100:
                inside *= fading
                outside *= fading
                fading = 1.0
            y, f = y1, f1
        if turned:
            # a block upright at rest has no side to leave
            if record and (before[2] != 0 or before[3] != 0):
                crossed = end if which == CORNER else t + step * _sign_change(dense, sign)
                impacts = np.append(impacts, crossed)
            sign = -sign
            law = (k, 0.0, 0.0, b, h, inertia, g, sign * corner, 0.0, e, 0.0)
        if which == CORNER:
            y = y[0], y[1], 0.0, y[3], y[4], y[5], y[6], y[7]
        elif which == TURN:
            cell = _turned(regime, near, y, fading, cell, inside, outside, places)
        elif which >= 0:
            upright = y[2] == 0 and y[3] == 0
            for i in range(last + 1):
                if (i == which or upright) and _touches(regime, near, i):
                    outside[i] = inside[i] + (y[4] + places[i] * y[5]) / fading
                elif i == which or upright:
                    inside[i] = outside[i] - (y[4] + places[i] * y[5]) / fading
            grows = regime != FULL and (cell[0] or regime == FLIGHT)
            regime, near = _contact_after(regime, near, which, last, upright)
            if regime == FLIGHT:
                y = y[0], y[1], y[2], y[3], y[4], y[5], 0.0, 0.0
            elif regime == FULL and upright:
                total, moment = _integral(fading * inside, places)
                y = y[0], y[1], y[2], y[3], y[4], y[5], total, moment
            cell = _cell(regime, near, grows, fading, inside, outside, places)
        steps += 1
        t = end
        fresh = whole or which != -1 or (turned and corner > 0)
        if whole:
            segment += 1
        if _is_over(y, theta_cr, segment < n_segments):
            outcome = OVERTURNED
            break
        lasts = segment >= n_segments or breaks[segment + 1] >= time[n_time - 1]
        if regime == FULL and turning > 0 and lasts and _is_steady(coefficients, segment):
            energy = 0.5 * y[1] * y[1] + 0.5 * inertia * y[3] * y[3] + h * _sincos(y[2])[0] * y[1] * y[3]
            if energy < rest:
                # as in the kernel: what bed and weight store, seen from where they balance
                x, gravity = _ground(coefficients, segment, 0.0, g)
                rise, turn = _accelerations(regime, y[0], 0.0, y[2], 0.0, x, gravity, law)
                energy += 0.25 * rise * rise / (k * b) + 0.5 * (inertia * turn) ** 2 / turning
            if energy < rest and energy + _stored(y, fading * inside, places, bed[0]) < rest:
                if e == 0 and segment >= n_segments:
                    y = flat, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                outcome = AT_REST
                break
    if outcome == AT_REST:
        _fill(n, y[2], y[0], 0.0, out, rates)
    else:
        _fill(n, math.nan, math.nan, math.nan, out, rates)
    return outcome, steps, rejected, evaluations, impacts


def integrate_viscoelastic(
    law: tuple[float, ...],
    element: tuple[float, float],
    y: tuple[float, float, float, float],
    time: Floats,
    breaks: Floats,
    coefficients: Floats,
    tolerance: float,
    max_steps: int,
    out: Floats,
    rates: Floats,
    cells: int = CELLS,
) -> tuple[int, int, int, int, int, Floats]:
    """As `kernel.integrate`, of a bed that has not moved for long before t = 0.

    Parameters
    ----------
    law : tuple of 11 floats
        As there, of sharp edges; no damping of it is used.
    element : (float, float)
        c/m [N s/(m² kg)] and the relaxation time τ [s].
    y : tuple of 4 floats
        z_cb, ż_cb, θ, θ̇ at t = 0 [SI].
    time, breaks, coefficients, tolerance, max_steps, out, rates
        As there.
    cells : int
        Cells of the base. Over 4 s, 512 of them left θ of a 28 cm block within 1e-5 θ₀ of the bed without
        cells for τ = 10 ms, and within 2e-4 θ₀ up to τ = 0.3 s.
    """
    places, accuracy = nodes(law[3], cells), (tolerance, max_steps)
    outcome, steps, rejected, evaluations, impacts = _integrate(
        law, element, y, time, breaks, coefficients, *accuracy, out, rates, places
    )
    return outcome, steps, rejected, 0, evaluations, impacts
