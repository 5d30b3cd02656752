"""What speaks for or against a fit: its held-out discrepancy, the damping it lacks, and why it may fail."""

import math
from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.discrepancy import epsilon_theta
from freerock.identification.intervals import Uncertainty
from freerock.identification.least_squares import Solution, least_squares
from freerock.identification.levels import ASKED, ASKED_EDGES
from freerock.identification.likelihood import Likelihood, Whitened
from freerock.identification.nuisances import Posterior
from freerock.identification.problem import Problem
from freerock.identification.pursuit import is_beyond, multiplies_errors
from freerock.identification.search import SEARCH, is_poor
from freerock.identification.settings import is_rounded
from freerock.identification.start import is_lively
from freerock.models.laws import PARAMETERS, extended_by, law_of


def first_half(
    problem: Problem, x: Floats, m: int, jacobian: Floats | None, theta: Floats
) -> tuple[Floats, float]:
    """Fitted numbers of the first half of a run, and ε_θ of its second half under them.

    ε_θ is NaN where the first half has too few samples.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    m : int
        Samples averaged into one.
    jacobian : ndarray, shape (n_samples, n_parameters), or None
        `Problem.jacobian` there, of all samples, where it is known.
    theta : ndarray, shape (n_samples,)
        `Problem.curve` there [rad].
    """
    motion = problem.motions[0]
    half = motion.time_s[-1] / 2
    samples = problem.samples(half, m=m)
    if sum(samples.lengths) <= 2 * m * len(x):
        return x, float("nan")
    known = None if jacobian is None else jacobian[: len(samples.theta)]
    x = least_squares(problem, x, samples, jacobian=known, theta=theta[: len(samples.theta)]).x
    later = motion.time_s > half
    theta = problem.motion(x, 0, motion.time_s)
    return x, epsilon_theta(motion.time_s[later], theta[later], motion.theta[later])


def added_damping(
    problem: Problem, x: Floats, exact: Floats, linear: Whitened, without: Likelihood
) -> float | None:
    """How many standard errors the damping that the law lacks would be away from zero.

    By the ratio of likelihoods under the noise at rest, with the derivative by that damping: its root, which
    is negative where the damping would have to drive the block. None where the law lacks no damping, where
    debonding is not worked out for two, and of a motion that multiplies errors (`pursuit`).

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    exact : ndarray, shape (n_samples,)
        The first of `Problem.exact_curve` there.
    linear : Whitened
        Residual and derivatives there, of all samples; without those by parameters held at a bound.
    without : Likelihood
        Of these.
    """
    wider = extended_by(problem.model)
    if wider is None:
        return None
    (model, other), samples = wider, problem.samples()
    if problem.directions is not None or not law_of(model).allows(
        problem.settings.debonding, len(law_of(model).dampings)
    ):
        return None
    # the trough of the misfit is bent: a larger trace gives no derivative
    trace = 1e-3 * PARAMETERS[other].trace * problem.physical(x)[0]
    column = problem.curve(x, samples, problem.exact_rtol, {other: trace}) - exact
    found = linear.adding(column)
    gain = max(without.minus_two_log - found.minus_two_log, 0.0)
    return float(np.copysign(np.sqrt(gain), found.step[-1]))


def asks_for(best: Posterior) -> tuple[str, ...]:
    """What a fit takes for granted, and the data ask to be found: "release", "tilt", "edges", "width".

    What they ask for most comes first. By the ratio of likelihoods under the noise at rest, with the
    derivative by the tilt of the base or by the contact width, with what edges of a small radius would
    change, or with a free release, beside those by all that the fit frees and by its inputs. A width asks
    from where its gain is what the BIC charges for a number: worn corners are common.

    Parameters
    ----------
    best : Posterior
        Of one run, at the tolerance of the fit.
    """
    charged = math.sqrt(math.log(best.whitened.likelihood().effective))
    off, least = off_zero(best), {"edges": ASKED_EDGES, "width": charged}
    asked = [name for name in off if abs(off[name]) > least.get(name, ASKED)]
    return tuple(sorted(asked, key=lambda name: -abs(off[name])))


