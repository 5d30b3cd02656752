"""Contact laws integrated without locating the changes of contact, which is how it is done in the field.

The right-hand side exists twice: that of `freerock.models.kernel`, called from Python, and one that is
compiled, written for this module and independent of it. All that is compiled stands in this file. Numba's
cache notices a change in the file of the cached function only.
"""

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from freerock.arrays import Floats
from freerock.models.kernel import accelerations
from freerock.models.laws import Foundation
from freerock_bench.methods.problem import ATOL_SHARE, BLOWN_UP, Problem, Solution, solution

NEWTON_ITERATIONS = 20
Ends = tuple[float, float, float, float]


class _Limit(Exception):
    """More evaluations than allowed."""


# The right-hand side


@njit(cache=True, error_model="numpy")
def _clip(value: float, slope: float, u0: float, u1: float) -> tuple[float, float]:
    """The part of [u0, u1] where value + slope u is positive."""
    if slope > 0:
        u0 = max(u0, min(-value / slope, u1))
    elif slope < 0:
        u1 = min(u1, max(-value / slope, u0))
    elif not value > 0:
        u1 = u0
    return u0, u1


@njit(cache=True, error_model="numpy")
def rates(dy: Floats, y: Floats, law: Floats) -> None:
    """Rates of z_cb, ż_cb, θ, θ̇: eq. (1) of Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024."""
    k, c, lam, inertia, b, h, g = law[0], law[1], law[2], law[3], law[4], law[5], law[6]
    z, v, w = y[0], y[1], y[3]
    s, cos = math.sin(y[2]), math.cos(y[2])
    q = w * cos
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
def right_hand_side(t: float, y: Floats, law: Floats) -> Floats:
    """The compiled right-hand side as SciPy calls it."""
    dy = np.empty(4)
    rates(dy, y, law)
    return dy


def plain_right_hand_side(problem: Problem) -> Callable[[float, Floats], Floats]:
    """The law of `freerock.models.kernel` as SciPy calls it."""
    law, tensionless = (
        Foundation.of(problem.parameters).constants(problem.block),
        problem.debonding == "tensionless",
    )

    def rates(t: float, y: Floats) -> Floats:
        a, turn = accelerations(law, tensionless, (y[0], y[1], y[2], y[3]))
        return np.array([y[1], a, y[3], turn])

    return rates


# Adaptive steps


def scipy(
    method: str,
    compiled: bool,
    problem: Problem,
    time: Floats,
    rtol: float,
    limit: float = math.inf,
) -> Solution:
    """`scipy.integrate.solve_ivp` with the compiled or with the plain right-hand side.

    Parameters
    ----------
    method : str
        "RK45", "DOP853", "LSODA" or "Radau".
    compiled : bool
        Which right-hand side.
    problem : Problem
        Winkler or Hunt-Crossley.
    time : ndarray, shape (n_time,)
        Instants from 0 on [s].
    rtol : float
        Relative tolerance.
    limit : float
        Evaluations after which to give up.
    """
    call = partial(_with_law, problem.law) if compiled else plain_right_hand_side(problem)
    count = 0

    def counted(t: float, y: Floats) -> Floats:
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
                problem.start,
                method=method,
                t_eval=time,
                rtol=rtol,
                atol=ATOL_SHARE * rtol * problem.amplitudes,
            )
    except _Limit:
        return Solution(np.full(time.size, np.nan), count, "step_limit")
    except ValueError:  # Radau's linear algebra met a state that is not finite
        return Solution(np.full(time.size, np.nan), count, "non_finite")
    return solution(problem, time, result.y[2], result.nfev, result.success)


def _with_law(law: Floats, t: float, y: Floats) -> Floats:
    return right_hand_side(t, y, law)


def cyrk(
    method: str, compiled: bool, problem: Problem, time: Floats, rtol: float, limit: float = math.inf
) -> Solution:
    """CyRK's C++ solver with the right-hand side compiled to a C function, or with the plain one.

    Parameters
    ----------
    method : str
        "RK45", "DOP853", "LSODA", "RADAU" and others.
    limit : float
        Steps after which to give up. The other parameters as in `scipy`.
    """
    from CyRK import nbsolve2_ivp, pysolve_ivp

    span, atol = (0.0, float(time[-1])), ATOL_SHARE * rtol * problem.amplitudes
    how = {"method": method, "t_eval": time, "rtol": rtol}
    how["max_num_steps"] = 0 if limit == math.inf else int(limit)
    if compiled:
        result = nbsolve2_ivp(_c_function(), span, problem.start, args=problem.law, atols=atol, **how)
    else:
        result = pysolve_ivp(plain_right_hand_side(problem), span, problem.start, atol=atol, **how)
    success = result.success
    stopped = "step_limit" if "number of steps" in result.message else "non_finite"
    theta = result.y[2].copy() if success else np.empty(0)
    if compiled:
        result.free()
    return solution(problem, time, theta, math.nan, success, stopped)


