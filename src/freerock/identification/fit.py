"""Model parameters from measured θ(t): a scan for the start, growing horizons, then least squares.

The objective is the paper's: the mean square error between measured and modelled θ(t)
(Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import lmfit
import numpy as np
from scipy.ndimage import minimum_filter
from scipy.optimize import OptimizeResult, minimize_scalar

from freerock.errors import FreerockError
from freerock.identification.choice import epsilon_theta, is_white
from freerock.identification.intervals import NORMAL_95, covariance
from freerock.models.block import Block
from freerock.models.housner import housner_swings
from freerock.models.laws import LAWS, MODELS, PARAMETERS, PER_RUN, extended_by, parameter_of, unit_of
from freerock.models.simulate import simulate_fitted
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion

NUISANCES = tuple(dict.fromkeys(name for law in LAWS.values() for name in law.nuisances))

R_GRID = 1 - np.geomspace(1e-4, 0.95, 170)
R_CELL = 0.06  # spacing of the grid relative to 1 - r
SCAN_SAMPLES, GROWTH_SAMPLES = 250, 1000  # per run, before the last fit to all of them
SCAN, COARSE, FINE, FINEST = 1e-4, 1e-6, 1e-8, 1e-12  # rtol: of scan, residual, derivatives; least of all
CANDIDATES = 3
PROMISING = 5.0  # candidates whose mean square error is within this factor of the best one are followed on
WORTH = 0.02  # largest share of a standard error that averaging of samples may cost


@dataclass(frozen=True)
class Fit:
    """Identified parameters of one model on one run, or on several runs jointly.

    Parameters
    ----------
    model : str
        One of "housner", "winkler", "hunt_crossley", "general".
    parameters : tuple of str
        Model parameters, then what else was freed (width; theta0, t0, numbered by run in a joint fit;
        r_2, r_3 and so on).
    value, stderr, ci95_low, ci95_high : ndarray, shape (n_parameters,)
        In the unit of each parameter; all but the value NaN where the data do not determine it.
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
        evaluations; rtol; integrator_error (largest shift of a parameter over its standard error); averaged
        (samples averaged into one); residual_over_sigma; coloured (1 where neighbouring residuals
        correlate and the standard errors are widened for it); white (1 where the residual passes for
        white noise); widened (largest factor by which a standard error was raised, of a run whose first
        half disagrees with the whole); added_damping (of Winkler and Hunt-Crossley: how many standard
        errors the damping of the other law would be above zero).
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
    free: Sequence[str] = PER_RUN,
    debonding: str = "geometric",
    integrator_error: float = 0.2,
    profile: bool = False,
) -> Fit:
    """Identify a model on one run.

    A scan over a grid gives starts on the first swings; each is followed over growing horizons to
    the whole run with `lmfit`; the best end wins. The last fit averages as many samples, and takes as loose
    a tolerance of the integrator, as the standard errors bear.

    Parameters
    ----------
    model : str
        One of "housner", "winkler", "hunt_crossley", "general".
    block : Block
        The block.
    motion : Motion
        The measured run.
    free : sequence of str
        What is fitted besides the model's parameters: "theta0" and "t0", within six standard errors of what
        was measured, or 0.2 % and 1 ms if those are more; "width", the distance of the corners the block
        rocks about; "r_per_impact" of one run of the Housner model: r, r_2, r_3 and so on.
    debonding : str
        "geometric" or "tensionless".
    integrator_error : float
        Largest shift of a parameter by the integrator's error, as a share of its standard error.
    profile : bool
        Whether the intervals of the model's parameters are those of the profile likelihood.

    Returns
    -------
    Fit

    Raises
    ------
    FreerockError
        Unknown model or nuisance; fewer valid samples than parameters.
    """
    return fit_record(
        model,
        block,
        [motion],
        free=free,
        debonding=debonding,
        integrator_error=integrator_error,
        profile=profile,
    )