def off_zero(best: Posterior, edge_m: float = 3e-5) -> dict[str, float]:
    """By how many standard errors what `asks_for` may name would be off zero, with its sign.

    Edges only where they would be rounded, by the difference quotient of a radius: what they do grows with
    its square. Nothing of a motion that multiplies errors (`pursuit`): these are no derivatives there.
    """
    problem, x = best.problem, best.x
    if multiplies_errors(problem, x):
        return {}

    def beside(value: float, name: str) -> Floats:
        return problem.curve(x, best.own, problem.exact_rtol, {name: value})

    def slope(name: str, at: float, step: float) -> Floats:
        return (beside(at + step, name) - beside(at - step, name)) / (2 * step)

    found, (value, rows) = dict[str, Likelihood](), best.prior
    of_release = len(value) - len(best.z)
    if of_release:
        found["release"] = best.beside((value[of_release:], rows[of_release:])).likelihood()
    elif not (best.free.all() or problem.settings.loose_release):
        held = Whitened(best.residual, best.jacobian, best.samples.lengths, [problem.motions[0].noise])
        found["release"] = held.likelihood()
    if "tilt" not in problem.names:
        found["tilt"] = best.whitened.adding(slope("tilt", 0.0, PARAMETERS["tilt"].step))
    if "width" not in problem.names:
        width = 2 * problem.blocks[0].b
        found["width"] = best.whitened.adding(slope("width", width, width * PARAMETERS["width"].step))
    if "edge_radius" not in problem.names and is_rounded(problem.model, problem.settings.debonding):
        edges = best.whitened.adding(beside(edge_m, "edge_radius") - best.curve)
        if edges.step[-1] > 0:
            found["edges"] = edges
    without = best.whitened.likelihood().minus_two_log
    gain = {name: max(without - each.minus_two_log, 0.0) for name, each in found.items()}
    return {name: float(np.copysign(np.sqrt(gain[name]), found[name].step[-1])) for name in found}


def blur_of(best: Posterior, blur_s: float = 5e-4) -> tuple[float, float]:
    """How much slower the sensor is than stated, as a fit has it that takes its response for known.

    A mean over a time T about each sample adds T² θ̈/24; the derivative by T² is that of a mean of three
    samples, and as in `off_zero` the ratio of likelihoods is one of linear models.

    Parameters
    ----------
    best : Posterior
        As of `asks_for`.
    blur_s : float
        Step of the difference quotient [s].

    Returns
    -------
    off_zero : float
        By how many standard errors T² is above zero; negative where the sensor would be faster.
    averaging_s : float
        T [s]; 0 where it would be negative.
    """
    problem, x, own = best.problem, best.x, best.own
    beside = [
        problem.curve(x, replace(own, time_s=own.time_s + shift_s), problem.exact_rtol)
        for shift_s in (blur_s, -blur_s)
    ]
    slower = best.whitened.adding((sum(beside) - 2 * best.curve) / (24 * blur_s**2))
    gain = best.whitened.likelihood().minus_two_log - slower.minus_two_log
    step = float(slower.step[-1])
    return float(np.copysign(np.sqrt(max(gain, 0.0)), step)), float(np.sqrt(max(step, 0.0)))


def failure(problem: Problem, solution: Solution, known: Uncertainty, epsilon: float) -> str:
    """Why the fit is not to be used; "" when it is. A nuisance of a run held at its bound is no failure."""
    n_common = len(problem.common)
    if not solution.success:
        return f"not converged: {solution.message}"
    for name, pinned in zip(problem.common, problem.at_bound(solution.x), strict=False):
        if pinned:
            given = " of fits.parameters" if name in problem.given else ""
            return f"{name} lies at its bound{given}"
    if not np.all(np.isfinite(np.diag(known.covariance)[:n_common])):
        return "the data do not determine the parameters"
    if (
        len(problem.motions) == 1
        and is_lively(problem, solution.x)
        and is_poor(problem, solution.mean_square / SEARCH.left**2)
    ):
        return "the block is hardly damped and more than noise is left: possibly another minimum"
    if is_beyond(problem):
        return "the block is hardly damped and multiplies errors beyond precision: possibly another minimum"
    if epsilon >= 1:
        return "worse than a block at rest (ε_θ ≥ 1)"
    return ""
