"""Model parameters from measured θ(t): a scan for the start, growing horizons, then least squares.

The objective is the paper's: the mean square error between measured and modelled θ(t)
(Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import lmfit
import numpy as np
from scipy.ndimage import minimum_filter
from scipy.signal import fftconvolve

from freerock.compare import epsilon_theta
from freerock.errors import FreerockError
from freerock.impacts import Impacts
from freerock.models import MODELS, UNITS
from freerock.models.block import Block
from freerock.models.housner import housner_lobes
from freerock.models.limits import K_RANGE, RATIO_RANGE
from freerock.models.simulate import simulate_theta

NUISANCES = ("theta0", "t0")
NORMAL_95 = 1.959963984540054

# Positive parameters are fitted as logarithms, damping as its ratio to k, within `models.limits`.
# Starting grid: stiffness [N/m²] by damping ratio c/k [s] or λ/k [s/m].
K_GRID = np.geomspace(3e5, 1e9, 16)
RATIO_GRID = {"c": np.geomspace(5e-4, 0.08, 8), "lambda": np.geomspace(2, 200, 8)}
R_GRID = 1 - np.geomspace(1e-4, 0.95, 170)
R_CELL = 0.06  # spacing of the grid relative to 1 - r
SCAN_SAMPLES, GROWTH_SAMPLES, FINE_SAMPLES = 250, 1000, 3000  # per run, before the last fit to all of them
SCAN, COARSE, FINE = 1e-4, 1e-6, 1e-8  # integrator's rtol: of the scan, of growing horizons, of the last fit
CANDIDATES = 3
PROMISING = 5.0  # candidates whose mean square error is within this factor of the best one are followed on


@dataclass(frozen=True)
class Motion:
    """One measured free-rocking run, as the fits take it.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Time since the measured release [s].
    theta : ndarray, shape (n_time,)
        Measured rotation [rad]; NaN where a sample is flagged.
    sigma_theta : float
        Standard deviation of the noise of theta [rad].
    theta0, theta0_stderr : float
        Held angle before the release and its standard error [rad].
    t0_stderr : float
        Standard error of the measured release [s].
    start_s : float
        First instant that counts, after the finger has left the block [s since the release].
    """

    time_s: np.ndarray
    theta: np.ndarray
    sigma_theta: float
    theta0: float
    theta0_stderr: float = 0.0
    t0_stderr: float = 0.0
    start_s: float = 0.0


@dataclass(frozen=True)
class Fit:
    """Identified parameters of one model on one run, or on several runs jointly.

    Parameters
    ----------
    model : str
        One of "housner", "winkler", "hunt_crossley".
    parameters : tuple of str
        Model parameters, then the freed nuisances (theta0, t0; numbered by run in a joint fit).
    value, stderr, ci95_low, ci95_high : ndarray, shape (n_parameters,)
        In the unit of each parameter; NaN where the data do not determine it.
    covariance : ndarray, shape (n_parameters, n_parameters)
        In the product of the parameters' units.
    units : tuple of str
        Unit of each parameter.
    time, theta, theta_model, residual : ndarray, shape (n_time,)
        Time since release [s], measured and modelled rotation and their difference
        (model minus measured) [rad]; the runs of a joint fit one after the other.
    epsilon_theta : float
        ε_θ as a fraction, up to `final_time_s` [s].
    epsilon_holdout : float
        ε_θ of the second half of the run under the parameters fitted to the first half.
    aic, bic : float
        Information criteria of the least-squares fit.
    n_parameters : int
        Number of freed parameters.
    success : bool
        False where the fit is not to be used; `message` says why.
    impacts : Impacts or None
        Impacts of the modelled motion, found by the estimator of the measured one.
    diagnostics : dict
        evaluations, rtol, integrator_error (share of σ_θ), residual_over_sigma,
        coloured (1 where the residual is not white and the standard errors are widened for it).
    """

    model: str
    parameters: tuple
    value: np.ndarray
    stderr: np.ndarray
    ci95_low: np.ndarray
    ci95_high: np.ndarray
    covariance: np.ndarray
    units: tuple
    time: np.ndarray
    theta: np.ndarray
    theta_model: np.ndarray
    residual: np.ndarray
    epsilon_theta: float
    final_time_s: float
    epsilon_holdout: float
    aic: float
    bic: float
    n_parameters: int
    success: bool
    message: str
    impacts: Impacts | None = None
    diagnostics: dict = field(default_factory=dict)


def fit_run(
    model: str,
    block: Block,
    motion: Motion,
    *,
    free: Sequence[str] = NUISANCES,
    debonding: str = "geometric",
    integrator_error: float = 0.01,
) -> Fit:
    """Identify a model on one run.

    A scan over a grid gives starts on the first swings; each is followed over growing horizons to
    the whole run with `lmfit`; the best end wins. The integrator's tolerance is tightened until its
    error is below `integrator_error` times the noise.

    Parameters
    ----------
    model : str
        One of "housner", "winkler", "hunt_crossley".
    block : Block
        The block.
    motion : Motion
        The measured run.
    free : sequence of str
        Nuisances fitted besides the model's parameters: "theta0", "t0", both or none.
    debonding : str
        "geometric" or "tensionless".
    integrator_error : float
        Largest error of the integrator as a share of σ_θ.

    Returns
    -------
    Fit

    Raises
    ------
    FreerockError
        Unknown model or nuisance; fewer valid samples than parameters.
    """
    return fit_record(
        model, block, [motion], free=free, debonding=debonding, integrator_error=integrator_error
    )


def fit_record(
    model: str,
    block: Block,
    motions: Sequence[Motion],
    *,
    start: Sequence[float] | None = None,
    free: Sequence[str] = NUISANCES,
    debonding: str = "geometric",
    integrator_error: float = 0.01,
) -> Fit:
    """Identify a model on several runs of one block jointly: one set of parameters, nuisances per run.

    `motions` is a sequence of Motion; `start` are the model's parameters to start from [SI], by default
    those that a scan finds on the first run. All else, and the errors, as in `fit_run`.
    """
    if model not in MODELS:
        raise FreerockError("fits.models", f"unknown model {model!r}", f"use one of {', '.join(MODELS)}")
    unknown = set(free) - set(NUISANCES)
    if unknown:
        raise FreerockError(
            f"fits.free.{model}", f"unknown nuisance {min(unknown)!r}", f"use {' or '.join(NUISANCES)}"
        )
    problem = _Problem(model, block, tuple(motions), tuple(n for n in NUISANCES if n in free), debonding)
    if len(problem.samples(np.inf)[0]) <= len(problem.names):
        raise FreerockError(
            "fit", "fewer valid samples than parameters", "exclude the run or widen it by an override"
        )
    problem, result, holdout = _minimise(problem, start, integrator_error)
    return _fit(problem, result, holdout)


@dataclass(frozen=True)
class _Problem:
    model: str
    block: Block
    motions: tuple
    free: tuple
    debonding: str
    rtol: float = COARSE

    @property
    def names(self) -> tuple:
        numbered = [
            name if len(self.motions) == 1 else f"{name}_{i}"
            for i in range(1, len(self.motions) + 1)
            for name in self.free
        ]
        return (*MODELS[self.model], *numbered)

    def physical(self, x) -> np.ndarray:
        """Parameters in SI units from the fitted ones (logarithms of k and of the ratio damping/k)."""
        value = np.array(x, dtype=float)
        if self.model != "housner":
            value[0] = np.exp(x[0])
            value[1] = np.exp(x[0] + x[1])
        return value

    def fitted(self, values) -> list:
        """The model's fitted parameters from those in SI units, the inverse of `physical`."""
        if self.model == "housner":
            return list(values)
        return [np.log(values[0]), np.log(values[1] / values[0])]

    def alone(self) -> "_Problem":
        """The same problem on the first run only."""
        return replace(self, motions=self.motions[:1])

    def theta(self, x, i: int, time_s, rtol: float | None = None) -> np.ndarray:
        """θ of run i at the measured run's clock [rad]; an overturned block lies at ±π/2."""
        motion, value = self.motions[i], self.physical(x)
        n_model, n_free = len(MODELS[self.model]), len(self.free)
        nuisance = dict(zip(self.free, value[n_model + i * n_free :], strict=False))
        theta0 = nuisance.get("theta0", motion.theta0)
        theta, _ = simulate_theta(
            self.model,
            self.block,
            dict(zip(MODELS[self.model], value[:n_model], strict=True)),
            time_s - nuisance.get("t0", 0.0),
            theta0=theta0,
            debonding=self.debonding,
            rtol=rtol or self.rtol,
        )
        return np.where(np.isnan(theta), np.copysign(np.pi / 2, theta0), theta)

    def samples(self, horizon_s: float, most: float = np.inf):
        """Times [s] and θ [rad] that count up to the horizon, and their number per run; thinned to `most`."""
        times, thetas = [], []
        for motion in self.motions:
            counts = np.isfinite(motion.theta) & (motion.time_s >= motion.start_s)
            index = np.flatnonzero(counts & (motion.time_s <= horizon_s))
            index = index[:: max(1, int(len(index) // most))]
            times.append(motion.time_s[index])
            thetas.append(motion.theta[index])
        return np.concatenate(times), np.concatenate(thetas), [len(t) for t in times]

    def residual(self, x, time_s, theta, lengths) -> np.ndarray:
        ends = np.cumsum(lengths)
        modelled = [
            self.theta(x, i, time_s[end - n : end])
            for i, (n, end) in enumerate(zip(lengths, ends, strict=True))
        ]
        return np.concatenate(modelled) - theta

    def jacobian(self, x, time_s, theta, lengths, central: bool = False) -> np.ndarray:
        """Difference quotients of the residual, shape (n_samples, n_parameters)."""
        n_model, n_free = len(MODELS[self.model]), len(self.free)
        jac = np.zeros((len(time_s), len(x)))
        end = 0
        for i, n in enumerate(lengths):
            start, end = end, end + n
            base = None if central else self.theta(x, i, time_s[start:end])
            own = range(n_model + i * n_free, n_model + (i + 1) * n_free)
            for j in [*range(n_model), *own]:
                step = self.steps[j]
                up = np.array(x, dtype=float)
                up[j] += step
                above = self.theta(up, i, time_s[start:end])
                if central:
                    up[j] -= 2 * step
                    jac[start:end, j] = (above - self.theta(up, i, time_s[start:end])) / (2 * step)
                else:
                    jac[start:end, j] = (above - base) / step
        return jac

    @property
    def steps(self) -> list:
        model = [-1e-5] if self.model == "housner" else [1e-5, 1e-5] if self.rtol <= FINE else [1e-4, 1e-3]
        nuisance = {"theta0": 1e-6, "t0": 1e-5}
        return model + [nuisance[name] for _ in self.motions for name in self.free]

    @cached_property
    def r_min(self) -> float:
        """Least r with which the rigid block rocks for half the measured time.

        Where the rigid block's period is wrong, a block that stops at once has a lower mean square error
        than one that rocks out of step; these false minima are shut out.
        """
        motion = self.motions[0]
        moves = np.abs(motion.theta) > 10 * motion.sigma_theta
        half = motion.time_s[moves][-1] / 2 if moves.any() else 0.0
        rocks = [
            r for r in R_GRID if housner_lobes(self.block, r, motion.theta0, until=half).rest_time > half
        ]
        return min(rocks, default=R_GRID[0])

    def bounds(self) -> list:
        if self.model == "housner":
            limits = [(self.r_min, R_GRID[0])]
        else:
            damping = MODELS[self.model][1]
            limits = [tuple(np.log(K_RANGE)), tuple(np.log(RATIO_RANGE[damping]))]
        for motion in self.motions:
            half = {
                "theta0": max(6 * motion.theta0_stderr, 0.002 * abs(motion.theta0)),
                "t0": max(6 * motion.t0_stderr, 1e-3),
            }
            centre = {"theta0": motion.theta0, "t0": 0.0}
            limits += [(centre[name] - half[name], centre[name] + half[name]) for name in self.free]
        return limits

    def start(self, model_values) -> np.ndarray:
        nuisance = {"theta0": lambda m: m.theta0, "t0": lambda m: 0.0}
        return np.array([*model_values, *(nuisance[n](m) for m in self.motions for n in self.free)])


def _minimise(problem: _Problem, start, integrator_error: float):
    """Best end of the candidates over growing horizons, at a tolerance the noise asks for."""
    horizons = _horizons(problem.motions[0])
    if start is None:
        starts = _scan(problem.alone(), horizons[0])
    else:
        starts, horizons = [problem.fitted(start)], horizons[-2:]
    if problem.model == "housner":
        horizons = horizons[-1:]  # already scanned on the whole run
    tracks = [_grow(problem, problem.start(values), horizons[:1]) for values in starts]
    promising = PROMISING * min(error for error, _ in tracks)
    tracks = [_grow(problem, x, horizons[1:], error) for error, x in tracks if error <= promising]
    x = min(tracks, key=lambda track: track[0])[1]

    problem = replace(problem, rtol=FINE)
    x = _least_squares(problem, x, np.inf, FINE_SAMPLES).x
    while _integration_error(problem, x) > integrator_error * _sigma(problem) and problem.rtol > 1e-12:
        problem = replace(problem, rtol=problem.rtol / 10)
    holdout = _holdout(problem, x) if len(problem.motions) == 1 else float("nan")
    return problem, _least_squares(problem, x, np.inf), holdout


def _grow(problem: _Problem, x, horizons, error: float = np.inf) -> tuple:
    """Mean square error [rad²] and fitted parameters after least squares over each horizon in turn."""
    for horizon in horizons:
        result = _least_squares(problem, x, horizon, GROWTH_SAMPLES, ftol=1e-3)
        x, error = result.x, result.chisqr / result.ndata
    return error, x


def _horizons(motion: Motion) -> list:
    """Growing spans [s]: the first two swings, then doubled up to the whole run."""
    theta = motion.theta[np.isfinite(motion.theta)]
    time_s = motion.time_s[np.isfinite(motion.theta)]
    crossings = time_s[1:][np.signbit(theta[1:]) != np.signbit(theta[:-1])]
    first = crossings[0] if len(crossings) else time_s[-1] / 8
    spans = [3.0 * first]
    while spans[-1] < time_s[-1]:
        spans.append(2 * spans[-1])
    return spans


def _scan(problem: _Problem, horizon_s: float) -> list:
    """Starting values of the model's parameters: lowest local minima of the error over the model's grid.

    Housner's r: the lowest minimum inside the range. At its lower end the error may fall further, as the
    block that stops early is out of step for less time.
    """
    if problem.model == "housner":
        samples = problem.samples(np.inf, GROWTH_SAMPLES)
        grid = [r for r in R_GRID if r >= problem.r_min]
        errors = np.array([np.mean(problem.residual(problem.start([r]), *samples) ** 2) for r in grid])
        inside = np.flatnonzero((errors[1:-1] <= errors[:-2]) & (errors[1:-1] <= errors[2:])) + 1
        best = inside[np.argmin(errors[inside])] if len(inside) else np.argmin(errors)
        return [[grid[best]]]
    samples = problem.samples(horizon_s, SCAN_SAMPLES)
    coarse = replace(problem, rtol=SCAN)
    ratios = RATIO_GRID[MODELS[problem.model][1]]
    errors = np.array(
        [
            [
                np.mean(coarse.residual(problem.start([np.log(k), np.log(ratio)]), *samples) ** 2)
                for ratio in ratios
            ]
            for k in K_GRID
        ]
    )
    minima = np.argwhere(errors == minimum_filter(errors, size=3, mode="nearest"))
    minima = sorted(minima.tolist(), key=lambda ij: errors[tuple(ij)])[:CANDIDATES]
    return [[np.log(K_GRID[i]), np.log(ratios[j])] for i, j in minima]


def _least_squares(problem: _Problem, x, horizon_s: float, most: float = np.inf, ftol: float = 1e-7):
    samples = problem.samples(horizon_s, most)
    names = [f"x{i}" for i in range(len(x))]
    parameters = lmfit.Parameters()
    for name, start, (low, high) in zip(names, x, problem.bounds(), strict=True):
        margin = 1e-3 * (high - low)
        parameters.add(name, value=float(np.clip(start, low + margin, high - margin)), min=low, max=high)

    def vector(p):
        return np.array([p[name].value for name in names])

    def residual(p):
        return problem.residual(vector(p), *samples)

    if len(names) == 1:
        # r alone: line searches in cells of the scan's grid, moved on while the minimum lies at a cell's
        # edge; steps by the Jacobian creep where the residual is as large as the motion.
        r, moved = parameters["x0"].value, True
        while moved:
            centre, half = r, R_CELL * (1 - r)
            parameters["x0"].set(value=r, min=max(low, r - half), max=min(high, r + half))
            options = {"xtol": 1e-7, "ftol": ftol}
            result = lmfit.minimize(residual, parameters, method="powell", options=options, max_nfev=1000)
            r = result.params["x0"].value
            moved = abs(r - centre) > 0.9 * half and low + 1e-6 < r < high - 1e-6
    else:
        result = lmfit.minimize(
            residual,
            parameters,
            method="least_squares",
            jac=lambda p: problem.jacobian(vector(p), *samples),
            x_scale="jac",
            ftol=ftol,
            xtol=1e-9,
            gtol=None,
            max_nfev=60,
        )
    result.x = vector(result.params)
    return result


def _sigma(problem: _Problem) -> float:
    return float(np.sqrt(np.mean([m.sigma_theta**2 for m in problem.motions])))


def _integration_error(problem: _Problem, x) -> float:
    """Root mean square error of the integrator at x [rad], against a tolerance 100 times tighter."""
    if problem.model == "housner":
        return 0.0
    error = [
        problem.theta(x, i, m.time_s) - problem.theta(x, i, m.time_s, rtol=problem.rtol / 100)
        for i, m in enumerate(problem.motions)
    ]
    return float(np.sqrt(np.mean(np.concatenate(error) ** 2)))


def _holdout(problem: _Problem, x) -> float:
    """ε_θ of the second half of a run under the parameters fitted to the first half."""
    motion = problem.motions[0]
    half = motion.time_s[-1] / 2
    x = _least_squares(problem, x, half, FINE_SAMPLES).x
    later = motion.time_s > half
    return epsilon_theta(motion.time_s[later], problem.theta(x, 0, motion.time_s)[later], motion.theta[later])


def _fit(problem: _Problem, result, holdout: float) -> Fit:
    x = result.x
    samples = problem.samples(np.inf)
    residual = problem.residual(x, *samples)
    jacobian = problem.jacobian(x, *samples, central=problem.model != "housner")
    pinned = _at_bound(problem, x)
    covariance_x = np.full((len(x), len(x)), np.nan)
    covariance_x[np.ix_(~pinned, ~pinned)], coloured = _covariance(residual, jacobian[:, ~pinned], samples[2])

    value = problem.physical(x)
    gradient = np.eye(len(x))
    logarithmic = np.zeros(len(x), dtype=bool)
    if problem.model != "housner":
        logarithmic[:2] = True
        gradient[1, 0] = 1.0  # ln(damping) = ln k + ln(damping/k)
    covariance_log = np.where(
        np.isnan(covariance_x), np.nan, gradient @ np.nan_to_num(covariance_x) @ gradient.T
    )
    spread = NORMAL_95 * np.sqrt(np.diag(covariance_log))
    scale = np.where(logarithmic, value, 1.0)
    covariance = covariance_log * np.outer(scale, scale)
    with np.errstate(over="ignore"):
        low = np.where(logarithmic, value * np.exp(-spread), value - spread)
        high = np.where(logarithmic, value * np.exp(spread), value + spread)

    times = np.concatenate([m.time_s for m in problem.motions])
    theta = np.concatenate([m.theta for m in problem.motions])
    theta_model = np.concatenate([problem.theta(x, i, m.time_s) for i, m in enumerate(problem.motions)])
    epsilon = epsilon_theta(times, theta_model, theta)
    failure = _failure(problem, result, covariance, epsilon)
    if failure:
        covariance, low, high = (np.full_like(a, np.nan) for a in (covariance, low, high))
    held = [f"{name} held at its bound" for name, at in zip(problem.names, pinned, strict=True) if at]
    sigma = _sigma(problem)
    return Fit(
        model=problem.model,
        parameters=problem.names,
        value=value,
        stderr=np.sqrt(np.diag(covariance)),
        ci95_low=low,
        ci95_high=high,
        covariance=covariance,
        units=tuple(UNITS[name.split("_")[0]] for name in problem.names),
        time=times,
        theta=theta,
        theta_model=theta_model,
        residual=theta_model - theta,
        epsilon_theta=epsilon,
        final_time_s=float(max(m.time_s[-1] for m in problem.motions)),
        epsilon_holdout=holdout,
        aic=float(result.aic),
        bic=float(result.bic),
        n_parameters=len(x),
        success=not failure,
        message=failure or "; ".join(["converged", *held]),
        diagnostics={
            "evaluations": float(result.nfev),
            "rtol": problem.rtol,
            "integrator_error": _integration_error(problem, x) / sigma if sigma else 0.0,
            "residual_over_sigma": float(np.sqrt(np.mean(residual**2)) / sigma) if sigma else float("nan"),
            "coloured": float(coloured),
        },
    )


def _at_bound(problem: _Problem, x) -> np.ndarray:
    """Which of the fitted parameters lie at a bound."""
    low, high = np.array(problem.bounds()).T
    return np.minimum(x - low, high - x) < 1e-4 * (high - low)


def _failure(problem: _Problem, result, covariance, epsilon: float) -> str:
    """Why the fit is not to be used; "" when it is. A nuisance held at its bound is no failure."""
    n_model = len(MODELS[problem.model])
    if not result.success:
        return f"not converged: {result.message}"
    for name, pinned in zip(problem.names[:n_model], _at_bound(problem, result.x), strict=False):
        if pinned:
            return f"{name} lies at its bound"
    if not np.all(np.isfinite(np.diag(covariance)[:n_model])):
        return "the data do not determine the parameters"
    if epsilon >= 1:
        return "worse than a block at rest (ε_θ ≥ 1)"
    return ""


def _covariance(residual, jacobian, lengths):
    """Covariance of the least-squares estimate, and whether the residual is coloured.

    White residual: s²(JᵀJ)⁻¹. Coloured residual (lag-one correlation beyond four standard errors):
    sandwich (JᵀJ)⁻¹ S (JᵀJ)⁻¹ with the Bartlett-weighted long-run covariance S of the scores
    J_i e_i, bandwidth by Andrews (1991), doi:10.2307/2938229; the larger of the two variances counts.
    """
    n, n_parameters = jacobian.shape
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    if not (n_parameters and np.all(scale > 0)):
        return np.full((n_parameters, n_parameters), np.nan), False
    jacobian = jacobian / scale
    inverse = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    variance = residual @ residual / (n - n_parameters)
    white = variance * inverse
    centred = residual - residual.mean()
    correlation = centred[1:] @ centred[:-1] / (centred @ centred)
    coloured = abs(correlation) > 4 / np.sqrt(n)
    covariance = white
    if coloured:
        inner = _long_run(jacobian * residual[:, None], lengths)
        sandwich = inverse @ inner @ inverse
        widen = np.sqrt(np.maximum(np.diag(white) / np.diag(sandwich), 1.0))
        covariance = sandwich * np.outer(widen, widen)
    return covariance / np.outer(scale, scale), coloured


def _long_run(scores, lengths) -> np.ndarray:
    """Bartlett-weighted long-run covariance of the scores, shape (n_parameters, n_parameters)."""
    bandwidth = _andrews_bandwidth(scores)
    inner = np.zeros((scores.shape[1],) * 2)
    for run in np.split(scores, np.cumsum(lengths)[:-1]):
        lags = np.arange(-min(bandwidth, len(run) // 3), min(bandwidth, len(run) // 3) + 1)
        weights = 1 - np.abs(lags) / (lags[-1] + 1)
        inner += run.T @ fftconvolve(run, weights[:, None], mode="same", axes=0)
    return inner


def _andrews_bandwidth(scores) -> int:
    rho = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores.T]).clip(-0.999, 0.999)
    power = scores.var(axis=0) ** 2
    alpha = np.sum(power * 4 * rho**2 / ((1 - rho) ** 6 * (1 + rho) ** 2)) / np.sum(power / (1 - rho) ** 4)
    return int(np.ceil(1.1447 * (alpha * len(scores)) ** (1 / 3)))