def fit_record(
    model: str,
    block: Block | Sequence[Block],
    motions: Sequence[Motion],
    *,
    start: Sequence[float] | None = None,
    free: Sequence[str] = PER_RUN,
    debonding: str = "geometric",
    integrator_error: float = 0.2,
    profile: bool = False,
) -> Fit:
    """Identify a model on several runs jointly: one set of parameters, nuisances per run.

    `block` is that of all runs, or a sequence with the block of each; `motions` is a sequence of Motion;
    `start` are the model's parameters to start from [SI], by default those that a scan finds on the first
    run. All else, and the errors, as in `fit_run`.
    """
    if model not in MODELS:
        raise FreerockError("fits.models", f"unknown model {model!r}", f"use one of {', '.join(MODELS)}")
    unknown = set(free) - set(NUISANCES)
    if unknown:
        raise FreerockError(
            f"fits.free.{model}",
            f"unknown nuisance {min(unknown)!r}",
            f"use {', '.join(NUISANCES[:-1])} or {NUISANCES[-1]}",
        )
    law = LAWS[model]
    if not law.allows(debonding, len(law.dampings)):
        what = "the tensionless rule is not worked out for both dampings at once"
        raise FreerockError("fits.debonding", what, f"use geometric or remove {model} from fits.models")
    blocks = (block,) * len(motions) if isinstance(block, Block) else tuple(block)
    if "width" in free and len(set(blocks)) > 1:
        raise FreerockError(f"fits.free.{model}", "one width for several blocks", "remove width")
    problem = _Problem(
        model,
        blocks,
        tuple(motions),
        tuple(n for n in NUISANCES if n in free),
        debonding,
        r_low=0.0 if law.is_foundation else _rocking_for(blocks[0], motions[0], _moving_s(motions[0]) / 2),
    )
    if min(problem.samples().lengths, default=0) <= len(problem.names):
        raise FreerockError(
            "fit", "fewer valid samples than parameters", "exclude the run or widen it by an override"
        )
    if "r_per_impact" in free:
        if "r_per_impact" not in law.nuisances or len(motions) > 1:
            what = "a restitution per impact belongs to one run of the Housner model"
            raise FreerockError(f"fits.free.{model}", what, "remove r_per_impact or set fits.pooled: false")
        problem = replace(problem, n_impacts=_impacts(motions[0]))
    problem, result = _minimise(problem, start, integrator_error)
    return _fit(problem, result, profile)


def evidence(fit: Fit) -> dict:
    """What `freerock.identification.choice.choose_model` asks of a fit."""
    numbers = {"success": fit.success, "bic": fit.bic, "epsilon_holdout": fit.epsilon_holdout}
    return fit.diagnostics | numbers


