"""Model parameters from measured θ(t).

The objective is the paper's: the mean square error between measured and modelled θ(t)
(Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.against_noise import is_white
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.inputs_with_priors import Nuisances, Posterior, held, settled
from freerock.identification.intervals import Uncertainty, uncertainty, with_profile
from freerock.identification.least_squares import Solution, in_si_units, least_squares
from freerock.identification.likelihood import Likelihood
from freerock.identification.model_discrepancy import (
    Part,
    added_number,
    failure,
    first_half,
    fitted_parts,
    model_discrepancy,
)
from freerock.identification.problem import Problem
from freerock.identification.search import Resolution, search, stopped
from freerock.identification.settings import check
from freerock.identification.significance_levels import REJECTS, RESIDUAL, chance_of, weight_against
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.free_parameters import unit_of
from freerock.models.laws import MODELS
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.u_total import Contributions
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion

# Of a number: least uncertainty beside inputs that moved, whose second order is left out. Set on 16 rigid
# blocks: r of three, known to 2e-7 by the first order, was 2.3 to 4.3 times as far off.
LINEAR_STEP = 1e-6


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
        Standard uncertainty by errors of the law (`model_discrepancy`; `selection` adds what else may be),
        same units.
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
        (samples averaged into one); residual_over_sigma; mean_square (of the residual and the pulls [rad²],
        with the inputs moved also where that does not explain the run); coloured (1 where neighbouring
        residuals correlate); white (1 where the residual agrees with
        white noise); noise (1 where it agrees with the noise at rest), noise_p, noise_ratio, noise_low_hz,
        noise_high_hz (chance of that, and the band that tells most, see `against_noise.AgainstRest`);
        effective_samples; charged (part of the BIC that is for freed numbers and inputs);
        widened (largest factor by which a standard error was raised, of a run whose first
        half disagrees with the whole); in_phase_r, in_phase_epsilon_theta (of a rigid block that stops
        rocking at the minimum: the local one that keeps the phase); added_damping (of a law that a wider one
        extends: how many standard errors a number that it lacks would be above zero); profile (1 where the
        intervals are those of the profile likelihood).
    contributions : Contributions or None
        Of the inputs to the uncertainty of the parameters (`populations.sensitivity`).
    energies : ImpactEnergy or None
        Restitution by energy of each of `impacts`, under a foundation's law.
    parts : tuple of Part
        The same numbers from each part of the run (`model_discrepancy`); empty of a fit not to be used.
    pulled : str
        The input that would have to be wrong by most, in words.
    result : lmfit.minimizer.MinimizerResult
        Of the reported least squares: its parameters are those of the fit [SI], and inputs that moved
        [standard uncertainties]; chi-square is that of its own samples and weights.
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
    contributions: Contributions | None = None
    energies: ImpactEnergy | None = None
    parts: tuple[Part, ...] = ()
    pulled: str = ""
    result: "lmfit.minimizer.MinimizerResult | None" = field(default=None, compare=False, repr=False)

    @property
    def values(self) -> dict[str, float]:
        """The freed numbers by name [SI]."""
        return dict(zip(self.parameters, self.value.tolist(), strict=True))

    @property
    def u_total(self) -> Floats:
        """Standard uncertainty of each by noise, law and, where they are known, inputs [SI]."""
        known = self.contributions
        if known is None:
            return np.hypot(self.stderr, self.discrepancy)
        return known.total(self.stderr, self.discrepancy)


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
    moved: Mapping[Input, float] | None = None,
) -> Fit:
    """Identify a model on several runs jointly: one set of parameters, nuisances per run.

    `block` is that of all runs, or a sequence with the block of each; `motions` is a sequence of Motion;
    `start` are the model's parameters to start from [SI], in their order, or by name with what is known of
    width, theta0 and t0; by default a scan finds them on the first run. `moved` are the inputs beside that
    start [standard uncertainties]; by default as stated. All else, and the errors, as in `fit_run`.
    """
    settings = settings or FitSettings()
    blocks = (block,) * len(motions) if isinstance(block, Block) else tuple(block)
    check(model, blocks, settings)
    problem = posed(model, blocks, motions, settings)
    if start is not None and not isinstance(start, Mapping):
        start = dict(zip(MODELS[model], start, strict=True))
    if moved:
        nuisances = Nuisances.of(problem)
        beside = replace(nuisances.posed(nuisances.starting(moved)), walled=problem.walled)
        beside, end, resolution = search(beside, start)
        problem = replace(problem, rtol=beside.rtol, directions=beside.directions)
    else:
        problem, end, resolution = search(problem, start)
    fit, nearest = _fit(problem, end, resolution, moved, start), stopped(problem, end)
    return fit if nearest is None or fit.diagnostics["noise"] else _of_stopped(*nearest, fit, resolution)


def _of_stopped(problem: Problem, end: Solution, in_phase: Fit, resolution: Resolution) -> Fit:
    """The fit of a rigid block that comes nearest where it stops rocking; it is not to be used."""
    with np.errstate(divide="ignore", invalid="ignore"):  # at r = 0 nothing depends on r
        fit = _held(problem, end, resolution)
    r, kept = fit.value[0], in_phase.value[0]
    message = (
        f"the block stops rocking at the minimum, r = {r:.3g} with ε_θ = {100 * fit.epsilon_theta:.3g} %; "
        f"r = {kept:.4g} keeps the phase, with ε_θ = {100 * in_phase.epsilon_theta:.3g} %"
    )
    beside = {"in_phase_r": float(kept), "in_phase_epsilon_theta": in_phase.epsilon_theta}
    return replace(fit, message=message, diagnostics=fit.diagnostics | beside)


def _fit(
    problem: Problem,
    solution: Solution,
    resolution: Resolution,
    moved_by: Mapping[Input, float] | None = None,
    start: Mapping[str, float] | None = None,
) -> Fit:
    """What the end of the search is worth: with the inputs moved where that leaves noise, else held.

    With inputs as stated, edges that are rounded may become sharp: these move from the start of the search.
    """
    moves = solution.success and Nuisances.of(problem).sources
    bound = problem.at_bound(solution.x)[: len(problem.common)].any()
    x = problem.start_at(start) if start and bound else solution.x
    best = settled(problem, x, moved=moved_by) if moves else None
    if best is None or best.result is None:
        return _held(problem, solution, resolution)
    moved = _End(best, *uncertainty(best))
    pulled = _pulled(problem.motions[0].laboratory, moved.contributions)
    if moved.is_noise:
        evaluations = solution.evaluations + best.result.nfev
        at_inputs = replace(solution, evaluations=evaluations, result=best.result)
        _, holdout = first_half(best.problem, best.x, resolution.m, best.jacobian, best.curve)
        fit = _told(moved, at_inputs, resolution, holdout, moved)
        if fit.success:
            return replace(fit, contributions=moved.contributions, pulled=pulled)
    return replace(_held(problem, solution, resolution, moved), pulled=pulled)


def _held(problem: Problem, solution: Solution, resolution: Resolution, moved: "_End | None" = None) -> Fit:
    """The fit with the inputs as stated; `moved` is what they would leave, were they to move."""
    if problem.directions is None:
        last = least_squares(problem, solution.x, problem.samples(m=resolution.m), reported=True)
        solution = (
            replace(last, evaluations=solution.evaluations + last.evaluations)
            if solution.success
            else replace(solution, result=last.result)
        )
    best, holdout, apart = held(problem, solution.x), float("nan"), None
    if len(problem.motions) == 1:
        x_half, holdout = first_half(problem, best.x, resolution.m, best.jacobian, best.curve)
        apart = None if _is_noise(best) else x_half - best.x
    return _told(_End(best, *uncertainty(best, apart)), solution, resolution, holdout, moved)


def _is_noise(best: Posterior) -> bool:
    """Whether the residual agrees with the noise: for that at rest, and for white where no rest shows it."""
    known = all(motion.noise is not None for motion in best.problem.motions)
    return best.against_rest.is_noise and (known or is_white(best.residual))


@dataclass(frozen=True, eq=False)
class _End:
    """Where a fit ended, with its inputs stated or moved, and what is known there."""

    best: Posterior
    known: Uncertainty
    contributions: Contributions

    @cached_property
    def is_noise(self) -> bool:
        """Whether the residual agrees with the noise."""
        return _is_noise(self.best)

    @cached_property
    def likely(self) -> Likelihood:
        """Of the residual."""
        return self.best.whitened.likelihood()

    @property
    def weight_against(self) -> float:
        """How far the residual speaks against the law."""
        known = all(motion.noise is not None for motion in self.best.problem.motions)
        return (
            weight_against(self.best.against_rest.p, RESIDUAL)
            if known or is_white(self.best.residual)
            else 1.0
        )

    @property
    def shown(self) -> tuple[Floats, Floats, Floats]:
        """Time, measured and modelled rotation of all samples, by the stated inputs."""
        best, stated = self.best, self.best.nuisances.problem.motions
        curves = [best.problem.motion(best.x, i, own.time_s) for i, own in enumerate(best.problem.motions)]
        measured = [np.concatenate([getattr(own, name) for own in stated]) for name in ("time_s", "theta")]
        return measured[0], measured[1], best.nuisances.read(best.z, np.concatenate(curves))


def _told(end: _End, solution: Solution, resolution: Resolution, holdout: float, moved: _End | None) -> Fit:
    """The report of the end of a fit, whether its inputs moved or not."""
    best, known, likely = end.best, end.known, end.likely
    problem, x = best.problem, best.x
    solution = replace(solution, x=x, mean_square=float(np.mean(best.residual**2)))  # of all samples
    time_s, theta, theta_model = end.shown
    epsilon = epsilon_theta(time_s, theta_model, theta)
    failed = failure(problem, solution, known, epsilon)
    diagnostics = _diagnostics(best, solution, resolution, known)
    diagnostics |= _against_noise((moved or end).best, likely)
    parts, against = tuple[Part, ...](), [end.weight_against]
    if moved:
        diagnostics["pulls_p"] = moved.contributions.p_of_pulls
        against += [weight_against(moved.contributions.p_of_pulls, REJECTS)] if end.weight_against < 1 else []
    if failed:
        known = known.unknown()
    else:
        parts = tuple(fitted_parts(problem, x, best.residual, best.jacobian))
        lacking = added_number(problem, x, best.curve, best.whitened, likely)
        diagnostics |= {} if lacking is None else {"added_damping": lacking}
        against += [] if lacking is None else [weight_against(chance_of(lacking), REJECTS)]
    value, fixed = problem.physical(x), known.stderr == 0
    law = np.where(fixed, 0.0, model_discrepancy(value, parts)) if any(against) else np.zeros(len(x))
    law *= max(against)
    if moved is end:
        law = np.hypot(law, moved.contributions.excess)
        if moved.contributions.p_of_pulls <= REJECTS:
            law = np.hypot(law, moved.contributions.if_as_stated)
        least = np.where(fixed, 0.0, LINEAR_STEP * np.abs(value))
        law = np.where(moved.contributions.total(known.stderr, law) < least, least, law)
    if problem.settings.profile and not failed:
        known, profiled = with_profile(problem, x, resolution.m, known)
        diagnostics |= {"profile": 1.0} if profiled else {}
    pinned = problem.at_bound(x) & (best.result is None)
    notes = [f"{problem.names[i]} held at its bound" for i in np.flatnonzero(pinned)]
    n_freed = int(problem.varied.sum())
    n_charged = n_freed - int(best.is_wide[best.free].sum()) + problem.settings.loose_release
    aic, bic = (each + best.charge for each in likely.criteria(n_charged))
    diagnostics["charged"] = bic - likely.minus_two_log
    return Fit(
        model=problem.model,
        parameters=problem.names,
        value=value,
        stderr=known.stderr,
        ci95_low=known.low,
        ci95_high=known.high,
        discrepancy=np.where(np.isfinite(known.stderr), law, np.nan),
        covariance=known.covariance,
        units=tuple(map(unit_of, problem.names)),
        time=time_s,
        theta=theta,
        theta_model=theta_model,
        residual=theta_model - theta,
        epsilon_theta=epsilon,
        final_time_s=float(time_s.max()),
        epsilon_holdout=holdout,
        aic=aic,
        bic=bic,
        n_parameters=n_freed,
        success=not failed,
        message=failed or "; ".join(["converged", *notes]),
        diagnostics=diagnostics,
        parts=parts,
        result=solution.result and in_si_units(solution.result, problem, x, known.covariance),
    )


def _pulled(laboratory: Laboratory | None, found: Contributions) -> str:
    """The input with the largest pull, and by how much it would be off without its prior, in words."""
    j = found.most_pulled
    if laboratory is None or j is None:
        return ""
    source, pull = found.inputs[j], found.pulls[j]
    alone = found.moved[j] / max(1 - found.remaining[j] ** 2, np.finfo(float).eps)
    by = f"{alone * source.u:+.3g} {source.unit}".replace(" 1", "")
    return f"{source.label} off by {by}, {abs(pull):.1f} standard uncertainties"


def _diagnostics(
    best: Posterior, solution: Solution, resolution: Resolution, known: Uncertainty
) -> dict[str, float]:
    """Diagnostics of every fit; see `Fit`."""
    residual = best.residual
    sigma = float(np.sqrt(np.mean([m.sigma_theta**2 for m in best.problem.motions])))
    scatter = float(np.sqrt(residual @ residual / len(residual)))
    return {
        "evaluations": float(solution.evaluations),
        "rtol": best.problem.rtol,
        "integrator_error": resolution.shift,
        "averaged": float(resolution.m),
        "residual_over_sigma": scatter / sigma if sigma else float("nan"),
        "coloured": float(known.coloured),
        "widened": known.widened,
        "white": float(is_white(residual)),
    }


def _against_noise(best: Posterior, likely: Likelihood) -> dict[str, float]:
    """Diagnostics of a residual beside the noise at rest; see `Fit`."""
    rest = best.against_rest
    return {
        "mean_square": best.mean_square,
        "noise": float(rest.is_noise),
        "noise_p": rest.p,
        "noise_ratio": rest.ratio,
        "noise_low_hz": rest.low_hz,
        "noise_high_hz": rest.high_hz,
        "effective_samples": likely.effective,
    }