@cache
def _c_function() -> int:
    from CyRK import nb_diffeq_addr

    def call(dy: Floats, t: float, y: Floats, law: Floats) -> None:
        rates(dy, y, law)

    return int(nb_diffeq_addr(call))


# Fixed steps


def fixed_step(method: str, problem: Problem, time: Floats, step: float, limit: float = math.inf) -> Solution:
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
    most = int(min(limit, 2**62))
    arguments = problem.start, problem.law, step, most, problem.amplitudes, time, theta
    outcome, evaluations = {"RK4": _rk4, "Newmark": _newmark}[method](*arguments)
    failure = ("non_finite", "step_limit", "not_converged")[outcome]
    return solution(problem, time, theta, evaluations, False, failure)


@njit(cache=True, nogil=True)
def _sample(time: Floats, theta: Floats, n: int, t: float, step: float, ends: Ends) -> int:
    """Fill the samples up to t + step from θ and θ̇ at both ends of the step; returns the next one."""
    theta0, theta1, w0, w1 = ends
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
def _rk4(
    y: Floats, law: Floats, step: float, most: int, amplitudes: Floats, time: Floats, theta: Floats
) -> tuple[int, int]:
    slope, stage, new = np.empty(4), np.empty(4), np.empty(4)
    n = 0
    for i in range(most):
        stage[:], new[:] = y, y
        for part, weight in ((0.5, 1 / 6), (0.5, 1 / 3), (1.0, 1 / 3), (0.0, 1 / 6)):
            rates(slope, stage, law)
            for j in range(4):
                stage[j] = y[j] + part * step * slope[j]
                new[j] += weight * step * slope[j]
        n = _sample(time, theta, n, i * step, step, (y[2], new[2], y[3], new[3]))
        y[:] = new
        if n == time.size or not abs(y[2]) < BLOWN_UP:
            return 0, 4 * (i + 1)
    return 1, 4 * most


@njit(cache=True, nogil=True)
def _newmark(
    y: Floats, law: Floats, step: float, most: int, amplitudes: Floats, time: Floats, theta: Floats
) -> tuple[int, int]:
    """β = 1/4, γ = 1/2 (Newmark 1959); the accelerations at the end of a step by Newton's iteration."""
    dy, base, turned, new = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    rates(dy, y, law)
    a, turn = dy[1], dy[3]
    evaluations, n = 1, 0
    small = 1e-11 * amplitudes[0], 1e-11 * amplitudes[2]
    shift = 2e-7 * amplitudes[1] / step, 2e-7 * amplitudes[3] / step
    for i in range(most):
        a1, turn1 = a, turn
        converged = False
        for _ in range(NEWTON_ITERATIONS):
            _average(new, y, step, a + a1, turn + turn1)
            rates(base, new, law)
            _average(new, y, step, a + a1 + shift[0], turn + turn1)
            rates(dy, new, law)
            _average(new, y, step, a + a1, turn + turn1 + shift[1])
            rates(turned, new, law)
            evaluations += 3
            # Newton on acceleration minus right-hand side
            j11, j21 = 1 - (dy[1] - base[1]) / shift[0], -(dy[3] - base[3]) / shift[0]
            j12, j22 = -(turned[1] - base[1]) / shift[1], 1 - (turned[3] - base[3]) / shift[1]
            r1, r2 = base[1] - a1, base[3] - turn1
            determinant = j11 * j22 - j12 * j21
            da, dturn = (r1 * j22 - r2 * j12) / determinant, (r2 * j11 - r1 * j21) / determinant
            a1, turn1 = a1 + da, turn1 + dturn
            if abs(da) * step * step < small[0] and abs(dturn) * step * step < small[1]:
                converged = True
                break
        if not converged:
            return 2, evaluations
        _average(new, y, step, a + a1, turn + turn1)
        n = _sample(time, theta, n, i * step, step, (y[2], new[2], y[3], new[3]))
        y[:] = new
        a, turn = a1, turn1
        if n == time.size or not abs(y[2]) < BLOWN_UP:
            return 0, evaluations
    return 1, evaluations


@njit(cache=True, nogil=True)
def _average(new: Floats, y: Floats, step: float, twice_a: float, twice_turn: float) -> None:
    """State after a step of constant accelerations, whose doubles are given."""
    new[0] = y[0] + step * (y[1] + step * twice_a / 4)
    new[1] = y[1] + step * twice_a / 2
    new[2] = y[2] + step * (y[3] + step * twice_turn / 4)
    new[3] = y[3] + step * twice_turn / 2
