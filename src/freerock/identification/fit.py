"""Fits of a candidate to the runs of a record, with impacts that scatter."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.errors import of_kind
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.fitted import Curve, Evidence, Fit, ImpactScatter, Minimizer
from freerock.identification.posed import Ended, minimised
from freerock.identification.posterior import Posterior
from freerock.identification.run_model import RTOL, RunModel
from freerock.identification.scatter import NONE, Scatter, find_scatter
from freerock.identification.settings import check
from freerock.identification.start import START, Followed, in_step, n_lifting, whole_s, with_impacts
from freerock.identification.u_total import uncertainty_of
from freerock.models.block import Block
from freerock.models.given import legal
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class RoundSettings:
    """When the fits of a record end; by judgement.

    Parameters
    ----------
    most : int
        Rounds of σ_r and of the level.
    changed : float
        Relative change of σ_r or of the level from which a further round is worth its time.
    ahead : float
        A search has ended where its objective is predicted to fall by less. A step of one standard
        uncertainty lowers it by 1.
    poor, lost : float
        A run is sought once more from so many times the mean square of the best run of its record; `lost`
        counts where the law is far from the runs. A run whose residual is `lost` times the noise has no exact
        σ_r, and is fitted again for its level alone.
    exact : (int, float)
        Evaluations of the residual in a round, and the relative change at which it ends.
    most_far, rough : int, (int, float)
        Rounds at most, and evaluations and relative change as of `exact`, of a law that is far from the runs.
    """

    most: int = 4
    changed: float = 0.15
    ahead: float = 0.03
    poor: float = 1.3
    lost: float = 10.0
    exact: tuple[int, float] = (12, 5e-6)
    most_far: int = 2
    rough: tuple[int, float] = (8, 1e-4)


ROUNDS = RoundSettings()
AT_BOUND = 1e-3  # of a bound that the configuration gives: a number this close to it lies there


def fit_run(candidate: str, block: Block, motion: Motion, settings: FitSettings | None = None) -> Fit:
    """Identify a candidate on one run; see `fit_record`.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> import numpy as np
    >>> time = np.arange(0, 2, 2e-3)
    >>> theta = freerock.simulate("housner", block, {"r": 0.93}, time, theta0=0.17).theta
    >>> theta += 1e-4 * np.random.default_rng(1).standard_normal(time.size)
    >>> motion = freerock.Motion(time, theta, 1e-4, theta0=0.17, theta0_stderr=2e-5, t0_stderr=5e-4)
    >>> fit = freerock.fit_run("housner", block, motion)
    >>> print(f"r = {fit.values['r']:.4f}, agrees: {fit.evidence.agrees}")
    r = 0.9300, agrees: True
    """
    return fit_record(candidate, block, {1: motion}, settings)[1]


def fit_record(
    candidate: str, block: Block, motions: Mapping[int, Motion], settings: FitSettings | None = None
) -> dict[int, Fit]:
    """Identify a candidate on each run of a record, with one scatter of the impacts for all.

    A scan over a grid gives starts on the first swing. From there the first swings are fitted and then the
    whole run, with the impacts free. σ_r follows from the marginal likelihood.

    Parameters
    ----------
    candidate : str
        A key of `freerock.models.laws.CANDIDATES`: a law, such as "hunt_crossley", or a law with other
        kinematics or with the contact width freed: "hunt_crossley_pivoting", "housner_width".
    block : Block
    motions : mapping of int to Motion
        Measured runs by their number.
    settings : FitSettings, optional
        What is freed besides the law's numbers, and what is given of these.

    Returns
    -------
    dict of int to Fit

    Raises
    ------
    FreerockError
        Unknown candidate or nuisance; fewer valid samples than parameters.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> record = freerock.load("raw/palermo_virtual/config2_marble.tdms", block, laser)
    >>> fits = freerock.fit_record("hunt_crossley", block, record.motions)
    >>> print([f"{fit.values['k']:.2e}" for fit in fits.values()])
    ['6.90e+06', '6.87e+06', '6.70e+06']
    """
    of_kind("motions", motions, Mapping, "give runs by their number, as record.motions")
    if not motions:
        return {}
    ends = Followers(candidate, block, motions, settings or FitSettings()).ends()
    return settled(ends)


class Followers:
    """The runs of a record, each followed to its end with wide priors of the impacts.

    Parameters are those of `fit_record`, and the errors; `others` holds other candidates on the first run.
    """

    def __init__(
        self,
        candidate: str,
        block: Block,
        motions: Mapping[int, Motion],
        settings: FitSettings,
        others: Mapping[str, Followed] = MappingProxyType({}),
    ) -> None:
        check(candidate, block, settings)
        for each in motions.values():
            of_kind("motion", each, Motion, "give run.motion or freerock.Motion(...)")
        self.models = {run: RunModel(candidate, block, each, settings) for run, each in motions.items()}
        self.first = next(iter(self.models))
        self.followed = Followed(self.models[self.first], others=others)

    @cached_property
    def end_of_first(self) -> Ended:
        """Where the first run ends."""
        return self.followed.whole()

    def ends(self, roughly: bool = False) -> dict[int, Ended]:
        """Where each run ends; a run starts with the law's numbers of the best run before it.

        One that ends poorly beside the best is sought once more.

        `roughly` of a law that is far from the runs.
        """
        found = {self.first: self.followed.whole(roughly) if roughly else self.end_of_first}
        for run, model in self.models.items():
            if run not in found:
                best = min(found.values(), key=lambda end: end.over_noise)
                found[run] = Followed(model, best).whole(roughly)
        best = min(found.values(), key=lambda end: end.over_noise)
        poor = (ROUNDS.lost if roughly else ROUNDS.poor) * max(best.over_noise, 1.0)
        for run, model in self.models.items():
            if found[run].over_noise > poor:
                by_itself = not roughly and run != self.first
                again = Followed(model, None if by_itself else best).whole(roughly)
                found[run] = min(found[run], again, key=lambda end: end.over_noise)
        return found


def settled(ends: Mapping[int, Ended], roughly: bool = False) -> dict[int, Fit]:
    """The fits of the runs of a record, with one σ_r.

    Parameters
    ----------
    ends : mapping of int to Ended
        Of `Followers.ends`.
    roughly : bool
        Of a law that is far from the runs: few rounds, and none of a run whose residual is `ROUNDS.lost`
        times the noise.
    """
    now = dict[int, Ended]()
    for run, end in ends.items():
        model = end.posed.model
        samples = replace(model.until(whole_s(model.motion), 10**9), m=model.noise.averaged)
        now[run] = replace(end, posed=replace(end.posed, samples=samples, rtol=RTOL))
    posteriors = {run: Posterior.of(end) for run, end in now.items()}
    scatter = find_scatter([each.told for each in posteriors.values()])
    most, search = (ROUNDS.most_far, ROUNDS.rough) if roughly else (ROUNDS.most, ROUNDS.exact)
    near = [run for run, each in posteriors.items() if not roughly or each.goodness.over_noise <= ROUNDS.lost]
    due = near
    for _ in range(most):
        for run in due:
            now[run] = _round(now[run], scatter.sigma_r, posteriors[run].level(), search)
            posteriors[run] = Posterior.of(now[run])
        if scatter.sigma_r:  # 0 is kept: the impacts are no longer free
            scatter = find_scatter([each.told for each in posteriors.values()])
        due = [run for run in near if not _is_steady(now[run], posteriors[run], scatter.sigma_r)]
        if not due:
            break
    return {run: _finished(posteriors[run], now[run], scatter) for run in now}


def _is_steady(end: Ended, posterior: Posterior, sigma_r: float) -> bool:
    """Whether another round would change little of a run."""
    if not math.exp(-ROUNDS.changed) < posterior.level() / end.posed.level < math.exp(ROUNDS.changed):
        return False
    if posterior.goodness.over_noise > ROUNDS.lost:
        return True
    before = end.posed.sigma_r
    same = before == sigma_r or (before * sigma_r > 0 and abs(math.log(sigma_r / before)) < ROUNDS.changed)
    return same and (end.result.success or posterior.ahead < ROUNDS.ahead)


def _round(end: Ended, sigma_r: float, level: float, search: tuple[int, float]) -> Ended:
    """The fit of a run to all its samples."""
    model = end.posed.model
    start = with_impacts(end.at, 0)
    if sigma_r:
        start = in_step(model, end.at, whole_s(model.motion), START.lost)
        start = with_impacts(start, n_lifting(model, start))
    found = minimised(replace(end.posed, sigma_r=sigma_r, level=level), start, *search)
    found.result.nfev += end.result.nfev
    return found


def _finished(posterior: Posterior, ended: Ended, scatter: Scatter) -> Fit:
    """The fit of a run, of the linear model where it ended."""
    model, at, n = ended.posed.model, ended.at, posterior.n_names
    uncertainty, covariance = uncertainty_of(posterior)
    found = posterior.goodness
    curve = Curve(model.whole.time_s, model.whole.theta, model.curve(at, model.whole.time_s))
    epsilon = epsilon_theta(curve.time, curve.theta_model, curve.theta)
    message = _failure(ended, posterior, epsilon)
    first = n + at.inputs.size
    of_impacts = ImpactScatter(
        scatter if at.impacts.size else NONE,
        at.impacts,
        np.sqrt(np.maximum(np.diag(posterior.covariance)[first:], 0.0)),
        posterior.covariance[first:, first:],
        posterior.covariance[:n, first:],
    )
    evidence = Evidence(
        epsilon,
        found.agrees,
        found.p,
        found.over_noise,
        found.low_hz,
        found.high_hz,
        posterior.minus_two_log(),
        len(model.law_names),
        int(ended.result.nfev),
    )
    each = np.ix_(posterior.varied, posterior.varied)
    n_priors = len(posterior.rows) - len(posterior.residual)
    # neighbours share slow noise: not all samples count as independent ones of the level
    independent = (posterior.level(np.empty(0, int)) / ended.posed.level) ** 2
    _complete(ended.result, covariance[each], n_priors + independent * (ended.result.ndata - n_priors))
    return Fit(
        model.candidate,
        {name: at.values[name] for name in model.names},
        uncertainty,
        curve,
        evidence,
        of_impacts,
        not message,
        message or "converged",
        ended.result,
        Minimizer(ended.minimizer, ended.result),
        posterior,
    )


def _failure(ended: Ended, posterior: Posterior, epsilon: float) -> str:
    """Why a fit is not to be used; "" of one that is."""
    if not np.isfinite(epsilon) or epsilon > 1:
        return "worse than a block at rest: ε_θ above 1"
    model = ended.posed.model
    for name, given in model.settings.given(model.candidate).items():
        each = ended.result.params[legal(name)]
        ends = [end for end in (given.min, given.max) if end is not None and math.isfinite(end)]
        if each.vary and any(math.isclose(each.value, end, rel_tol=AT_BOUND) for end in ends):
            return f"{name} lies at its bound of fits.parameters"
    diagonal = np.diag(posterior.covariance)[: posterior.n_names][posterior.varied[: posterior.n_names]]
    if not np.isfinite(diagonal).all() or (diagonal <= 0).any():
        return "the run does not determine the parameters"
    return ""


def _complete(result: "lmfit.minimizer.MinimizerResult", covariance: Floats, n_data: float) -> None:
    """Give a result the covariance of the numbers that vary, and what lmfit has of so many independent data.

    Standard errors, correlations and statistics follow.
    """
    stderr = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    result.covar, result.errorbars = covariance, True
    for i, name in enumerate(result.var_names):
        parameter = result.params[name]
        parameter.stderr = float(stderr[i])
        parameter.correl = {
            other: float(covariance[i, j] / (stderr[i] * stderr[j]))
            for j, other in enumerate(result.var_names)
            if j != i and stderr[i] > 0 and stderr[j] > 0
        }

    result.ndata = max(round(n_data), result.nvarys + 1)
    result.nfree = result.ndata - result.nvarys
    result.redchi = result.chisqr / result.nfree
    likelihood = result.ndata * math.log(result.chisqr / result.ndata)
    result.aic = likelihood + 2 * result.nvarys
    result.bic = likelihood + math.log(result.ndata) * result.nvarys
