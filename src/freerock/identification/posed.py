"""The least-squares problem of one run, carried by `lmfit.Minimizer` from start to end.

    S = |r|²/s² + Σ ((ν - ν⁰)/u)² + Σ (δ/σ_r)²,    r = θ_model - θ_measured,

s the standard deviation of the noise, ν the inputs and the release with what is known of them, δ the scatter
of the impacts. Priors are rows of the residual beside the samples.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.run_model import RTOL, Point, RunModel
from freerock.identification.samples import Samples
from freerock.models.free_parameters import PARAMETERS
from freerock.models.given import Given, arithmetic, legal
from freerock.models.laws import law_of
from freerock.runs.release import FAR, lowered

# Standard uncertainties that an input moves before derivatives by inputs are taken anew. Set on a realistic
# record and one of Palermo: with 0.2 their searches stalled at the minimum.
RENEWED = 0.01
FARTHEST_INPUT = 8.0  # standard uncertainties: a law that needs more is rejected by its pull
ROUGH = 5e-3  # relative change of the objective, above which a search is a rough one
# Of the rate after an impact over that before it where a search began, less one. Within a half to one and a
# half, Winkler's law on the record `damping_by_depth` left 14 times the noise, where 1.4 is its least.
RATE_CHANGE = (-0.9, 4.0)
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class ReleaseLimits:
    """Least uncertainty of a measured release, and that of one that is free.

    Parameters
    ----------
    least_share, least_s : float
        Of the angle, as a share of it, and of the instant [s]: a finger is no point.
    loose_share, loose_s : float
        The same of a release that is freed: a push, or a slow finger.
    """

    least_share: float = 3e-4
    least_s: float = 1.7e-4
    loose_share: float = FAR
    loose_s: float = 0.05


RELEASE = ReleaseLimits()


def release_prior(model: RunModel) -> dict[str, tuple[float, float]]:
    """What is measured of the release: value and standard uncertainty of theta0 [rad] and t0 [s]."""
    motion, block = model.motion, model.block
    u_theta0 = max(motion.theta0_stderr, RELEASE.least_share * abs(motion.theta0))
    u_t0 = max(motion.t0_stderr, RELEASE.least_s)
    # a finger that fades lowers the top
    fall = block.p**2 * float(np.sin(block.theta_cr - abs(motion.theta0)))
    u_theta0 = float(np.hypot(u_theta0, lowered(fall, motion.fit_start_s)))
    if "release" in model.settings.free:
        u_theta0, u_t0 = RELEASE.loose_share * abs(motion.theta0), RELEASE.loose_s
    return {"theta0": (motion.theta0, u_theta0), "t0": (0.0, u_t0)}


def bounds_of(model: RunModel, name: str) -> tuple[float, float]:
    """Bounds of a number [SI]; those of a damping hold its ratio to k for any k."""
    if name == "theta0":
        near = 2 * RELEASE.loose_share * abs(model.motion.theta0)
        return model.motion.theta0 - near, model.motion.theta0 + near
    if name == "t0":
        return -2 * RELEASE.loose_s, 2 * RELEASE.loose_s
    low, high = PARAMETERS[name].bounds
    if PARAMETERS[name].fitted_as == "ratio":
        return low * PARAMETERS["k"].bounds[0], high * PARAMETERS["k"].bounds[1]
    if PARAMETERS[name].fitted_as == "share":
        return low * model.block.width_m, high * model.block.width_m
    return low, high


@dataclass(frozen=True, eq=False)
class Posed:
    """What is minimised.

    Parameters
    ----------
    model : RunModel
    samples : Samples
    sigma_r : float
        Prior standard deviation of δ; without impacts any number will do.
    level : float
        s, standard deviation of a sample [rad].
    rtol : float
        Of the integrator.
    walls : float
        Where it is not 0, the release lies within so many of its standard uncertainties, instead of a prior.
    """

    model: RunModel
    samples: Samples
    sigma_r: float
    level: float
    rtol: float = RTOL
    walls: float = 0.0

    @cached_property
    def release(self) -> list[tuple[str, float, float]]:
        """Priors of the release: name, value, standard uncertainty."""
        prior = {} if self.walls else release_prior(self.model)
        return [(name, *prior[name]) for name in self.model.names if name in prior]

    def parameters(self, at: Point) -> lmfit.Parameters:
        """What lmfit varies, from a start: numbers of the law and release, inputs, impacts."""
        found, given = lmfit.Parameters(), self.model.settings.given(self.model.candidate)
        own = law_of(self.model.candidate).parameters
        for name in self.model.names:
            low, high = bounds_of(self.model, name)
            if self.walls and name in ("theta0", "t0"):
                centre, u = release_prior(self.model)[name]
                low, high = centre - self.walls * u, centre + self.walls * u
            each = given.get(name, Given())
            low = low if each.min is None else max(low, each.min)
            high = high if each.max is None else min(high, each.max)
            vary = each.vary and not each.expr
            value = at.values[name] if vary or each.value is None else each.value
            inside = 1e-6 * min(high - low, abs(value) + EPS) if vary else 0.0
            value = float(np.clip(value, low + inside, high - inside)) if vary else value
            found.add(legal(name), value=value, min=low, max=high, vary=vary)
        for name in own:
            if given.get(name, Given()).expr:
                others = tuple(other for other in own if other != name)
                tied_to = found[legal(name)]
                low, high = tied_to.min, tied_to.max
                tied_to.set(expr=arithmetic(given[name].expr, others), min=-np.inf, max=np.inf)
                if not low <= tied_to.value <= high:
                    what = f"{name} is tied to {tied_to.value:g}, where no motion is"
                    raise FreerockError("fits", what, "correct the expr of fits.parameters")
        for j, source in enumerate(self.model.inputs):
            far = FARTHEST_INPUT
            value = float(np.clip(at.inputs[j], -0.99 * far, 0.99 * far))  # "dogbox" does not leave a bound
            found.add(f"input_{j + 1}_{source.name}", value=value, min=-far, max=far)
        for i, value in enumerate(at.impacts.tolist()):
            found.add(f"impact_{i + 1}", value=value, min=RATE_CHANGE[0], max=RATE_CHANGE[1])
        return found

    def point(self, parameters: lmfit.Parameters, before: Floats | None = None) -> Point:
        """The point at lmfit's parameters; given rates before impacts [rad/s], it holds those after them."""
        value, names = [each.value for each in parameters.values()], self.model.names
        n, n_z = len(names), len(self.model.inputs)
        impacts = np.array(value[n + n_z :])
        rates = None if before is None else (1 + impacts) * before
        return Point(dict(zip(names, value, strict=False)), np.array(value[n : n + n_z]), impacts, rates)

    def residual(self, at: Point, theta: Floats | None = None) -> Floats:
        """Rows of the objective: samples, release, inputs, impacts."""
        theta = self.model.means(at, self.samples, self.rtol) if theta is None else theta
        left = (theta - self.samples.measured) / self.level
        release = [(at.values[name] - value) / u for name, value, u in self.release]
        impacts = at.impacts if at.rates is None else self.model.here(at, self.samples, self.rtol).impacts
        return np.concatenate([left, release, at.inputs, impacts / self.sigma_r])

    def jacobian(self, at: Point, by_inputs: Floats) -> Floats:
        """Derivatives of `residual` by all numbers, inputs and impacts, shape (n_rows, n_all).

        By the logarithms of the rates after impacts where the point holds these, else by δ.
        """
        columns = self.model.derivatives(at, self.samples, self.rtol)
        n, n_z, n_theta = len(self.model.names), len(at.inputs), self.samples.measured.size
        first = n_theta + len(self.release)  # row of the inputs
        rows = np.zeros((first + n_z + len(at.impacts), n + n_z + len(at.impacts)), order="F")
        begin = 0
        for found in (columns[:, :n], by_inputs, columns[:, n:]):
            own = slice(begin, begin + found.shape[1])
            rows[:n_theta, own] = found[:n_theta] / self.level
            rows[first + n_z :, own] = found[n_theta:] / self.sigma_r
            begin = own.stop
        for row, (name, _, u) in enumerate(self.release):
            rows[n_theta + row, self.model.names.index(name)] = 1 / u
        rows[first : first + n_z, n : n + n_z] = np.eye(n_z)
        if at.rates is None:
            n, of_delta = n + n_z, self.sigma_r * rows[first + n_z :]
            rows[:, n:] = np.linalg.solve(of_delta[:, n:].T, rows[:, n:].T).T
            rows[:, :n] -= rows[:, n:] @ of_delta[:, :n]
        return rows


