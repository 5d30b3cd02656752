"""Least squares from a start: a trust region within bounds, a line search for r alone."""

from dataclasses import dataclass

import lmfit
import numpy as np
from scipy import optimize

from freerock.arrays import Floats
from freerock.identification.minimizer import (
    LEAST,
    MOST,
    XTOL,
    in_si_units,
    minimised,
    parameters_of,
    varied,
)
from freerock.identification.problem import Problem, Samples
from freerock.identification.rigid import R_CELL

ENOUGH = 0.3  # of the gain that was foretold: SciPy ends where it is a quarter


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
    result : lmfit.minimizer.MinimizerResult or None
        Of the least squares whose numbers are reported.
    """

    x: Floats
    mean_square: float
    evaluations: int
    success: bool
    message: str
    result: "lmfit.minimizer.MinimizerResult | None" = None


def least_squares(
    problem: Problem,
    x: Floats,
    samples: Samples,
    ftol: float = 1e-7,
    jacobian: Floats | None = None,
    theta: Floats | None = None,
) -> Solution:
    """Least squares from a start; ftol is the relative change of the sum of squares at which it ends.

    `jacobian` and `theta` are the derivatives and the curve at the start, as `Problem` has them, where they
    are known.
    """
    if len(x) == 1:
        return _line_search(problem, x[0], samples)
    bounds, start, xtol = _within(problem, x)
    at = _AtLast(problem, samples, x, (jacobian, theta), ftol)
    result = optimize.least_squares(
        at.residual,
        start,
        at.jacobian,
        bounds,
        x_scale="jac",
        ftol=ftol,
        xtol=max(xtol, LEAST),
        gtol=None,
        max_nfev=MOST,
    )
    mean_square = float(np.sum(result.fun**2) / len(result.fun))
    return Solution(result.x, mean_square, result.nfev, result.success, result.message)


def reported(
    problem: Problem,
    x: Floats,
    samples: Samples,
    ftol: float = 1e-7,
    jacobian: Floats | None = None,
    theta: Floats | None = None,
) -> Solution:
    """The same by `lmfit.Minimizer`: the least squares whose numbers are reported; arguments as there."""
    evaluations = 0
    if len(x) == 1:
        found = _line_search(problem, x[0], samples)
        x, evaluations, jacobian, theta = found.x, found.evaluations, None, None
    bounds, start, xtol = _within(problem, x)
    at = _AtLast(problem, samples, x, (jacobian, theta), ftol)
    parameters = parameters_of(problem, start, list(zip(*bounds, strict=True)))
    result = minimised(parameters, at.residual, at.jacobian, ftol, xtol)
    mean_square = float(np.mean(result.residual**2))
    x = varied(result)
    in_si_units(result, problem, x)
    return Solution(x, mean_square, evaluations + result.nfev, result.success, result.message, result)


def _within(problem: Problem, x: Floats) -> tuple[tuple[Floats, Floats], Floats, float]:
    """Bounds, a start within them, and the relative step at which a search ends."""
    low, high = np.array(problem.bounds()).T
    shorter = min(problem.stride, 1.0)
    inside = 1e-3 * shorter * (high - low)
    return (low, high), np.clip(x, low + inside, high - inside), XTOL * shorter


class _AtLast:
    """Residual and derivatives, which are asked for where the residual has just been: its curve is theirs,
    where it is exact enough. SciPy asks for them once more after the step that ends the search, and does not
    use them: these are those of the step before."""

    def __init__(
        self,
        problem: Problem,
        samples: Samples,
        start: Floats,
        at_start: tuple[Floats | None, Floats | None],
        ftol: float,
    ) -> None:
        self.problem, self.samples, self.ftol = problem, samples, ftol
        self.start, self.at_start = start, at_start
        self.rate = np.empty(len(samples.time_s)) if problem.shares_curve else None
        self.x = self.theta = self.left = np.empty(0)
        self.before: tuple[Floats, Floats, Floats] | None = None

    def residual(self, x: Floats) -> Floats:
        self.x, known = x.copy(), self.at_start[1]
        if known is not None and self.rate is None and np.array_equal(x, self.start):
            self.theta = known
        else:
            self.theta = self.problem.curve(x, self.samples, rate=self.rate)
        self.left = self.samples.averaged(self.theta - self.samples.theta)
        return self.left

    def jacobian(self, x: Floats) -> Floats:
        known = None if self.before is None or not self._ends(x, *self.before) else self.before[2]
        jacobian = self._jacobian(x) if known is None else known
        self.before = x.copy(), self.left, jacobian
        return jacobian

    def _ends(self, x: Floats, before: Floats, left: Floats, jacobian: Floats) -> bool:
        """Whether the search ends here: the step has gained little, and no less than was foretold."""
        change = jacobian @ (x - before)
        square = float(left @ left)
        gained, foretold = square - float(self.left @ self.left), -float(change @ (2 * left + change))
        return 0 < ENOUGH * foretold < gained < self.ftol * square

    def _jacobian(self, x: Floats) -> Floats:
        if self.at_start[0] is not None and np.array_equal(x, self.start):
            return self.samples.averaged(self.at_start[0])
        known = None
        if self.rate is not None and np.array_equal(x, self.x):
            known = self.theta, self.rate
        return self.samples.averaged(self.problem.jacobian(x, self.samples, known=known))


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
        found = optimize.minimize_scalar(error, bounds=cell, method="bounded", options={"xatol": 1e-6 * half})
        moved = abs(found.x - r) > 0.9 * half and low + 1e-6 < found.x < high - 1e-6
        r, evaluations = found.x, evaluations + found.nfev
    n = sum(n // samples.m for n in samples.lengths)
    return Solution(np.array([r]), found.fun / n, evaluations, found.success, found.message)