@dataclass(frozen=True)
class _Samples:
    """Samples that count, of one run after the other: time [s], θ [rad], number per run, averaged m by m."""

    time_s: np.ndarray
    theta: np.ndarray
    lengths: tuple
    m: int = 1

    @property
    def runs(self) -> list:
        """Where the samples of each run lie."""
        ends = np.cumsum(self.lengths)
        return [slice(end - n, end) for n, end in zip(self.lengths, ends, strict=True)]

    def averaged(self, values):
        """Means of m samples each, times √m: their noise is that of one sample."""
        if self.m == 1:
            return values
        parts = [values[run][: n // self.m * self.m] for run, n in zip(self.runs, self.lengths, strict=True)]
        means = [part.reshape(-1, self.m, *values.shape[1:]).mean(axis=1) for part in parts]
        return np.sqrt(self.m) * np.concatenate(means)


@dataclass(frozen=True)
class _Problem:
    model: str
    blocks: tuple
    motions: tuple
    free: tuple
    debonding: str
    r_low: float  # a block that stops too soon is out of step for less time: that false minimum is shut out
    n_impacts: int = 0  # that have a restitution of their own; the last one's is that of all further ones
    rtol: float = COARSE

    @property
    def common(self) -> tuple:
        """Parameters that all runs share."""
        return (*MODELS[self.model], *(name for name in self.free if name == "width"))

    @property
    def own(self) -> tuple:
        """Parameters of each run."""
        further = (f"r_{i}" for i in range(2, self.n_impacts + 1))
        return (*(name for name in self.free if name in PER_RUN), *further)

    @cached_property
    def names(self) -> tuple:
        numbered = [
            name if len(self.motions) == 1 else f"{name}_{i}"
            for i in range(1, len(self.motions) + 1)
            for name in self.own
        ]
        return (*self.common, *numbered)

    @cached_property
    def is_logarithm(self) -> np.ndarray:
        """Which of the fitted parameters are logarithms."""
        return np.array([parameter_of(name).is_logarithm for name in self.names])

    @cached_property
    def is_ratio(self) -> np.ndarray:
        """Which of them are ratios to the stiffness, the first parameter."""
        return np.array([parameter_of(name).fitted_as == "ratio" for name in self.names])

    def physical(self, x) -> np.ndarray:
        """Parameters in SI units from the fitted ones (ln k, ln(damping/k), width over the nominal one)."""
        value = np.array(x, dtype=float)
        value[self.is_ratio] += value[0]
        value[self.is_logarithm] = np.exp(value[self.is_logarithm])
        if "width" in self.common:
            value[self.common.index("width")] *= self.blocks[0].width_m
        return value

    def gradient(self, x) -> np.ndarray:
        """Derivatives of the parameters in SI units by the fitted ones."""
        gradient = np.eye(len(x))
        gradient[self.is_ratio, 0] = 1.0
        scale = np.where(self.is_logarithm, self.physical(x), 1.0)
        if "width" in self.common:
            scale[self.common.index("width")] = self.blocks[0].width_m
        return scale[:, None] * gradient

    def fitted(self, values) -> list:
        """The model's fitted parameters from those in SI units, the inverse of `physical`."""
        names = MODELS[self.model]
        return [
            _fitted(name, value / values[0] if PARAMETERS[name].fitted_as == "ratio" else value)
            for name, value in zip(names, values, strict=True)
        ]

    def alone(self) -> "_Problem":
        """The same problem on the first run only."""
        return replace(self, blocks=self.blocks[:1], motions=self.motions[:1])

    def motion(self, x, i: int, time_s, rtol=None, added=None, rate=None) -> np.ndarray:
        """θ of run i at the measured run's clock [rad]; an overturned block lies at ±π/2.

        `rate`, if given, receives θ̇ [rad/s].
        """
        value, n_common, n_own = self.physical(x), len(self.common), len(self.own)
        own = dict(zip(self.own, value[n_common + i * n_own :], strict=False))
        values = {"theta0": self.motions[i].theta0, **dict(zip(self.common, value, strict=False)), **own}
        if self.n_impacts > 1:
            values["r"] = np.array([values["r"], *(own[f"r_{j}"] for j in range(2, self.n_impacts + 1))])
        return simulate_fitted(
            wider[0] if added and (wider := extended_by(self.model)) else self.model,
            self.blocks[i],
            values | (added or {}),
            time_s,
            debonding=self.debonding,
            rtol=rtol or self.rtol,
            theta_rate=rate,
        )

    def curve(self, x, samples: _Samples, rtol=None, added=None) -> np.ndarray:
        """θ of all runs at the samples."""
        return np.concatenate(
            [self.motion(x, i, samples.time_s[run], rtol, added) for i, run in enumerate(samples.runs)]
        )

    def samples(self, horizon_s: float = np.inf, most: float = np.inf, m: int = 1) -> _Samples:
        """Samples that count up to the horizon, thinned to `most` per run or averaged m by m."""
        times, thetas = [], []
        for motion in self.motions:
            counts = np.isfinite(motion.theta) & (motion.time_s >= motion.fit_start_s)
            index = np.flatnonzero(counts & (motion.time_s <= horizon_s))
            index = index[:: max(1, int(len(index) // most))]
            times.append(motion.time_s[index])
            thetas.append(motion.theta[index])
        return _Samples(np.concatenate(times), np.concatenate(thetas), tuple(map(len, times)), m)

    def residual(self, x, samples: _Samples) -> np.ndarray:
        return samples.averaged(self.curve(x, samples) - samples.theta)

    def jacobian(self, x, samples: _Samples, central: bool = False) -> np.ndarray:
        """Derivatives of θ, shape (n_samples, n_parameters): difference quotients, but -θ̇ for the release.

        The steps are as small as the standard errors may be, hence the tolerance.
        """
        rtol = min(self.rtol, FINE)
        jacobian = np.zeros((len(samples.time_s), len(x)))
        n_common, n_own = len(self.common), len(self.own)
        for i, run in enumerate(samples.runs):
            rate = np.empty(samples.lengths[i])
            theta = self.motion(x, i, samples.time_s[run], rtol, rate=rate)
            for j, name in enumerate((*self.common, *self.own)):
                column = j if j < n_common else j + i * n_own
                if name == "t0":
                    jacobian[run, column] = -rate
                    continue
                up, step = np.array(x, dtype=float), parameter_of(name).step
                up[column] += step
                quotient = self.motion(up, i, samples.time_s[run], rtol)
                if central:
                    up[column] -= 2 * step
                    quotient -= self.motion(up, i, samples.time_s[run], rtol)
                else:
                    quotient -= theta
                jacobian[run, column] = quotient / (2 * step if central else step)
        return jacobian

    def bounds(self) -> list:
        least = 1e-4 if LAWS[self.model].cases else 1.0  # one of its dampings may be a trace
        bounds = []
        for name in self.common:
            low, high = PARAMETERS[name].bounds or (self.r_low, R_GRID[0])
            if PARAMETERS[name].fitted_as == "ratio":
                low *= least
            bounds.append((_fitted(name, low), _fitted(name, high)))
        for motion in self.motions:
            half = {
                "theta0": max(6 * motion.theta0_stderr, 0.002 * abs(motion.theta0)),
                "t0": max(6 * motion.t0_stderr, 1e-3),
            }
            centre = {"theta0": motion.theta0, "t0": 0.0}
            bounds += [
                (centre[name] - half[name], centre[name] + half[name])
                if name in PER_RUN
                else (R_GRID[-1], R_GRID[0])
                for name in self.own
            ]
        return bounds

    def start(self, model_values) -> np.ndarray:
        begin = {"theta0": lambda m: m.theta0, "t0": lambda m: 0.0}
        shared = [1.0] * (len(self.common) - len(MODELS[self.model]))
        own = [begin.get(n, lambda _: model_values[0])(m) for m in self.motions for n in self.own]
        return np.array([*model_values, *shared, *own])


def _fitted(name: str, value: float) -> float:
    """The number that the optimiser moves, of a value or of a ratio to k."""
    return np.log(value) if PARAMETERS[name].is_logarithm else value


def _rocking_for(block: Block, motion: Motion, time_s: float) -> float:
    """Least r of the grid with which the rigid block rocks for longer than a time."""
    few, many = 0, len(R_GRID) - 1  # the grid falls, and with it the time to rest
    while few < many:
        middle = (few + many + 1) // 2
        if housner_swings(block, R_GRID[middle], motion.theta0, until=time_s).rest_time > time_s:
            few = middle
        else:
            many = middle - 1
    return R_GRID[few]


def _moves(motion: Motion) -> np.ndarray:
    """Which samples stand out of the noise, and of the ringing of a base in full contact."""
    return np.abs(motion.theta) > max(10 * motion.sigma_theta, 1e-3 * abs(motion.theta0))


def _impacts(motion: Motion) -> int:
    """Changes of sign of θ while the block moves."""
    return int(np.count_nonzero(np.diff(np.sign(motion.theta[_moves(motion)]))))


def _moving_s(motion: Motion) -> float:
    """Last instant at which the block moves [s]; 0 where it never does."""
    moves = _moves(motion)
    return motion.time_s[moves][-1] if moves.any() else 0.0


def _minimise(problem: _Problem, start, integrator_error: float):
    """Best end of the candidates over growing horizons, at the tolerance and sampling the noise asks for."""
    horizons = _horizons(problem.motions[0])
    if start is None:
        starts = _scan(problem.alone(), horizons[0])
    else:
        starts, horizons = [problem.fitted(start)], horizons[-2:]
    if not LAWS[problem.model].is_foundation:
        horizons = horizons[-1:]  # already scanned on the whole run
    tracks = [_grow(problem, problem.start(values), horizons[:1]) for values in starts]
    promising = PROMISING * min(error for error, _ in tracks)
    tracks = [_grow(problem, x, horizons[1:], error) for error, x in tracks if error <= promising]
    x = min(tracks, key=lambda track: track[0])[1]
    rtol, m, shift = _resolution(problem, x, integrator_error)
    problem = replace(problem, rtol=rtol)
    result = _least_squares(problem, x, problem.samples(m=m))
    result.m, result.shift = m, shift
    return problem, result


def _grow(problem: _Problem, x, horizons, error: float = np.inf) -> tuple:
    """Mean square error [rad²] and fitted parameters after least squares over each horizon in turn."""
    for horizon in horizons:
        result = _least_squares(problem, x, problem.samples(horizon, GROWTH_SAMPLES), ftol=1e-3)
        x, error = result.x, result.chisqr / result.ndata
    return error, x


def _horizons(motion: Motion) -> list:
    """Growing spans [s]: the first two swings, then doubled up to the whole run."""
    counts = np.isfinite(motion.theta)
    theta, time_s = motion.theta[counts], motion.time_s[counts]
    crossings = time_s[1:][np.signbit(theta[1:]) != np.signbit(theta[:-1])]
    first = crossings[0] if len(crossings) else time_s[-1] / 8
    spans = [max(3.0 * first, motion.fit_start_s + first)]
    while spans[-1] < time_s[-1]:
        spans.append(2 * spans[-1])
    return spans


def _scan(problem: _Problem, horizon_s: float) -> list:
    """Starting values of the model's parameters: lowest local minima of the error over the model's grid.

    Housner's r: the lowest minimum inside the range. At its lower end the error may fall further, as the
    block that stops early is out of step for less time. A law with cases starts from the minima of these,
    with a trace of the damping that each lacks.
    """
    law = LAWS[problem.model]
    if not law.is_foundation:
        return [[_scan_r(problem)]]
    if law.cases:
        traces = {name: np.log(PARAMETERS[name].trace) for name in law.dampings}
        return [
            [(traces | dict(zip(MODELS[case], found, strict=True)))[name] for name in law.parameters]
            for case in law.cases
            for found in _scan(replace(problem, model=case), horizon_s)[:2]
        ]
    samples = problem.samples(horizon_s, SCAN_SAMPLES)
    coarse = replace(problem, rtol=SCAN)
    grids = [np.geomspace(*PARAMETERS[name].grid) for name in law.parameters]
    middle = [_fitted(name, grid[len(grid) // 2]) for name, grid in zip(law.parameters, grids, strict=True)]
    grids[0] = np.sort(np.append(grids[0], _first_swing_k(coarse, horizon_s, middle[1:])))
    points = [
        [_fitted(name, value) for name, value in zip(law.parameters, point, strict=True)]
        for point in product(*grids)
    ]
    errors = np.array([np.mean(coarse.residual(problem.start(point), samples) ** 2) for point in points])
    cells = errors.reshape([len(grid) for grid in grids])
    minima = np.flatnonzero(cells == minimum_filter(cells, size=3, mode="nearest"))
    return [points[i] for i in sorted(minima.tolist(), key=lambda i: errors[i])[:CANDIDATES]]


def _first_swing_k(problem: _Problem, horizon_s: float, others: list) -> float:
    """Stiffness that puts the first impact where it was measured; near overturning the grid is too coarse.

    `others` are the fitted numbers of the law's further parameters.
    """
    motion = problem.motions[0]
    time_s = np.linspace(0.0, horizon_s, GROWTH_SAMPLES)

    def first_impact(theta):
        crossed = np.flatnonzero(theta * motion.theta0 < 0)
        return crossed[0] if len(crossed) else len(theta)

    measured = first_impact(np.interp(time_s, motion.time_s, np.nan_to_num(motion.theta, nan=motion.theta0)))
    low, high, _ = PARAMETERS["k"].grid
    while high > 1.001 * low:
        k = np.sqrt(low * high)
        theta = problem.motion(problem.start([np.log(k), *others]), 0, time_s)
        if first_impact(theta) > measured:
            low = k
        else:
            high = k
    return high


def _scan_r(problem: _Problem) -> float:
    """Restitution of the lowest inner minimum, among those that let it rock about as long as it did."""
    motion, high = problem.motions[0], R_GRID[0]
    samples = problem.samples(np.inf, SCAN_SAMPLES)
    moving = _moving_s(motion)
    if moving < 0.95 * motion.time_s[-1]:
        high = _rocking_for(problem.blocks[0], motion, 4 * moving)
    grid = R_GRID[(R_GRID >= problem.r_low) & (R_GRID <= high)]  # noqa: SIM300
    errors = np.array([np.mean(problem.residual(problem.start([r]), samples) ** 2) for r in grid])
    inside = np.flatnonzero((errors[1:-1] <= errors[:-2]) & (errors[1:-1] <= errors[2:])) + 1
    return grid[inside[np.argmin(errors[inside])] if len(inside) else np.argmin(errors)]


def _resolution(problem: _Problem, x, integrator_error: float) -> tuple:
    """Loosest tolerance and coarsest averaging that the standard errors can bear.

    Returns rtol, the number of samples to average, and the largest shift of a parameter by the integrator's
    error as a share of its standard error.
    """
    samples = problem.samples()
    theta = problem.curve(x, samples)
    noise = np.sqrt(np.mean((theta - samples.theta) ** 2))
    jacobian = problem.jacobian(x, samples)
    jacobian /= np.maximum(np.sqrt(np.mean(jacobian**2, axis=0)), 1e-300)
    inverse = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    spread = np.sqrt(np.diag(inverse))
    m = 1
    while 2 * m * 20 * len(x) < min(samples.lengths):
        means = replace(samples, m=2 * m).averaged(jacobian)
        wider = np.sqrt(np.diag(np.linalg.pinv(means.T @ means, hermitian=True)))
        if np.any(wider > (1 + WORTH) * spread):
            break
        m *= 2
    if not LAWS[problem.model].is_foundation:
        return problem.rtol, m, 0.0
    rtol = problem.rtol
    while True:
        exact = problem.curve(x, samples, rtol / 100)
        shifts = np.abs(inverse @ (jacobian.T @ (theta - exact)))[spread > 0] / (spread[spread > 0] * noise)
        shift = float(np.max(shifts, initial=0.0))
        if not shift > integrator_error or rtol <= FINEST:
            return rtol, m, shift
        rtol /= 10
        theta = problem.curve(x, samples, rtol)


def _least_squares(problem: _Problem, x, samples: _Samples, ftol: float = 1e-7):
    if len(x) == 1:
        return _line_search(problem, x[0], samples)
    names = [f"x{i}" for i in range(len(x))]
    parameters = lmfit.Parameters()
    for name, start, (low, high) in zip(names, x, problem.bounds(), strict=True):
        margin = 1e-3 * (high - low)
        parameters.add(name, value=float(np.clip(start, low + margin, high - margin)), min=low, max=high)

    def vector(p):
        return np.array([p[name].value for name in names])

    def residual(p):
        return problem.residual(vector(p), samples)

    def jacobian(p):
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
    result.x = vector(result.params)
    return result


def _line_search(problem: _Problem, r: float, samples: _Samples) -> OptimizeResult:
    """Least squares in r alone: cells of the scan's grid, moved on while the minimum lies at a cell's edge.

    Steps by the Jacobian creep where the residual is as large as the motion.
    """
    ((low, high),) = problem.bounds()

    def error(r):
        return np.sum(problem.residual(np.array([r]), samples) ** 2)

    r, moved, evaluations = float(np.clip(r, low, high)), True, 0
    while moved:
        half = R_CELL * (1 - r)
        cell = max(low, r - half), min(high, r + half)
        found = minimize_scalar(error, bounds=cell, method="bounded", options={"xatol": 1e-6 * half})
        moved = abs(found.x - r) > 0.9 * half and low + 1e-6 < found.x < high - 1e-6
        r, evaluations = found.x, evaluations + found.nfev
    ndata = sum(n // samples.m for n in samples.lengths)
    found.update(x=np.array([r]), chisqr=found.fun, ndata=ndata, nfev=evaluations)
    return found


def _first_half(problem: _Problem, x, m: int) -> tuple:
    """Parameters fitted to the first half of a run, and ε_θ of its second half under them."""
    motion = problem.motions[0]
    half = motion.time_s[-1] / 2
    samples = problem.samples(half, m=m)
    if sum(samples.lengths) <= 2 * m * len(x):
        return x, float("nan")
    x = _least_squares(problem, x, samples).x
    later = motion.time_s > half
    theta = problem.motion(x, 0, motion.time_s)
    return x, epsilon_theta(motion.time_s[later], theta[later], motion.theta[later])


def _widened(covariance_x, apart) -> tuple:
    """Covariance in which what the first half of a run says of a parameter is no surprise, and the factor.

    Under a law that is not the whole truth, parts of a run disagree by more than the correlation of the
    residual tells. Where they do so by more than three standard errors, the difference is the standard error.
    """
    stderr = np.sqrt(np.diag(covariance_x))
    factor = np.where(np.abs(apart) > 3 * stderr, np.abs(apart) / stderr, 1.0)
    return covariance_x * np.outer(factor, factor), float(np.nanmax(factor, initial=1.0))


def _added_damping(problem: _Problem, x, samples, residual, jacobian) -> float:
    """How many standard errors the other law's damping would be away from zero, by a score test.

    The standard errors are those of `freerock.identification.intervals.covariance`; a negative number is a
    damping that would have to drive the block.
    """
    _, other = extended_by(problem.model)
    # the trough of the misfit is bent: a larger trace gives no derivative
    trace = 1e-3 * PARAMETERS[other].trace * problem.physical(x)[0]
    column = problem.curve(x, samples, FINE, {other: trace}) - problem.curve(x, samples, FINE)
    jacobian = np.column_stack([jacobian, column])
    step = -np.linalg.lstsq(jacobian, residual, rcond=None)[0][-1]
    spread, _ = covariance(residual, jacobian, samples.lengths)
    return float(step / np.sqrt(spread[-1, -1]))


def _profile(problem: _Problem, x, samples: _Samples, stderr) -> dict:
    """95 % intervals of the model's parameters by the profile likelihood.

    Where the residual is coloured the likelihood's curvature exaggerates what is known: the level is raised
    by the ratio of the standard errors. Beyond a ratio of three there is no level to find, and no interval.
    """
    names = MODELS[problem.model]
    value = problem.physical(x)[: len(names)]
    logarithms = problem.is_logarithm[: len(names)]
    spread = stderr[: len(names)] / np.where(logarithms, value, 1.0)
    # profiled in ln k and ln λ, fitted in ln k and ln λ/k; in standard errors, the best at 10, as lmfit walks
    # and finds the ends of an interval in shares of the value
    to_fitted = np.eye(len(x))
    to_fitted[problem.is_ratio, 0] = -1.0
    unit = np.where(np.isfinite(stderr), stderr, 1.0)
    unit[: len(names)] = spread
    to_fitted *= unit
    parameters = lmfit.Parameters()
    for i, pinned in enumerate(_at_bound(problem, x)):
        parameters.add(f"u{i}", value=10.0, vary=not pinned)

    def fitted(p):
        return x + to_fitted @ [p[name].value - 10.0 for name in parameters]

    def residual(p):
        return problem.residual(fitted(p), samples)

    def jacobian(p):
        columns = samples.averaged(problem.jacobian(fitted(p), samples)) @ to_fitted
        return columns[:, [p[name].vary for name in parameters]]

    minimizer = lmfit.Minimizer(residual, parameters, Dfun=jacobian)
    best = minimizer.leastsq()
    intervals = {}
    for i, name in enumerate(names):
        ratio = max(1.0, 1 / (best.params[f"u{i}"].stderr or np.inf))
        if best.errorbars and ratio < 3:
            ends = lmfit.conf_interval(minimizer, best, p_names=[f"u{i}"], sigmas=[NORMAL_95 * ratio])[
                f"u{i}"
            ]
            ends = spread[i] * (np.array([ends[0][1], ends[-1][1]]) - 10.0)
            intervals[name] = value[i] * np.exp(ends) if logarithms[i] else value[i] + ends
    return intervals


def _fit(problem: _Problem, result, profile: bool) -> Fit:
    x = result.x
    samples = problem.samples()
    residual = problem.residual(x, samples)
    jacobian = problem.jacobian(x, samples, central=LAWS[problem.model].is_foundation)
    free = ~_at_bound(problem, x)
    covariance_x = np.full((len(x), len(x)), np.nan)
    covariance_x[np.ix_(free, free)], coloured = covariance(residual, jacobian[:, free], samples.lengths)
    white, holdout, widened = is_white(residual), float("nan"), 1.0
    if len(problem.motions) == 1:
        x_half, holdout = _first_half(problem, x, result.m)
        if not white:
            covariance_x, widened = _widened(covariance_x, x_half - x)

    value, gradient = problem.physical(x), problem.gradient(x)
    covariance_si = np.full_like(covariance_x, np.nan)
    by_free = gradient[np.ix_(free, free)]
    covariance_si[np.ix_(free, free)] = by_free @ covariance_x[np.ix_(free, free)] @ by_free.T
    stderr = np.sqrt(np.diag(covariance_si))
    with np.errstate(over="ignore"):
        factor = np.exp(NORMAL_95 * stderr / np.abs(value))
        low = np.where(problem.is_logarithm, value / factor, value - NORMAL_95 * stderr)
        high = np.where(problem.is_logarithm, value * factor, value + NORMAL_95 * stderr)

    motions = problem.motions
    times = np.concatenate([m.time_s for m in motions])
    theta = np.concatenate([m.theta for m in motions])
    theta_model = np.concatenate([problem.motion(x, i, m.time_s) for i, m in enumerate(motions)])
    epsilon = epsilon_theta(times, theta_model, theta)
    failure = _failure(problem, result, covariance_si, epsilon)
    if failure:
        covariance_si, stderr, low, high = (
            np.full_like(a, np.nan) for a in (covariance_si, stderr, low, high)
        )
    n = len(residual)
    likelihood = n * np.log(residual @ residual / n)
    sigma = float(np.sqrt(np.mean([m.sigma_theta**2 for m in motions])))
    diagnostics = {
        "evaluations": float(result.nfev),
        "rtol": problem.rtol,
        "integrator_error": result.shift,
        "averaged": float(result.m),
        "residual_over_sigma": float(np.sqrt(residual @ residual / n) / sigma) if sigma else float("nan"),
        "coloured": float(coloured),
        "white": float(white),
        "widened": widened,
    }
    if not failure and extended_by(problem.model) and problem.debonding == "geometric":
        diagnostics["added_damping"] = _added_damping(problem, x, samples, residual, jacobian[:, free])
    if profile and not failure:
        for name, bounds in _profile(
            replace(problem, rtol=min(problem.rtol, FINE)), x, problem.samples(m=result.m), stderr
        ).items():
            low[problem.names.index(name)], high[problem.names.index(name)] = bounds
            diagnostics["profile"] = 1.0
    held = [
        f"{name} held at its bound" for name, inside in zip(problem.names, free, strict=True) if not inside
    ]
    return Fit(
        model=problem.model,
        parameters=problem.names,
        value=value,
        stderr=stderr,
        ci95_low=low,
        ci95_high=high,
        covariance=covariance_si,
        units=tuple(map(unit_of, problem.names)),
        time=times,
        theta=theta,
        theta_model=theta_model,
        residual=theta_model - theta,
        epsilon_theta=epsilon,
        final_time_s=float(max(m.time_s[-1] for m in motions)),
        epsilon_holdout=holdout,
        aic=float(likelihood + 2 * len(x)),
        bic=float(likelihood + np.log(n) * len(x)),
        n_parameters=len(x),
        success=not failure,
        message=failure or "; ".join(["converged", *held]),
        diagnostics=diagnostics,
    )


def _at_bound(problem: _Problem, x) -> np.ndarray:
    """Which of the fitted parameters lie at a bound."""
    low, high = np.array(problem.bounds()).T
    return np.minimum(x - low, high - x) < 1e-4 * (high - low)


def _failure(problem: _Problem, result, covariance_si, epsilon: float) -> str:
    """Why the fit is not to be used; "" when it is. A nuisance of a run held at its bound is no failure."""
    n_common = len(problem.common)
    if not result.success:
        return f"not converged: {result.message}"
    for name, pinned in zip(problem.common, _at_bound(problem, result.x), strict=False):
        if pinned:
            return f"{name} lies at its bound"
    if not np.all(np.isfinite(np.diag(covariance_si)[:n_common])):
        return "the data do not determine the parameters"
    if epsilon >= 1:
        return "worse than a block at rest (ε_θ ≥ 1)"
    return ""