@dataclass(frozen=True, eq=False)
class Ended:
    """Where a least-squares search ended.

    Parameters
    ----------
    posed : Posed
    at : Point
    result : lmfit.minimizer.MinimizerResult
    minimizer : lmfit.Minimizer
        That found it; a user can go on with both.
    """

    posed: Posed
    at: Point
    result: "lmfit.minimizer.MinimizerResult"
    minimizer: lmfit.Minimizer

    @property
    def mean_square(self) -> float:
        """Mean square of the samples' residual over their level, with what the priors add to it."""
        return float(self.result.chisqr) / self.posed.samples.measured.size

    @property
    def over_noise(self) -> float:
        """As `mean_square`, over the noise of a sample instead of the level."""
        return self.mean_square * (self.posed.level / self.posed.model.sigma) ** 2


class _Objective:
    """What lmfit calls; derivatives by the inputs are renewed where these have moved, if they are to be.

    What lmfit has for δ of an impact is the rate after it, over that before it where the search began, less
    one. With rates the sum of squares is nearly quadratic; with δ it has a long curved valley.
    """

    def __init__(self, posed: Posed, begun: Point, renews: bool) -> None:
        self.posed, self.renews, self.inputs = posed, renews, begun.inputs
        held = posed.model.held(begun, posed.samples, posed.rtol)
        self.before = held.passages[:, 4] / (1 + held.impacts)  # rates before the impacts
        self.by_inputs = posed.model.by_inputs(begun, posed.samples, posed.rtol)

    def residual(self, moved: lmfit.Parameters) -> Floats:
        """As `Posed.residual`; a block that can't be, as one of no inertia, lies overturned."""
        at = self.posed.point(moved, self.before)
        try:
            return self.posed.residual(at)
        except FreerockError:
            fallen = np.full(self.posed.samples.measured.size, np.pi / 2)
            return self.posed.residual(replace(at, rates=None), fallen)

    def jacobian(self, moved: lmfit.Parameters) -> Floats:
        """Derivatives by the parameters that vary."""
        at, posed = self.posed.point(moved, self.before), self.posed
        if self.renews and np.max(np.abs(at.inputs - self.inputs), initial=0.0) > RENEWED:
            self.inputs, self.by_inputs = at.inputs, posed.model.by_inputs(at, posed.samples, posed.rtol)
        rows = posed.jacobian(at, self.by_inputs)
        varied = [i for i, each in enumerate(moved.values()) if each.vary]
        is_tied = any(each.expr for each in moved.values())
        found = rows @ tied(moved, varied) if is_tied else rows[:, varied]
        found[:, len(varied) - at.impacts.size :] /= 1 + at.impacts
        return found


