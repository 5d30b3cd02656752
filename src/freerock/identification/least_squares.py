"""Least squares from a start, within bounds: a trust region, for r alone a line search.

What seeks a start is bare. The numbers that a fit reports are found by `lmfit.Minimizer` with the problem's
derivatives (`minimised`).
"""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace

import lmfit
import numpy as np
from scipy import optimize

from freerock.arrays import Floats, Mask
from freerock.identification.problem import Problem, Samples
from freerock.models.given import arithmetic, legal


@dataclass(frozen=True)
class EndSettings:
    """When least squares end.

    Parameters
    ----------
    xtol : float
        Relative step; less where the difference quotients' steps are less.
    least : float
        Least relative change that SciPy takes, and the gradient at which nothing changes [rad²].
    most : int
        Evaluations of the residual.
    enough : float
        Of the gain that was foretold: SciPy ends where it is a quarter.
    r_cell : float
        Half a cell of a line search in r, relative to 1 - r: the spacing of the scan's grid.
    """

    xtol: float = 1e-9
    least: float = float(np.finfo(float).eps)
    most: int = 60
    enough: float = 0.3
    r_cell: float = 0.06


END = EndSettings()


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
        Of the least squares whose numbers are reported, in the fitted numbers.
    lost : bool
        Whether the motion multiplies errors so that the search could not follow it; `message` says how.
    """

    x: Floats
    mean_square: float
    evaluations: int
    success: bool
    message: str
    lost: bool = False
    result: "lmfit.minimizer.MinimizerResult | None" = None

    def losing(self, why: str) -> "Solution":
        """The same of a search that could not follow the motion."""
        return replace(self, success=False, lost=True, message=why)


def least_squares(
    problem: Problem,
    x: Floats,
    samples: Samples,
    ftol: float = 1e-7,
    jacobian: Floats | None = None,
    theta: Floats | None = None,
    reported: bool = False,
) -> Solution:
    """Least squares from a start; ftol is the relative change of the sum of squares at which it ends.

    `jacobian` and `theta` are the derivatives and the curve at the start, as `Problem` has them, where they
    are known. Numbers that are `reported` are found by `lmfit.Minimizer`.
    """
    evaluations = 0
    if len(x) == 1:
        found = _line_search(problem, x[0], samples)
        if not reported:
            return found
        x, evaluations, jacobian, theta = found.x, found.evaluations, None, None
    bounds, start, xtol = _within(problem, x)
    at = _AtLast(problem, samples, x, (jacobian, theta), ftol)
    if reported:
        names = [name for name, varies in zip(problem.names, problem.varied, strict=True) if varies]
        result = minimised(parameters_of(names, start, bounds), at.residual, at.jacobian, ftol, xtol)
        end, left = numbers_of(result), result.residual
    else:
        result = optimize.least_squares(
            at.residual,
            start,
            at.jacobian,
            bounds,
            x_scale="jac",
            ftol=ftol,
            xtol=max(xtol, END.least),
            gtol=END.least,
            max_nfev=END.most,
        )
        end, left = result.x, result.fun
    evaluations += result.nfev
    solution = Solution(at.whole(end), float(np.mean(left**2)), evaluations, result.success, result.message)
    return replace(solution, result=result) if reported else solution


def _within(problem: Problem, x: Floats) -> tuple[tuple[Floats, Floats], Floats, float]:
    """Of the numbers that vary bounds, a start within them, and the relative step at which a search ends."""
    low, high = np.array(problem.bounds())[problem.varied].T
    shorter = min(problem.stride, 1.0)
    inside = 1e-3 * shorter * (high - low)
    return (low, high), np.clip(x[problem.varied], low + inside, high - inside), END.xtol * shorter


class _AtLast:
    """Residual and derivatives by the numbers that vary, requested where the residual has just been: its
    curve is theirs, where it is exact enough. SciPy requires them once more after the step that ends the
    search, and does not use them: these are those of the step before."""

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

    def whole(self, moved: Floats) -> Floats:
        """All fitted numbers, of those that vary."""
        x = np.array(self.start, dtype=float)
        x[self.problem.varied] = moved
        return self.problem.consistent(x)

    def residual(self, moved: Floats) -> Floats:
        x = self.whole(moved)
        self.x, known = x, self.at_start[1]
        if known is not None and self.rate is None and np.array_equal(x, self.start):
            self.theta = known
        else:
            self.theta = self.problem.curve(x, self.samples, rate=self.rate)
        self.left = self.samples.averaged(self.theta - self.samples.theta)
        return self.left

    def jacobian(self, moved: Floats) -> Floats:
        known = None if self.before is None or not self._ends(moved, *self.before) else self.before[2]
        jacobian, varied = known, self.problem.varied
        if jacobian is None:
            jacobian = self._jacobian(self.whole(moved))
            jacobian = jacobian if varied.all() else jacobian[:, varied]
        self.before = moved.copy(), self.left, jacobian
        return jacobian

    def _ends(self, x: Floats, before: Floats, left: Floats, jacobian: Floats) -> bool:
        """Whether the search ends here: the step has gained little, and no less than was foretold."""
        change = jacobian @ (x - before)
        square = float(left @ left)
        gained, foretold = square - float(self.left @ self.left), -float(change @ (2 * left + change))
        return 0 < END.enough * foretold < gained < self.ftol * square

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
        half = END.r_cell * (1 - r)
        cell = max(low, r - half), min(high, r + half)
        found = optimize.minimize_scalar(error, bounds=cell, method="bounded", options={"xatol": 1e-6 * half})
        moved = abs(found.x - r) > 0.9 * half and low + 1e-6 < found.x < high - 1e-6
        r, evaluations = found.x, evaluations + found.nfev
    n = sum(n // samples.m for n in samples.lengths)
    return Solution(np.array([r]), found.fun / n, evaluations, found.success, found.message)


def minimised(
    parameters: lmfit.Parameters,
    residual: Callable[[Floats], Floats],
    jacobian: Callable[[Floats], Floats],
    ftol: float,
    xtol: float = END.xtol,
    most: int = END.most,
) -> "lmfit.minimizer.MinimizerResult":
    """Least squares by the trust region within bounds of `lmfit.Minimizer.least_squares`.

    Parameters
    ----------
    parameters : lmfit.Parameters
        Those that vary come in the order of the numbers that `residual` and `jacobian` take.
    residual, jacobian : callable
        Of the varied numbers, shape (n,): arrays of shapes (n_rows,) and (n_rows, n).
    ftol, xtol : float
        Relative change of the sum of squares, and relative step, at which the search ends.
    most : int
        Evaluations of the residual.

    Returns
    -------
    lmfit.minimizer.MinimizerResult
    """
    names = [name for name, each in parameters.items() if each.vary]

    def numbers(p: lmfit.Parameters) -> Floats:
        return np.array([p[name].value for name in names])

    minimizer = lmfit.Minimizer(lambda p: residual(numbers(p)), parameters)
    return minimizer.least_squares(
        jac=lambda p: jacobian(numbers(p)),
        x_scale="jac",
        ftol=max(ftol, END.least),
        xtol=max(xtol, END.least),
        gtol=END.least,
        max_nfev=most,
    )


def numbers_of(result: "lmfit.minimizer.MinimizerResult") -> Floats:
    """The varied numbers where a search ended, shape (n,)."""
    return np.array([result.params[name].value for name in result.var_names])


def parameters_of(names: Sequence[str], start: Floats, bounds: tuple[Floats, Floats]) -> lmfit.Parameters:
    """Numbers that a fit varies.

    Parameters
    ----------
    names : sequence of str
    start : ndarray, shape (n,)
    bounds : (ndarray, ndarray), each of shape (n,)
        Lower and upper ones.
    """
    parameters = lmfit.Parameters()
    low, high = bounds
    for i, name in enumerate(names):
        parameters.add(legal(name), value=float(start[i]), min=float(low[i]), max=float(high[i]))
    return parameters


def in_si_units(
    result: "lmfit.minimizer.MinimizerResult", problem: Problem, x: Floats, covariance: Floats
) -> "lmfit.minimizer.MinimizerResult":
    """A result of the fitted numbers as one of the parameters: names, values, bounds, ties, standard errors.

    Parameters
    ----------
    result : lmfit.minimizer.MinimizerResult
        Whose numbers are those of the problem that vary, then those of inputs.
    problem : Problem
    x : ndarray, shape (n_parameters,)
        All fitted numbers at their best.
    covariance : ndarray, shape (n_parameters, n_parameters)
        Of the parameters [SI]; NaN where they are not known.
    """
    result, n = copy(result), int(problem.varied.sum())
    start = np.array(x, dtype=float)
    start[problem.varied] = result.init_vals[:n]
    low, high = problem.limits
    given = [problem.given.get(name) for name in problem.names]
    parameters = in_words_of_lmfit(
        problem.names,
        problem.physical(x),
        (low, high),
        problem.varied,
        [each.expr if each else "" for each in given],
        problem.physical(problem.consistent(start)),
        covariance,
    )
    for name in result.var_names[n:]:
        moved = result.params[name]
        parameters.add(name, value=moved.value, min=moved.min, max=moved.max)
        parameters[name].init_value = moved.init_value
    result.params = parameters
    result.var_names = [name for name, each in parameters.items() if each.vary]
    result.init_vals = [parameters[name].init_value for name in result.var_names]
    result.init_values = dict(zip(result.var_names, result.init_vals, strict=True))
    result.covar = covariance[np.ix_(problem.varied, problem.varied)]
    result.errorbars = bool(np.isfinite(result.covar).all())
    return result


def in_words_of_lmfit(
    names: Sequence[str],
    values: Floats,
    bounds: tuple[Floats, Floats],
    varied: Mask,
    ties: Sequence[str],
    initial: Floats,
    covariance: Floats,
) -> lmfit.Parameters:
    """Parameters of a fit; those without a standard error have none.

    Parameters
    ----------
    names : sequence of str
    values, initial : ndarray, shape (n_parameters,)
        Where the least squares ended and where they began [SI].
    bounds : (ndarray, ndarray), each of shape (n_parameters,)
    varied : ndarray, shape (n_parameters,)
    ties : sequence of str
        Expressions; "" of a parameter that is not tied.
    covariance : ndarray, shape (n_parameters, n_parameters)

    Raises
    ------
    FreerockError
        A tie is no arithmetic of other parameters.
    """
    parameters, own = lmfit.Parameters(), [legal(name) for name in names]
    for name, value, low, high, varies in zip(own, values.tolist(), *bounds, varied.tolist(), strict=True):
        parameters.add(name, value=value, min=float(low), max=float(high), vary=varies)
    stderr = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(stderr, stderr)
    for name, tie in zip(own, ties, strict=True):
        if tie:
            parameters[name].set(expr=arithmetic(tie, tuple(other for other in own if other != name)))
    for i, name in enumerate(own):
        each, known = parameters[name], np.isfinite(stderr[i])
        each.init_value, each.user_value = float(initial[i]), float(initial[i])
        each.stderr = float(stderr[i]) if known and (varied[i] or ties[i]) else None
        among = [j for j in np.flatnonzero(varied) if j != i and np.isfinite(correlation[i, j])]
        each.correl = {own[j]: float(correlation[i, j]) for j in among} if varied[i] and among else None
    return parameters
