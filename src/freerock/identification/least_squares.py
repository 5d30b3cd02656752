"""Least squares from a start: lmfit within bounds, a line search for r alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import lmfit
import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats
from freerock.identification.problem import Problem, Samples
from freerock.identification.rigid import R_CELL


@dataclass(frozen=True)
class Solution:
    """Where a search ended.

    Parameters
    ----------
    x : ndarray, shape (n_parameters,)
        The fitted numbers.
    mean_square : float
        Mean square residual [rad²].
    evaluations : int
        Of the residual.
    success : bool
    message : str
        Why the search ended.
    """

    x: Floats
    mean_square: float
    evaluations: int
    success: bool
    message: str


def least_squares(problem: Problem, x: Floats, samples: Samples, ftol: float = 1e-7) -> Solution:
    """Least squares from a start; ftol is the relative change of the sum of squares at which it ends."""
    if len(x) == 1:
        return _line_search(problem, x[0], samples)
    parameters, names = _within_bounds(problem, x)

    def vector(p: lmfit.Parameters) -> Floats:
        return np.array([p[name].value for name in names])

    def residual(p: lmfit.Parameters) -> Floats:
        return problem.residual(vector(p), samples)

    def jacobian(p: lmfit.Parameters) -> Floats:
        return samples.averaged(problem.jacobian(vector(p), samples))

    result = lmfit.minimize(
        residual,
        parameters,
        method="least_squares",
        jac=jacobian,
        x_scale="jac",
        ftol=ftol,
        xtol=1e-9,
        gtol=None,
        max_nfev=60,
    )
    return Solution(
        vector(result.params), result.chisqr / result.ndata, result.nfev, result.success, result.message
    )


def _within_bounds(problem: Problem, x: Sequence[float] | Floats) -> tuple[lmfit.Parameters, list[str]]:
    """The fitted numbers as lmfit takes them, off their bounds, and their names."""
    names = [f"x{i}" for i in range(len(x))]
    parameters = lmfit.Parameters()
    for name, start, (low, high) in zip(names, x, problem.bounds(), strict=True):
        margin = 1e-3 * (high - low)
        parameters.add(name, value=float(np.clip(start, low + margin, high - margin)), min=low, max=high)
    return parameters, names


def _line_search(problem: Problem, r: float, samples: Samples) -> Solution:
    """Least squares in r alone: cells of the scan's grid, moved on while the minimum lies at a cell's edge.

    Steps by the Jacobian creep where the residual is as large as the motion.
    """
    ((low, high),) = problem.bounds()

    def error(r: float) -> float:
        return float(np.sum(problem.residual(np.array([r]), samples) ** 2))

    r, moved, evaluations = float(np.clip(r, low, high)), True, 0
    while moved:
        half = R_CELL * (1 - r)
        cell = max(low, r - half), min(high, r + half)
        found = minimize_scalar(error, bounds=cell, method="bounded", options={"xatol": 1e-6 * half})
        moved = abs(found.x - r) > 0.9 * half and low + 1e-6 < found.x < high - 1e-6
        r, evaluations = found.x, evaluations + found.nfev
    n = sum(n // samples.m for n in samples.lengths)
    return Solution(np.array([r]), found.fun / n, evaluations, found.success, found.message)