def minimised(
    posed: Posed, start: Point, most: int = 60, ftol: float = 1e-7, method: str = "dogbox"
) -> Ended:
    """The end of `lmfit.Minimizer.least_squares` with our derivatives.

    Parameters
    ----------
    posed : Posed
    start : Point
    most : int
        Evaluations of the residual.
    ftol : float
        Relative change of the objective at which it ends.
    method : str
        Of `scipy.optimize.least_squares`. Bounds slow "trf" down where priors hold most numbers.

    Raises
    ------
    FreerockError
        The search met parameters that no motion has.
    """
    parameters = posed.parameters(start)
    objective = _Objective(posed, posed.point(parameters), renews=ftol < ROUGH)
    minimizer = lmfit.Minimizer(objective.residual, parameters, scale_covar=False, Dfun=objective.jacobian)
    minimizer.kws["max_nfev"] = most  # SciPy ends at its best point, lmfit's own limit at an untried one
    try:
        result = minimizer.least_squares(method=method, x_scale="jac", ftol=ftol, xtol=EPS, gtol=EPS)
    except ValueError as error:  # lmfit's answer to a residual that is no number
        what = "a fit met parameters that no motion has"
        raise FreerockError("fits", what, "correct values, bounds and ties of fits.parameters") from error
    held = posed.model.held(posed.point(result.params, objective.before), posed.samples, posed.rtol)
    del minimizer.kws["max_nfev"]
    objective.before = held.passages[:, 4] / (1 + held.impacts)  # so that at the end the parameters are δ
    for i, value in enumerate(held.impacts.tolist()):
        impact = result.params[f"impact_{i + 1}"]
        if not RATE_CHANGE[0] < value < RATE_CHANGE[1]:  # the search bounds what rates change from its start
            impact.set(min=(value - 1) / 2, max=2 * abs(value))
        impact.value = value
    at = replace(held, rates=None)
    return Ended(posed, at, result, minimizer)


def tied(parameters: lmfit.Parameters, varied: list[int]) -> Floats:
    """Derivatives of all parameters by those that vary, where some are tied to others."""
    each = list(parameters.values())
    found = np.zeros((len(each), len(varied)))
    for j, i in enumerate(varied):
        value, step = each[i].value, 1e-6 * max(abs(each[i].value), 1e-6)
        ends = []
        for moved in (value + step, value - step):
            each[i].set(value=moved)
            parameters.update_constraints()
            ends.append(np.array([one.value for one in each]))
        each[i].set(value=value)
        parameters.update_constraints()
        found[:, j] = (ends[0] - ends[1]) / (2 * step)
    return found
