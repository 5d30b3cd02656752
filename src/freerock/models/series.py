"""Free rocking by Taylor series in time: sharp edges, geometric debonding, a level or leaning base.

With the depth Z = z_cb - h cosθ of the centre of mass, its place sideways x = h sinθ - a cosθ, and s = sinθ,
equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) divided by the mass reads

    Z̈ = g - F,    J θ̈ = s (h F - a X) - cosθ (M + h X),    X = ẍ - ẍ_g,    J = I_cm/m,

with the force F and the moment M cosθ of the foundation about the base centre; a is 0 of a guided block, and
of one that pivots b while θ > 0, -b while θ < 0. On a base that leans by τ (`ground.tilted`) ẍ_g is
g sinτ, and g cosτ stands for g; else ẍ_g is 0. While one corner is down, of depth D, on a length L = D/s,
and with A = D L,

    F = k/2 A + c/2 Ȧ + λ/6 (D A)˙,    M = b F - k/6 A L - c/6 (A L)˙ - λ/24 (A²)˙;

while the whole base is,

    F = 2b (k z_cb + c ż_cb) + b λ (z_cb²)˙ + λ b³/3 (s²)˙,    M = 2b³/3 (k s + c ṡ + λ (z_cb s)˙),

and none in the air. So the coefficients of the motion follow order by order from sums of products, without an
evaluation of the law at further instants, and so does the length of the step (Jorba and Zou 2005,
doi:10.1080/10586458.2005.10128904). A step ends where a corner leaves or meets the ground, or where another
corner is turned about: a root of the series itself.

`series_sums` holds the recurrences, written out order by order: as loops they take several times as long.
"""

import math

import numpy as np

from freerock.arrays import Floats
from freerock.models import kernel
from freerock.models.compiled import compiled
from freerock.models.kernel import AT_REST, COMPLETED, NON_FINITE, OVERTURNED, STEP_LIMIT, sincos
from freerock.models.series_sums import FAST, ORDER, both_at, fill_theta, in_air, on_corner, on_whole_base

STIFF = NON_FINITE + 1
STABLE = 3.0  # times one over the fastest rate of the contact: steps as long are held by stability
PATIENCE = 300  # such steps more than shorter ones, after which the law is stiff
SHARPER = 0.05  # of the tolerance, as a rate: what the last terms of a step may be
ONE = np.float64(1.0).view(np.int64)  # its bits


@compiled(fastmath=FAST)
def _corner_at(z, t, x, side, law):
    """Depth of the corner on a side at the time x into a step, and its rate."""
    b, h = law[3], law[4]
    depth, v, theta, w = both_at(z, t, x)
    s, cos = sincos(theta)
    return depth + h * cos + side * b * s, v - (h * s - side * b * cos) * w


@compiled(fastmath=FAST)
def _crossing(z, t, step, side, inside, rate0, depth1, rate1, within, law):
    """Time into a step at which a corner leaves its side of the ground, or infinity.

    `inside`: whether it was in the ground when the step began; its rate then, depth and rate at the end.
    """
    low, high, depth, rate = 0.0, step, depth1, rate1
    if (depth > 0) == inside:
        # there and back within the step: it would be between the two, where the rate is zero
        if not ((rate0 < 0) == inside and rate0 * rate1 < 0):
            return math.inf
        high = step * rate0 / (rate0 - rate1)
        depth, rate = _corner_at(z, t, high, side, law)
        if (depth > 0) == inside:
            return math.inf
    x = high
    for _ in range(60):
        # Newton's step, or a bisection where it leaves the bracket
        better = x - depth / rate
        x = better if low < better < high else 0.5 * (low + high)
        depth, rate = _corner_at(z, t, x, side, law)
        if abs(depth) < within or high - low < 1e-15 * step:
            break
        if (depth > 0) == inside:
            low = x
        else:
            high = x
    return x


@compiled(fastmath=FAST)
def _passage(z, t, step):
    """Time into a step at which θ changes its sign."""
    low, high, x = 0.0, step, 0.5 * step
    positive = t[0] > 0 or (t[0] == 0 and t[1] > 0)
    for _ in range(60):
        _, _, angle, rate = both_at(z, t, x)
        if (angle > 0) == positive:
            low = x
        else:
            high = x
        better = x - angle / rate
        if abs(better - x) < 1e-15 * step or high - low < 1e-15 * step:
            break
        x = better if low < better < high else 0.5 * (low + high)
    return x


@compiled(fastmath=FAST)
def _fill_rates(z, t, sign, start, time, h, rates):
    """z_cb, ż_cb and θ̇ at the samples of a step."""
    for i in range(time.size):
        depth, v, theta, w = both_at(z, t, time[i] - start)
        s, cos = sincos(theta)
        rates[i, 0], rates[i, 1], rates[i, 2] = depth + h * cos, v - h * s * w, sign * w


