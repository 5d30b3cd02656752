"""Model parameters from measured θ(t).

The objective is the paper's: the mean square error between measured and modelled θ(t)
(Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.identification.choice import LEVEL, RESIDUAL, TRACE, Evidence
from freerock.identification.diagnosis import added_damping, failure, first_half
from freerock.identification.discrepancy import epsilon_theta, is_white
from freerock.identification.intervals import Uncertainty, uncertainty, with_inputs, with_profile
from freerock.identification.least_squares import Solution, reported
from freerock.identification.likelihood import Likelihood, Whitened
from freerock.identification.model_discrepancy import Part, fitted_parts, model_discrepancy
from freerock.identification.noise import AgainstRest, against_rest, noise_of
from freerock.identification.nuisances import Posterior, settled
from freerock.identification.problem import Problem, posed
from freerock.identification.resolution import Resolution
from freerock.identification.search import search
from freerock.identification.settings import FitSettings, check
from freerock.models.block import Block
from freerock.models.laws import MODELS, law_of, unit_of
from freerock.rotation.laboratory import Contributions, Laboratory
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class ImpactEnergy:
    """Of each impact of a modelled motion, in the order of time.

    Parameters
    ----------
    time_s : ndarray, shape (n_impacts,)
        Since the release, on the clock of the fit [s].
    speed_m_s : ndarray, shape (n_impacts,)
        Of the corner that comes down, about the other one: 2 b |θ̇| [m/s].
    restitution, stderr, u_total : ndarray, shape (n_impacts,)
        √(energy at the top after the impact over that at the top before it), its standard error by the noise
        and its total uncertainty, with those of the laboratory's inputs and of the law. NaN of impacts
        without a further top.
    """

    time_s: Floats
    speed_m_s: Floats
    restitution: Floats
    stderr: Floats
    u_total: Floats


@dataclass(frozen=True)
class Fit:
    """Identified parameters of one model on one run, or on several runs jointly.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    parameters : tuple of str
        Model parameters, then what else was freed (width; theta0, t0, numbered by run in a joint fit;
        r_2, r_3 and so on).
    value, stderr, ci95_low, ci95_high : ndarray, shape (n_parameters,)
        In the unit of each parameter; all but the value NaN where the data do not determine it.
    discrepancy : ndarray, shape (n_parameters,)
        Standard uncertainty as the law does not explain the run (`model_discrepancy`), in the same units.
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
        correlate); white (1 where the residual passes for
        white noise); noise (1 where it passes for the noise at rest), noise_p, noise_ratio, noise_low_hz,
        noise_high_hz (chance of that, and the band that tells most, see `noise.AgainstRest`);
        effective_samples; widened (largest factor by which a standard error was raised, of a run whose first
        half disagrees with the whole); added_damping (of a law that a wider one extends: how many standard
        errors the damping that it lacks would be above zero); profile (1 where the intervals are those of the
        profile likelihood).
    epsilon_holdout_runs : float
        ε_θ of the run under the parameters of the other runs of its record (`holdout.of_other_runs`).
    contributions : Contributions or None
        Of what the laboratory knows to the uncertainty of the parameters (`sensitivity.contributions`).
    energies : ImpactEnergy or None
        Restitution by energy of each of `impacts`, under a foundation's law.
    parts : tuple of Part
        The same numbers from each part of the run (`model_discrepancy`); empty of a fit not to be used.
    pulled : str
        Of a fit that holds the inputs: the one that would have to be off most, in words.
    result : lmfit.minimizer.MinimizerResult or None
        Of the least squares whose numbers these are.
    """

    model: str
    parameters: tuple[str, ...]
    value: Floats
    stderr: Floats
    ci95_low: Floats
    ci95_high: Floats
    discrepancy: Floats
    covariance: Floats
    units: tuple[str, ...]
    time: Floats
    theta: Floats
    theta_model: Floats
    residual: Floats
    epsilon_theta: float
    final_time_s: float
    epsilon_holdout: float
    aic: float
    bic: float
    n_parameters: int
    success: bool
    message: str
    impacts: Impacts | None = None
    diagnostics: dict[str, float] = field(default_factory=dict)
    epsilon_holdout_runs: float = float("nan")
    contributions: Contributions | None = None
    energies: ImpactEnergy | None = None
    parts: tuple[Part, ...] = ()
    pulled: str = ""
    result: "lmfit.minimizer.MinimizerResult | None" = field(default=None, compare=False, repr=False)

    @property
    def values(self) -> dict[str, float]:
        """The freed numbers by name [SI]."""
        return dict(zip(self.parameters, self.value.tolist(), strict=True))


def fit_run(model: str, block: Block, motion: Motion, settings: FitSettings | None = None) -> Fit:
    """Identify a model on one run.

    A scan over a grid gives starts on the first swings; each is followed over growing horizons to
    the whole run by least squares; the best end wins. The last fit averages as many samples, and uses as
    loose a tolerance of the integrator, as the standard errors allow.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`: a law, such as "hunt_crossley", or a law with
        other kinematics or with the contact width freed: "hunt_crossley_pivoting", "housner_width".
    block : Block
        The block.
    motion : Motion
        The measured run.
    settings : FitSettings, optional
        What is freed besides the model's parameters, and how exact the fit is.

    Returns
    -------
    Fit

    Raises
    ------
    FreerockError
        Unknown model or nuisance; fewer valid samples than parameters.
    """
    return fit_record(model, block, [motion], settings)


def fit_record(
    model: str,
    block: Block | Sequence[Block],
    motions: Sequence[Motion],
    settings: FitSettings | None = None,
    *,
    start: Sequence[float] | Mapping[str, float] | None = None,
) -> Fit:
    """Identify a model on several runs jointly: one set of parameters, nuisances per run.

    `block` is that of all runs, or a sequence with the block of each; `motions` is a sequence of Motion;
    `start` are the model's parameters to start from [SI], in their order, or by name with what is known of
    width, theta0 and t0; by default a scan finds them on the first run. All else, and the errors, as in
    `fit_run`.
    """
    settings = settings or FitSettings()
    blocks = (block,) * len(motions) if isinstance(block, Block) else tuple(block)
    check(model, blocks, settings)
    problem = posed(model, blocks, motions, settings)
    if start is not None and not isinstance(start, Mapping):
        start = dict(zip(MODELS[model], start, strict=True))
    return _fit(*search(problem, start))


def evidence(fit: Fit) -> Evidence:
    """What `freerock.identification.choice.choose` asks of a fit."""
    of_residual: dict[str, Any] = {
        name: fit.diagnostics[name] for name in RESIDUAL if name in fit.diagnostics
    }
    return Evidence(
        model=fit.model,
        n_freed=fit.n_parameters,
        success=fit.success,
        message=fit.message,
        epsilon_theta=fit.epsilon_theta,
        epsilon_holdout=fit.epsilon_holdout,
        epsilon_holdout_runs=fit.epsilon_holdout_runs,
        bic=fit.bic,
        pulled=fit.pulled,
        **of_residual,
    )


def _fit(problem: Problem, solution: Solution, resolution: Resolution) -> Fit:
    """What the end of the search is worth: with the inputs moved where that explains the run, else held."""
    best = None
    if solution.success:
        best = settled(problem, solution.x)
    moved = None if best is None else _moved(best)
    if best is not None and moved is not None and moved.explains:
        return _of_moved(best, moved, solution, resolution)
    return _held(problem, solution, resolution, moved)


@dataclass(frozen=True, eq=False)
class _Moved:
    """A run whose inputs moved within their priors: residual, uncertainty, pulls, likelihood."""

    rest: AgainstRest
    white: bool
    known: Uncertainty
    contributions: Contributions
    likely: Likelihood
    has_rest: bool

    @property
    def explains(self) -> bool:
        """Whether residual and pulls pass for noise."""
        passes = self.rest.is_noise and (self.has_rest or self.white)
        return passes and self.contributions.p_of_pulls > LEVEL


def _moved(best: Posterior) -> _Moved:
    motion = best.problem.motions[0]
    rest = best.against_rest
    known, contributions = with_inputs(best, rest)
    likely = best.whitened.likelihood()
    return _Moved(rest, is_white(best.residual), known, contributions, likely, motion.noise is not None)


def _of_moved(best: Posterior, moved: _Moved, solution: Solution, resolution: Resolution) -> Fit:
    """The fit of a run that a law explains."""
    problem, x, known, result = best.problem, best.x, moved.known, best.result
    assert result is not None
    motion = best.nuisances.problem.motions[0]
    residual = best.nuisances.read(best.z, problem.motion(x, 0, problem.motions[0].time_s)) - motion.theta
    _, holdout = first_half(problem, x, resolution.m, None, best.curve)
    epsilon = epsilon_theta(motion.time_s, motion.theta + residual, motion.theta)
    solution = replace(
        solution,
        x=x,
        evaluations=solution.evaluations + result.nfev,
        mean_square=float(np.mean(best.residual**2)),
    )
    failed = failure(problem, solution, known, epsilon)
    diagnostics = _diagnostics(problem, solution, resolution, best.residual, known)
    diagnostics |= {"white": float(moved.white), **_against_noise(moved.rest, moved.likely)}
    diagnostics["pulls_p"] = moved.contributions.p_of_pulls
    parts, law = tuple[Part, ...](), np.zeros(len(x))
    if failed:
        known = known.unknown()
    else:
        parts = tuple(fitted_parts(problem, x, best.residual, best.jacobian))
        lacking = added_damping(problem, x, best.curve, best.whitened, moved.likely)
        diagnostics |= {} if lacking is None else {"added_damping": lacking}
        if lacking is not None and lacking > TRACE:
            law = model_discrepancy(problem.physical(x), parts)
    if problem.settings.profile and not failed:
        known, profiled = with_profile(problem, x, resolution.m, known)
        diagnostics |= {"profile": 1.0} if profiled else {}
    aic, bic = (each + best.charge for each in moved.likely.criteria(len(x)))
    return Fit(
        model=problem.model,
        parameters=problem.names,
        value=problem.physical(x),
        stderr=known.stderr,
        ci95_low=known.low,
        ci95_high=known.high,
        discrepancy=np.where(np.isfinite(known.stderr), law, np.nan),
        covariance=known.covariance,
        units=tuple(map(unit_of, problem.names)),
        time=motion.time_s,
        theta=motion.theta,
        theta_model=motion.theta + residual,
        residual=residual,
        epsilon_theta=epsilon,
        final_time_s=float(motion.time_s[-1]),
        epsilon_holdout=holdout,
        aic=aic,
        bic=bic,
        n_parameters=len(x),
        success=not failed,
        message=failed or "converged",
        diagnostics=diagnostics,
        contributions=None if failed or motion.laboratory is None else moved.contributions,
        parts=parts,
        result=result,
    )


def _held(problem: Problem, solution: Solution, resolution: Resolution, moved: _Moved | None) -> Fit:
    """The fit with the inputs as stated; `moved` is what they would leave, were they to move."""
    if problem.directions is None:
        last = reported(problem, solution.x, problem.samples(m=resolution.m))
        solution = (
            replace(last, evaluations=solution.evaluations + last.evaluations)
            if solution.success
            else replace(solution, result=last.result)
        )
    x, motions, samples = solution.x, problem.motions, problem.samples()
    times = np.concatenate([m.time_s for m in motions])
    theta = np.concatenate([m.theta for m in motions])
    theta_model = np.concatenate([problem.motion(x, i, m.time_s) for i, m in enumerate(motions)])
    counts = np.isfinite(theta) & np.concatenate([m.time_s >= m.fit_start_s for m in motions])
    residual, exact = theta_model[counts] - samples.theta, problem.exact_curve(x, samples)
    single = len(motions) == 1 and problem.directions is None
    forward = np.zeros((len(residual), len(x)), order="F") if single else None
    central = law_of(problem.model).is_foundation
    jacobian = problem.jacobian(x, samples, central, known=exact, forward=forward)
    held = problem.at_bound(x)
    lengths, noises = samples.lengths, [motion.noise for motion in motions]
    rest = against_rest(residual, jacobian[:, ~held], lengths, list(map(noise_of, motions)))
    linear = Whitened(residual, jacobian[:, ~held], lengths, noises)
    likely = linear.likelihood()
    white = is_white(residual)
    explained = rest.is_noise and (None not in noises or white)
    apart, holdout = None, float("nan")
    if len(motions) == 1:
        x_half, holdout = first_half(problem, x, resolution.m, forward, theta_model[counts])
        apart = None if explained else x_half - x
    known = uncertainty(problem, x, residual, jacobian, rest, apart)

    epsilon = epsilon_theta(times, theta_model, theta)
    solution = replace(solution, mean_square=float(np.mean(residual**2)))  # of samples that are not averaged
    failed = failure(problem, solution, known, epsilon)
    diagnostics = _diagnostics(problem, solution, resolution, residual, known)
    diagnostics |= {"white": float(white), **_against_noise(moved.rest if moved else rest, likely)}
    diagnostics |= {"pulls_p": moved.contributions.p_of_pulls} if moved else {}
    if failed:
        known = known.unknown()
    else:
        lacking = added_damping(problem, x, exact[0], linear, likely)
        diagnostics |= {} if lacking is None else {"added_damping": lacking}
        explained &= lacking is None or lacking <= TRACE
    parts = () if failed else tuple(fitted_parts(problem, x, residual, jacobian))
    law = np.zeros(len(x)) if explained else model_discrepancy(problem.physical(x), parts)
    if problem.settings.profile and not failed:
        known, profiled = with_profile(problem, x, resolution.m, known)
        diagnostics |= {"profile": 1.0} if profiled else {}
    aic, bic = likely.criteria(len(x))
    notes = [f"{name} held at its bound" for name, pinned in zip(problem.names, held, strict=True) if pinned]
    return Fit(
        model=problem.model,
        parameters=problem.names,
        value=problem.physical(x),
        stderr=known.stderr,
        ci95_low=known.low,
        ci95_high=known.high,
        discrepancy=np.where(np.isfinite(known.stderr), law, np.nan),
        covariance=known.covariance,
        units=tuple(map(unit_of, problem.names)),
        time=times,
        theta=theta,
        theta_model=theta_model,
        residual=theta_model - theta,
        epsilon_theta=epsilon,
        final_time_s=float(max(m.time_s[-1] for m in motions)),
        epsilon_holdout=holdout,
        aic=aic,
        bic=bic,
        n_parameters=len(x),
        success=not failed,
        message=failed or "; ".join(["converged", *notes]),
        diagnostics=diagnostics,
        parts=parts,
        pulled=_pulled(problem.motions[0].laboratory, moved.contributions) if moved else "",
        result=solution.result,
    )


def _pulled(laboratory: Laboratory | None, found: Contributions) -> str:
    """The input with the largest pull, its stated value and what it would be, in words."""
    j = found.most_pulled
    if laboratory is None or j is None:
        return ""
    source, pull = found.inputs[j], found.pulls[j]
    by = f"{found.moved[j] * source.u:+.3g} {source.unit}".replace(" 1", "")
    return f"{source.name} of {source.owner} off by {by}, {abs(pull):.1f} standard uncertainties"


def _diagnostics(
    problem: Problem, solution: Solution, resolution: Resolution, residual: Floats, known: Uncertainty
) -> dict[str, float]:
    """Diagnostics of every fit; see `Fit`."""
    sigma = float(np.sqrt(np.mean([m.sigma_theta**2 for m in problem.motions])))
    scatter = float(np.sqrt(residual @ residual / len(residual)))
    return {
        "evaluations": float(solution.evaluations),
        "rtol": problem.rtol,
        "integrator_error": resolution.shift,
        "averaged": float(resolution.m),
        "residual_over_sigma": scatter / sigma if sigma else float("nan"),
        "coloured": float(known.coloured),
        "widened": known.widened,
    }


def _against_noise(rest: AgainstRest, likely: Likelihood) -> dict[str, float]:
    """Diagnostics of a residual beside the noise at rest; see `Fit`."""
    return {
        "noise": float(rest.is_noise),
        "noise_p": rest.p,
        "noise_ratio": rest.ratio,
        "noise_low_hz": rest.low_hz,
        "noise_high_hz": rest.high_hz,
        "effective_samples": likely.effective,
    }
