"""Housner's block by other ways than its closed form."""

import math
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock_bench.methods.problem import ATOL_SHARE, Problem, Solution, solution

LINEARISED_REST = 1e-13  # peak below which the linearised block is taken to rest [rad]


def housner_linearised(
    problem: Problem, time: Floats, tolerance: float = 0.0, limit: float = 2e6
) -> Solution:
    """Housner's block for small angles: θ_cr - |θ| grows as cosh p t from a peak (Housner 1963).

    Parameters as in `scipy`; there is no tolerance.
    """
    p, theta_cr, r = problem.block.p, problem.block.theta_cr, problem.parameters["r"]
    theta = np.zeros(time.size)
    peak, start, sign = abs(problem.theta0), 0.0, math.copysign(1.0, problem.theta0)
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


def housner_events(problem: Problem, time: Floats, rtol: float, limit: float = math.inf) -> Solution:
    """Housner's block by `solve_ivp` (DOP853) with a terminal event at each impact.

    Parameters as in `scipy`. Rest is taken for reached where a swing is shorter than rtol [s].
    """
    block, r = problem.block, problem.parameters["r"]
    atol = ATOL_SHARE * rtol * problem.amplitudes[2:]
    theta = np.zeros(time.size)
    evaluations, start, state = 0, 0.0, (problem.theta0, 0.0)
    sign = math.copysign(1.0, problem.theta0)
    while start < time[-1]:
        at = time[time >= start]
        result = _to_the_next_impact(block, sign, (start, *state), time[-1], (rtol, atol), at)
        evaluations += result.nfev
        first = time.size - at.size
        last = first + len(result.t)
        if last > first:
            theta[first:last] = result.y[0]
        if evaluations > limit:
            theta[last:] = np.nan
            return Solution(theta, evaluations, "step_limit")
        impact_s = result.t_events[0]
        if not impact_s.size or impact_s[0] - start < rtol:  # at rest, overturned, or at the end
            break
        start, rate = impact_s[0], r * result.y_events[0][0][1]
        state, sign = (0.0, rate), math.copysign(1.0, rate)
    return solution(problem, time, theta, evaluations, True)


def housner_eventless(problem: Problem, time: Floats, step: float, limit: float = math.inf) -> Solution:
    """Housner's block by Runge and Kutta's steps; after one in which θ changes sign, θ̇ is multiplied by r.

    The impact is not sought within the step. Samples lie on the straight line between steps.

    Parameters
    ----------
    step : float
        Size of the steps [s]. The other parameters as in `scipy`.
    """
    n = int(min(math.ceil(time[-1] / step) + 1, limit))
    block, theta = problem.block, np.empty(n + 1)
    _eventless(block.p**2, block.theta_cr, problem.parameters["r"], problem.theta0, step, theta)
    reached = np.interp(time, step * np.arange(n + 1), theta, right=math.nan)
    return solution(problem, time, reached, 4 * n, True, "step_limit")


@njit(cache=True)
def _eventless(p2: float, theta_cr: float, r: float, theta0: float, step: float, theta: Floats) -> None:
    x, w = theta0, 0.0
    theta[0] = x
    for i in range(theta.size - 1):
        sign = 1.0 if x > 0 or (x == 0 and w > 0) else -1.0
        x1, w1, dx, dw = x, w, 0.0, 0.0
        for part, weight in ((0.0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1.0, 1 / 6)):
            at, rate = x + part * step * dx, w + part * step * dw
            dx, dw = rate, -sign * p2 * math.sin(theta_cr - sign * at)
            x1, w1 = x1 + weight * step * dx, w1 + weight * step * dw
        w = r * w1 if x1 * sign < 0 else w1
        x = x1
        theta[i + 1] = x


def _to_the_next_impact(
    block: Block,
    sign: float,
    state: tuple[float, float, float],
    until_s: float,
    tolerances: tuple[float, Floats],
    at: Floats,
) -> Any:
    """Motion on one corner from t, θ, θ̇ until an impact, until the block has fallen, or until an instant."""
    begun, theta, rate = state
    p2, theta_cr = block.p**2, block.theta_cr

    def rates(t: float, y: Floats) -> tuple[float, float]:
        return y[1], -p2 * sign * math.sin(theta_cr - sign * y[0])

    impact = _terminal(lambda t, y: sign * y[0] if t > begun else 1.0, -1)
    fallen = _terminal(lambda t, y: abs(y[0]) - math.pi / 2, 1)
    rtol, atol = tolerances
    span, events = (begun, until_s), (impact, fallen)
    return solve_ivp(rates, span, (theta, rate), "DOP853", at, rtol=rtol, atol=atol, events=events)


def _terminal(function: Any, direction: int) -> Any:
    """An event at which `solve_ivp` stops."""
    function.terminal, function.direction = True, direction
    return function
