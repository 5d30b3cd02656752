"""Methods to compare freerock with: SciPy, CyRK, fixed steps, springs, and Housner's linearised form.

None of them locates the changes of contact, which is how they are used in the field. The right-hand
side exists twice: `freerock.models.contact` in plain Python, and compiled, written for this module
and independent of the kernel in `freerock.models.kernel`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from freerock.models.block import GRAVITY, Block
from freerock.models.contact import accelerations, static_depth
from freerock.models.simulate import simulate

# Absolute tolerances of SciPy and CyRK: rtol times this share of each component's amplitude.
ATOL_SHARE = 0.01
NEWTON_ITERATIONS = 20
BLOWN_UP = 10.0  # |θ| that no block has [rad]
RESTING_RATE = 1e-9  # after an impact; the block is taken to rest [rad/s]
LINEARISED_REST = 1e-13  # peak below which the linearised block is taken to rest [rad]


@dataclass(frozen=True)
class Scene:
    """A block released from rest on a foundation.

    Parameters
    ----------
    model : str
        "housner", "winkler" or "hunt_crossley".
    block : Block
        The block.
    parameters : mapping
        Parameters of the model, SI.
    theta0 : float
        Angle of release [rad].
    debonding : str
        "geometric" or "tensionless".
    springs : int
        Number of springs that stand for the foundation in the compiled right-hand side; 0: distributed.
    """

    model: str
    block: Block
    parameters: Mapping[str, float]
    theta0: float
    debonding: str = "geometric"
    springs: int = 0

    @property
    def law(self) -> np.ndarray:
        """Constants of the compiled right-hand side: k, c, λ, I over m; b, h, g; tensionless; springs."""
        m, b, h = self.block.mass_kg, self.block.b, self.block.h
        k, c, lam = (self.parameters.get(name, 0.0) for name in ("k", "c", "lambda"))
        tensionless = float(self.debonding == "tensionless")
        inertia = self.block.inertia_base
        return np.array([k / m, c / m, lam / m, inertia / m, b, h, GRAVITY, tensionless, self.springs])

    @property
    def start(self) -> np.ndarray:
        """z_cb [m], ż_cb [m/s], θ [rad] and θ̇ [rad/s] at the release."""
        return np.array([static_depth(self.block, self.parameters["k"], self.theta0), 0.0, self.theta0, 0.0])

    @property
    def amplitudes(self) -> np.ndarray:
        """Size of each component of the state."""
        b, p = self.block.b, self.block.p
        return abs(self.theta0) * np.array([b, b * p, 1.0, p])


@dataclass(frozen=True)
class Solution:
    """What a method made of a scene.

    Parameters
    ----------
    theta : ndarray, shape (n_time,)
        Rotation [rad]; NaN after a failure or once overturned.
    evaluations : float
        Evaluations of the right-hand side; NaN where the method does not tell.
    outcome : str
        "completed", "overturned", "step_limit", "non_finite" or "not_converged".
    """

    theta: np.ndarray
    evaluations: float
    outcome: str


class _Limit(Exception):
    """More evaluations than allowed."""


# The compiled right-hand side


@njit(cache=True, error_model="numpy")
def _clip(value, slope, u0, u1):
    """The part of [u0, u1] where value + slope u is positive."""
    if slope > 0:
        u0 = max(u0, min(-value / slope, u1))
    elif slope < 0:
        u1 = min(u1, max(-value / slope, u0))
    elif not value > 0:
        u1 = u0
    return u0, u1


@njit(cache=True, error_model="numpy")
def rates(dy, y, law):
    """Rates of z_cb, ż_cb, θ, θ̇: eq. (1) of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024."""
    k, c, lam, inertia, b, h, g = law[0], law[1], law[2], law[3], law[4], law[5], law[6]
    z, v, w = y[0], y[1], y[3]
    s, cos = math.sin(y[2]), math.cos(y[2])
    q = w * cos
    n = int(law[8])
    force = 0.0
    moment = 0.0
    for i in range(n):
        u = b * ((2 * i + 1) / n - 1)
        depth, rate = z + u * s, v + u * q
        f = (k * depth + c * rate + lam * depth * rate) * (2 * b / n)
        if depth > 0 and (f > 0 or law[7] == 0):
            force += f
            moment += f * u * cos
    if n == 0:
        u0, u1 = _clip(z, s, -b, b)
        if law[7] > 0:
            if lam > 0:
                u0, u1 = _clip(k + lam * v, lam * q, u0, u1)
            else:
                u0, u1 = _clip(k * z + c * v, k * s + c * q, u0, u1)
        f0, f1, f2 = k * z + c * v + lam * z * v, k * s + c * q + lam * (s * v + z * q), lam * s * q
        # mean of u, u², u³ over the contact
        length, total, product = u1 - u0, u0 + u1, u0 * u1
        mean1 = total / 2
        mean2 = (total * total - product) / 3
        mean3 = total * (total * total - 2 * product) / 4
        force = length * (f0 + f1 * mean1 + f2 * mean2)
        moment = cos * length * (f0 * mean1 + f1 * mean2 + f2 * mean3)
    vertical = g - force - h * cos * w * w
    turning = (h * g * s - moment - h * s * vertical) / (inertia - h * h * s * s)
    dy[0], dy[1], dy[2], dy[3] = v, vertical - h * s * turning, w, turning


@njit(cache=True)
def right_hand_side(t, y, law):
    """The compiled right-hand side as SciPy calls it."""
    dy = np.empty(4)
    rates(dy, y, law)
    return dy


def plain_right_hand_side(scene: Scene):
    """The plain law of `freerock.models.contact` as SciPy calls it."""
    k, c, lam = (scene.parameters.get(name, 0.0) for name in ("k", "c", "lambda"))
    block, debonding = scene.block, scene.debonding

    def rates(t, y):
        z, v, theta, w = y.tolist()
        a, turn = accelerations(block, k, c, lam, z, v, theta, w, debonding)
        return np.array([v, a, w, turn])

    return rates


# Adaptive steps


def scipy(method: str, compiled: bool, scene: Scene, time, rtol: float, limit: float = math.inf) -> Solution:
    """`scipy.integrate.solve_ivp` with the compiled or with the plain right-hand side.

    Parameters
    ----------
    method : str
        "RK45", "DOP853", "LSODA" or "Radau".
    compiled : bool
        Which right-hand side.
    scene : Scene
        Winkler or Hunt-Crossley.
    time : ndarray, shape (n_time,)
        Instants from 0 on [s].
    rtol : float
        Relative tolerance.
    limit : float
        Evaluations after which to give up.
    """
    if compiled:
        law = scene.law
        call = partial(_with_law, law)
    else:
        call = plain_right_hand_side(scene)
    count = 0

    def counted(t, y):
        nonlocal count
        count += 1
        if count > limit:
            raise _Limit
        return call(t, y)

    try:
        with np.errstate(all="ignore"):
            result = solve_ivp(
                call if limit == math.inf else counted,
                (0.0, time[-1]),
                scene.start,
                method=method,
                t_eval=time,
                rtol=rtol,
                atol=ATOL_SHARE * rtol * scene.amplitudes,
            )
    except _Limit:
        return Solution(np.full(time.size, np.nan), count, "step_limit")
    except ValueError:  # Radau's linear algebra met a state that is not finite
        return Solution(np.full(time.size, np.nan), count, "non_finite")
    return _solution(scene, time, result.y[2], result.nfev, result.success)


def _with_law(law, t, y):
    return right_hand_side(t, y, law)


def cyrk(method: str, scene: Scene, time, rtol: float, limit: float = math.inf) -> Solution:
    """CyRK's C++ solver with the right-hand side compiled to a C function.

    Parameters
    ----------
    method : str
        "RK45", "DOP853", "LSODA", "RADAU" and others.
    limit : float
        Steps after which to give up. The other parameters as in `scipy`.

    Raises
    ------
    ImportError
        CyRK is not installed.
    """
    from CyRK import nbsolve2_ivp

    result = nbsolve2_ivp(
        _c_function(),
        (0.0, float(time[-1])),
        scene.start,
        method=method,
        t_eval=time,
        args=scene.law,
        rtol=rtol,
        atols=ATOL_SHARE * rtol * scene.amplitudes,
        max_num_steps=0 if limit == math.inf else int(limit),
    )
    success = result.success
    stopped = "step_limit" if "number of steps" in result.message else "non_finite"
    theta = result.y[2].copy() if success else np.empty(0)
    result.free()
    return _solution(scene, time, theta, math.nan, success, stopped)


@cache
def _c_function() -> int:
    from CyRK import nb_diffeq_addr

    def call(dy, t, y, law):
        rates(dy, y, law)

    return nb_diffeq_addr(call)


def _solution(scene, time, theta, evaluations, success, failure="non_finite"):
    """θ cut where it is not finite or where the block has passed its critical angle."""
    full = np.full(time.size, np.nan)
    full[: len(theta)] = theta
    bad = np.flatnonzero(~(np.abs(full) <= scene.block.theta_cr))
    if len(bad) == 0:
        return Solution(full, evaluations, "completed")
    overturned = abs(full[bad[0]]) < BLOWN_UP
    full[bad[0] :] = np.nan
    outcome = "overturned" if overturned else "non_finite" if success else failure
    return Solution(full, evaluations, outcome)


# Fixed steps


def fixed_step(method: str, scene: Scene, time, step: float, limit: float = math.inf) -> Solution:
    """Steps of one size, sampled by cubic Hermite interpolation.

    Parameters
    ----------
    method : str
        "RK4" (classical Runge-Kutta) or "Newmark" (average acceleration, Newton's iteration).
    step : float
        Size of the steps [s].
    limit : float
        Steps after which to give up. The other parameters as in `scipy`.
    """
    theta = np.full(time.size, np.nan)
    run = {"RK4": _rk4, "Newmark": _newmark}[method]
    most = int(min(limit, 2**62))
    outcome, evaluations = run(scene.start, scene.law, step, most, scene.amplitudes, time, theta)
    failure = ("non_finite", "step_limit", "not_converged")[outcome]
    return _solution(scene, time, theta, evaluations, False, failure)


@njit(cache=True, nogil=True)
def _sample(time, theta, n, t, step, theta0, theta1, w0, w1):
    """Fill the samples up to t + step; returns the next one."""
    while n < time.size and time[n] <= t + step:
        x = (time[n] - t) / step
        theta[n] = (
            theta0 * (1 - x) ** 2 * (1 + 2 * x)
            + theta1 * x * x * (3 - 2 * x)
            + step * x * (1 - x) * (w0 * (1 - x) - w1 * x)
        )
        n += 1
    return n


@njit(cache=True, nogil=True)
def _rk4(y, law, step, most, amplitudes, time, theta):
    slope, stage, new = np.empty(4), np.empty(4), np.empty(4)
    n = 0
    for i in range(most):
        stage[:], new[:] = y, y
        for part, weight in ((0.5, 1 / 6), (0.5, 1 / 3), (1.0, 1 / 3), (0.0, 1 / 6)):
            rates(slope, stage, law)
            for j in range(4):
                stage[j] = y[j] + part * step * slope[j]
                new[j] += weight * step * slope[j]
        n = _sample(time, theta, n, i * step, step, y[2], new[2], y[3], new[3])
        y[:] = new
        if n == time.size or not abs(y[2]) < BLOWN_UP:
            return 0, 4 * (i + 1)
    return 1, 4 * most


@njit(cache=True, nogil=True)
def _newmark(y, law, step, most, amplitudes, time, theta):
    """β = 1/4, γ = 1/2 (Newmark 1959); the accelerations at the end of the step by Newton's iteration."""
    dy, base, turned = np.empty(4), np.empty(4), np.empty(4)
    new = np.empty(4)
    rates(dy, y, law)
    a, turn = dy[1], dy[3]
    evaluations = 1
    small = 1e-11 * amplitudes[0], 1e-11 * amplitudes[2]
    shift = 2e-7 * amplitudes[1] / step, 2e-7 * amplitudes[3] / step
    n = 0
    for i in range(most):
        a1, turn1 = a, turn
        converged = False
        for _ in range(NEWTON_ITERATIONS):
            _average(new, y, step, a, turn, a1, turn1)
            rates(base, new, law)
            _average(new, y, step, a, turn, a1 + shift[0], turn1)
            rates(dy, new, law)
            _average(new, y, step, a, turn, a1, turn1 + shift[1])
            rates(turned, new, law)
            evaluations += 3
            # Newton on acceleration minus right-hand side
            j11 = 1 - (dy[1] - base[1]) / shift[0]
            j21 = -(dy[3] - base[3]) / shift[0]
            j12 = -(turned[1] - base[1]) / shift[1]
            j22 = 1 - (turned[3] - base[3]) / shift[1]
            r1, r2 = base[1] - a1, base[3] - turn1
            determinant = j11 * j22 - j12 * j21
            da = (r1 * j22 - r2 * j12) / determinant
            dturn = (r2 * j11 - r1 * j21) / determinant
            a1 += da
            turn1 += dturn
            if abs(da) * step * step < small[0] and abs(dturn) * step * step < small[1]:
                converged = True
                break
        if not converged:
            return 2, evaluations
        _average(new, y, step, a, turn, a1, turn1)
        n = _sample(time, theta, n, i * step, step, y[2], new[2], y[3], new[3])
        y[:] = new
        a, turn = a1, turn1
        if n == time.size or not abs(y[2]) < BLOWN_UP:
            return 0, evaluations
    return 1, evaluations


@njit(cache=True, nogil=True)
def _average(new, y, step, a, turn, a1, turn1):
    new[0] = y[0] + step * y[1] + 0.25 * step * step * (a + a1)
    new[1] = y[1] + 0.5 * step * (a + a1)
    new[2] = y[2] + step * y[3] + 0.25 * step * step * (turn + turn1)
    new[3] = y[3] + 0.5 * step * (turn + turn1)


# Housner's block


def housner_linearised(scene: Scene, time, tolerance: float = 0.0, limit: float = 2e6) -> Solution:
    """Housner's block for small angles: θ_cr - |θ| grows as cosh p t from a peak (Housner 1963).

    Parameters as in `scipy`; there is no tolerance.
    """
    p, theta_cr, r = scene.block.p, scene.block.theta_cr, scene.parameters["r"]
    theta = np.zeros(time.size)
    peak, start, sign = abs(scene.theta0), 0.0, math.copysign(1.0, scene.theta0)
    quarter = math.acosh(1 / (1 - peak / theta_cr)) / p
    first, n = 0, 0
    while first < time.size and peak > LINEARISED_REST and n < limit:
        end = start + quarter
        last = int(np.searchsorted(time, end, side="right"))
        theta[first:last] = sign * (theta_cr - (theta_cr - peak) * np.cosh(p * (time[first:last] - start)))
        # θ̇² at an impact is p² (θ_cr² - (θ_cr - peak)²)
        energy = r * r * peak * (2 * theta_cr - peak)
        peak = energy / (theta_cr + math.sqrt(theta_cr**2 - energy))
        quarter = math.acosh(1 + peak / (theta_cr - peak)) / p
        start, sign, first, n = end + quarter, -sign, last, n + 1
    return Solution(theta, 0, "completed")


def housner_events(scene: Scene, time, rtol: float, limit: float = math.inf) -> Solution:
    """Housner's block by `solve_ivp` (DOP853) with a terminal event at each impact.

    Parameters as in `scipy`. Rest is taken for reached where a swing is shorter than rtol [s].
    """
    block, r = scene.block, scene.parameters["r"]
    p2, theta_cr = block.p**2, block.theta_cr
    theta = np.zeros(time.size)
    evaluations, start, state = 0, 0.0, (scene.theta0, 0.0)
    sign = math.copysign(1.0, scene.theta0)
    while start < time[-1]:

        def rates(t, y, sign=sign):
            return y[1], -sign * p2 * math.sin(theta_cr - sign * y[0])

        def impact(t, y, sign=sign):
            return sign * y[0]

        impact.terminal, impact.direction = True, -1
        at = time[time >= start]
        result = solve_ivp(
            rates,
            (start, time[-1]),
            state,
            method="DOP853",
            t_eval=at,
            rtol=rtol,
            atol=ATOL_SHARE * rtol * scene.amplitudes[2:],
            events=impact,
        )
        evaluations += result.nfev
        first = time.size - at.size
        last = first + len(result.t)
        if last > first:
            theta[first:last] = result.y[0]
        if evaluations > limit:
            theta[last:] = np.nan
            return Solution(theta, evaluations, "step_limit")
        if result.status != 1 or result.t_events[0][0] - start < rtol:
            break
        start, rate = result.t_events[0][0], r * result.y_events[0][0][1]
        state, sign = (0.0, rate), math.copysign(1.0, rate)
    return _solution(scene, time, theta, evaluations, True)


def housner_overturns(block: Block, r: float, amplitude: float, period_s: float, rtol: float = 1e-10) -> bool:
    """Whether a horizontal pulse ẍ_g = A sin(2π t/T), 0 < t < T, overturns Housner's block at rest.

    `solve_ivp` (DOP853) with terminal events at impacts, up to the end of the pulse; then by energy. The
    block lifts off where |ẍ_g| passes g b/h (Housner 1963).

    Parameters
    ----------
    block : Block
        The block.
    r : float
        Restitution, 0 <= r <= 1.
    amplitude : float
        A [m/s²].
    period_s : float
        T [s].
    """
    p2, theta_cr, omega = block.p**2, block.theta_cr, 2 * math.pi / period_s
    lift_off = GRAVITY * math.tan(theta_cr)

    def ground(t):
        return amplitude * math.sin(omega * t)

    def event(function, direction):
        function.terminal, function.direction = True, direction
        return function

    t, theta, rate = 0.0, 0.0, 0.0
    while True:
        if theta == 0 and abs(rate) < RESTING_RATE:
            # at rest until the ground's acceleration passes the threshold again
            turn = math.asin(min(1.0, lift_off / amplitude))
            if not abs(ground(t)) > lift_off:
                starts = [(turn + n * math.pi) / omega for n in (0, 1)]
                t = next((start for start in starts if start > t), math.inf)
            if amplitude <= lift_off or t >= period_s:
                return False
            sign, rate = math.copysign(1.0, math.sin(omega * t)), 0.0
        else:
            sign = math.copysign(1.0, theta or rate)

        def rates(t, y, sign=sign):
            phi = theta_cr - sign * y[0]
            return y[1], p2 * (math.cos(phi) * ground(t) / GRAVITY - sign * math.sin(phi))

        impact = event(lambda t, y, sign=sign, begun=t: sign * y[0] if t > begun else 1.0, -1)
        fallen = event(lambda t, y: abs(y[0]) - math.pi / 2, 1)
        scale = [theta_cr, block.p * theta_cr]
        result = solve_ivp(
            rates,
            (t, period_s),
            (theta, rate),
            method="DOP853",
            rtol=rtol,
            atol=rtol * np.array(scale),
            events=(impact, fallen),
        )
        if len(result.t_events[1]):
            return True
        if not len(result.t_events[0]):
            break
        t, theta, rate = result.t_events[0][0], 0.0, r * result.y_events[0][0][1]
    theta, rate = result.y[:, -1]
    # free from here on: θ̇²/2 + p² cos φ keeps its value between impacts, and is p² at the top
    sign = math.copysign(1.0, theta or rate)
    phi = theta_cr - sign * theta
    outward, passes = sign * rate >= 0, 0.5 * rate**2 > p2 * (1 - math.cos(phi))
    if passes and not outward:
        at_impact = 0.5 * rate**2 + p2 * (math.cos(phi) - math.cos(theta_cr))
        return r * r * at_impact > p2 * (1 - math.cos(theta_cr))
    return passes or phi < 0


# freerock itself, with the signature of the others


def freerock(scene: Scene, time, rtol: float, limit: float = math.inf) -> Solution:
    """`freerock.models.simulate` on the scene. Parameters as in `scipy`; the limit counts steps."""
    response = simulate(
        scene.model,
        scene.block,
        scene.parameters,
        time,
        theta0=scene.theta0,
        debonding=scene.debonding,
        rtol=rtol,
        max_steps=int(min(limit, 2**31)),
    )
    outcome = "completed" if response.outcome == "at_rest" else response.outcome
    return Solution(response.theta, response.statistics["evaluations"], outcome)


METHODS = {
    "freerock": freerock,
    **{
        f"SciPy {name}, {kind}": partial(scipy, name, kind == "numba")
        for kind in ("NumPy", "numba")
        for name in ("RK45", "DOP853", "LSODA", "Radau")
    },
    **{f"CyRK {name}": partial(cyrk, name) for name in ("RK45", "DOP853", "LSODA", "RADAU")},
    "RK4": partial(fixed_step, "RK4"),
    "Newmark": partial(fixed_step, "Newmark"),
}
HOUSNER_METHODS = {
    "freerock": freerock,
    "SciPy DOP853, events": housner_events,
    "linearised": housner_linearised,
}
