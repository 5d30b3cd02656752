"""lmfit's door: the least squares whose numbers are reported, on `lmfit.Parameters`."""

import keyword
from collections.abc import Callable, Sequence

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.identification.problem import Problem
from freerock.models.laws import parameter_of

XTOL = 1e-9  # relative step at which a search ends; less where the difference quotients' steps are less
LEAST = np.finfo(float).eps  # that SciPy takes
MOST = 60  # evaluations of the residual


def minimised(
    parameters: lmfit.Parameters,
    residual: Callable[[Floats], Floats],
    jacobian: Callable[[Floats], Floats],
    ftol: float,
    xtol: float = XTOL,
    most: int = MOST,
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
        ftol=max(ftol, LEAST),
        xtol=max(xtol, LEAST),
        gtol=None,
        max_nfev=most,
    )


def varied(result: "lmfit.minimizer.MinimizerResult") -> Floats:
    """The varied numbers where a search ended, shape (n,)."""
    return np.array([result.params[name].value for name in result.var_names])


def parameters_of(
    problem: Problem, x: Floats, bounds: Sequence[tuple[float, float]], inputs: Sequence[str] = ()
) -> lmfit.Parameters:
    """The numbers that a fit varies.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters + n_inputs,)
        Where the search starts.
    bounds : sequence of (float, float)
        Of each number.
    inputs : sequence of str
        Names of inputs that vary besides, in standard uncertainties.
    """
    parameters = lmfit.Parameters()
    fitted = [_fitted_name(problem, name) for name in problem.names]
    for name, value, (low, high) in zip([*fitted, *inputs], x.tolist(), bounds, strict=True):
        parameters.add(name, value=value, min=low, max=high)
    return parameters


def in_si_units(
    result: "lmfit.minimizer.MinimizerResult", problem: Problem, x: Floats
) -> "lmfit.minimizer.MinimizerResult":
    """A result that holds the parameters of a problem in SI units, too, where other numbers varied."""
    for name, value in zip(problem.names, problem.physical(x).tolist(), strict=True):
        if legal(name) not in result.params:
            result.params.add(legal(name), value=value, vary=False)
    return result


def legal(name: str) -> str:
    """A parameter's name as Python, and so lmfit, allows it: `lambda_` for lambda."""
    return f"{name}_" if keyword.iskeyword(name) else name


def _fitted_name(problem: Problem, name: str) -> str:
    """Name of the number that the optimiser moves."""
    kind = parameter_of(name).fitted_as
    return {"logarithm": f"ln_{name}", "ratio": f"ln_{name}_per_k", "share": f"{name}_share"}.get(kind, name)