@compiled(forceinline=True)
def _root(x, n):
    """n-th root, up to 6.2 % too large: by the bits of the number, which are about its logarithm."""
    return np.int64(ONE + (np.float64(x).view(np.int64) - ONE) // n).view(np.float64)


@compiled(fastmath=FAST, forceinline=True)
def _length_of_step(z, t, by_width, allowed):
    """Step after which the last two terms of the rates of both series are within what is allowed, about."""
    last = ORDER * max(abs(t[ORDER]), abs(z[ORDER]) * by_width) + 1e-300
    before = (ORDER - 1) * max(abs(t[ORDER - 1]), abs(z[ORDER - 1]) * by_width) + 1e-300
    return min(_root(allowed / last, ORDER - 1), _root(allowed / before, ORDER - 2))


@compiled(fastmath=FAST, forceinline=True)
def _fastest(length, depth, law):
    """Square of the fastest rate of a contact, about: of its oscillation, or of its decay."""
    k, c, lam, b, _, J, _, _ = law
    share = length * (1 + b * b / J)
    decay = share * (c + lam * depth)
    return max(share * k, decay * decay)


@compiled(fastmath=FAST)
def rock(law, corner, state, time, tolerance, allowed, max_steps, factors, passages, theta, rates):
    k, c, lam, b, h, J, g, ground = law
    p = math.sqrt(g * math.sqrt(b * b + h * h) / (J + h * h + b * b))
    theta_cr = math.atan2(b, h)
    record = rates.size > 0
    z, t = np.empty(ORDER + 1), np.empty(ORDER + 1)
    impacts = np.empty(0)
    # stiffness of the upright block against turning, and the energy below which it is at rest
    flat = g / (2 * b * k)
    turning = (2 / 3) * k * b * b * b - g * h
    rest = 0.5 * turning * (0.03 * tolerance) ** 2 if (c > 0 or lam > 0) and ground == 0 else -1.0
    farthest = theta_cr if ground == 0 else 0.5 * math.pi
    within = 1e-3 * allowed * b
    # where the block changes its corner, θ̈ jumps by w² times this; a step must make more of it to count
    kick, least = 2 * corner * h / (J + h * h), 0.01 * tolerance * p
    by_width, longest, shortest = 1 / b, 1 / p, 1e-15 / p

    # a block that stands on its left corner alone is seen from behind, as one on its right
    depth, v, angle, w = state
    sign, clock = 1.0, 0.0
    s, cos = sincos(angle)
    right, left = depth + b * s > 0, depth - b * s > 0
    depth, v = depth - h * cos, v + h * s * w
    outcome = COMPLETED
    n = n_passed = steps = stiff = 0
    while n < time.size and time[n] <= 0:
        theta[n] = angle
        if record:
            rates[n, 0], rates[n, 1], rates[n, 2] = depth + h * cos, v - h * s * w, w
        n += 1
    while n < time.size:
        if steps >= max_steps:
            outcome = STEP_LIMIT
            break
        if left and not right:
            sign, angle, w, s = -sign, -angle, -w, -s
            law = (k, c, lam, b, h, J, g, sign * ground)
            right, left = True, False
        a = corner if angle > 0 or (angle == 0 and w > 0) else -corner
        if right and left:
            on_whole_base(z, t, depth, v, angle, w, s, cos, a, law)
        elif right:
            on_corner(z, t, depth, v, angle, w, s, cos, a, law)
        else:
            in_air(z, t, depth, v, angle, w, s, cos, a, law)
        step = min(_length_of_step(z, t, by_width, allowed * p), longest)
        # a contact is no longer than the base, which tells at once of most steps
        deepest = max(depth + h * cos + b * s, 0.0)
        held = right and step * step * _fastest(2 * b, deepest, law) > STABLE * STABLE
        if held and not left:
            held = step * step * _fastest(deepest / s, deepest, law) > STABLE * STABLE
        stiff = stiff + 1 if held else max(0, stiff - 1)
        if stiff == PATIENCE:
            outcome = STIFF
            break
        depth1, v1, angle1, w1 = both_at(z, t, step)
        if not (step > shortest and abs(depth1) + abs(v1) + abs(angle1) + abs(w1) < math.inf):
            outcome = NON_FINITE
            break
        s1, cos1 = sincos(angle1)
        base, rate, rate1 = depth1 + h * cos1, v - h * s * w, v1 - h * s1 * w1
        turn, turn1 = b * w * cos, b * w1 * cos1
        of_right = of_left = math.inf
        if (base + b * s1 > 0) != right or (rate + turn) * (rate1 + turn1) < 0:
            of_right = _crossing(
                z, t, step, 1.0, right, rate + turn, base + b * s1, rate1 + turn1, within, law
            )
        if (base - b * s1 > 0) != left or (rate - turn) * (rate1 - turn1) < 0:
            of_left = _crossing(
                z, t, step, -1.0, left, rate - turn, base - b * s1, rate1 - turn1, within, law
            )
        turned = math.inf
        counts = n_passed < factors.size and (angle * angle1 < 0 or (angle == 0 and w * angle1 < 0))
        if counts or (a * angle1 < 0 and kick * step * max(w * w, w1 * w1) > least):
            turned = _passage(z, t, step)
        if min(of_right, of_left, turned) < math.inf:
            step = min(of_right, of_left, turned)
            depth1, v1, angle1, w1 = both_at(z, t, step)
            s1, cos1 = sincos(angle1)
            # upright and not turning: what happens at one corner happens at the other
            both = angle1 == 0 and w1 == 0
            if turned < min(of_right, of_left):
                angle1, s1, cos1 = 0.0, 0.0, 1.0
                if counts:
                    factor = factors[n_passed]
                    if passages.size > 0:
                        if passages[n_passed, 4] > 0:
                            factor = passages[n_passed, 4] / abs(w1)
                        passages[n_passed, 0], passages[n_passed, 1] = clock + step, depth1 + h
                        passages[n_passed, 2], passages[n_passed, 3] = v1, factor
                        passages[n_passed, 4] = sign * factor * w1
                    w1 *= factor
                    n_passed += 1
            elif of_right <= of_left:
                right, left = not right, left != both
            else:
                right, left = right != both, not left

        end, first = clock + step, n
        while n + 8 < time.size and time[n + 8] <= end:
            n += 8
        while n < time.size and time[n] <= end:
            n += 1
        if n > first:
            fill_theta(t, sign, clock, time[first:n], theta[first:n])
            if record:
                _fill_rates(z, t, sign, clock, time[first:n], h, rates[first:n])
        passes = angle * angle1 < 0 or (angle == 0 and w * angle1 < 0) or turned == step
        if record and passes:
            impacts = np.append(impacts, clock + (step if turned == step else _passage(z, t, step)))
        clock, depth, v, angle, w, s, cos = end, depth1, v1, angle1, w1, s1, cos1
        steps += 1
        if abs(angle) > farthest and angle * w >= 0:
            outcome = OVERTURNED
            break
        if right and left and turning > 0:
            bounce, rate = depth + h * cos - flat, v - h * s * w
            energy = k * b * bounce * bounce + 0.5 * turning * s * s
            energy += 0.5 * rate * rate + h * s * rate * w + 0.5 * (J + h * h) * w * w
            if energy < rest:
                outcome = AT_REST
                break
    if outcome != COMPLETED and outcome != STIFF:
        rests = outcome == AT_REST
        for i in range(n, time.size):
            theta[i] = 0.0 if rests else math.nan
            if record:
                rates[i, 0] = flat if rests else math.nan
                rates[i, 1] = rates[i, 2] = 0.0 if rests else math.nan
    there = depth + h * cos, v - h * s * w, sign * angle, sign * w
    return outcome, steps, n, clock, there, impacts, n_passed


def scene_of(law: tuple[float, ...], coefficients: Floats) -> tuple[tuple[float, ...], float]:
    """What `rock` takes of a block, its bed and a base that may lean, as `integrate_series` has them."""
    k, c, lam, b, h, inertia, g, corner, *_ = law
    ground, less = (float(coefficients[0, 0]), float(coefficients[0, 5])) if len(coefficients) else (0.0, 0.0)
    return (k, c, lam, b, h, inertia - h * h, g + less, ground), corner


def integrate_series(
    law: tuple[float, ...],
    state: tuple[float, float, float, float],
    time: Floats,
    breaks: Floats,
    coefficients: Floats,
    tolerance: float,
    max_steps: int,
    factors: Floats,
    passages: Floats,
    theta: Floats,
    rates: Floats,
) -> tuple[int, int, int, int, int, Floats]:
    """As `kernel.integrate`, with `state` its y and `theta` its out: a block with sharp edges.

    Its centre of mass is over the middle, debonding geometric, the ground at rest or leaning
    (`ground.tilted`).

    Where the law turns out to be stiff, from there on by that. A step counts as one evaluation.
    """
    accuracy = tolerance, SHARPER * tolerance, max_steps
    outcome, steps, n, clock, there, impacts, passed = rock(
        *scene_of(law, coefficients), state, time, *accuracy, factors, passages, theta, rates
    )
    if outcome != STIFF:
        return outcome, steps, 0, 0, steps, impacts
    later, own, *others, further = kernel.integrate(
        law,
        -1.0,
        False,
        there,
        time[n:] - clock,
        breaks - clock,
        coefficients,
        tolerance,
        max_steps - steps,
        factors[passed:],
        passages[passed:],
        theta[n:],
        rates[n:] if rates.size else rates,
    )
    rejected, implicit, evaluations = others
    passages[passed:, 0] += clock
    return later, steps + own, rejected, implicit, steps + evaluations, np.append(impacts, clock + further)
