"""Which rivals a run will tell from what is expected of it, before any test.

A rival is fitted to the expected motion without noise. What remains between the two, in the noise of the
sensor, is what the data can hold against the rival:

    Δ = Σ(θ_rival - θ_expected)²/σ² + (n_rival - n_expected) ln N,

the expected difference of their Bayesian information criteria (Schwarz 1978, doi:10.1214/aos/1176344136)
under N samples of white noise of standard deviation σ, n being the numbers that each frees.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.identification.search import approach
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.laws import KINEMATICS, MODELS, PAPER_MODELS, law_of
from freerock.planning.cramer_rao import released_theta
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT, candidates, contains, n_freed


@dataclass(frozen=True)
class Rival:
    """The best a rival can do against an expected motion.

    Parameters
    ----------
    model : str
        The rival, a key of `freerock.models.laws.CANDIDATES`.
    values : dict of str to float
        What it frees, at its best: parameters, width, theta0, t0 [SI].
    integral : float
        ∫(θ_rival - θ_expected)² dt [rad² s].
    epsilon_theta : float
        The same over ∫θ_expected² dt: a block that follows its law no better than this can't be told from it.
    span_s : float
        Time over which they were compared [s].
    """

    model: str
    values: dict[str, float]
    integral: float
    epsilon_theta: float
    span_s: float

    def distance(self, sigma_theta: float, sampling_rate_hz: float) -> float:
        """√Σ(Δθ)²/σ under white noise of a standard deviation [rad]."""
        return math.sqrt(self.integral * sampling_rate_hz) / sigma_theta

    def bic_difference(self, n_expected: int, sigma_theta: float, sampling_rate_hz: float) -> float:
        """Δ, where the expected model frees so many numbers."""
        penalty = (len(self.values) - n_expected) * math.log(self.span_s * sampling_rate_hz)
        return self.distance(sigma_theta, sampling_rate_hz) ** 2 + penalty

    def told_apart(self, difference: float, model_error: float, least: float = 10.0) -> bool:
        """Whether Δ is "very strong" evidence (Kass & Raftery 1995, doi:10.1080/01621459.1995.10476572), and
        ε_θ larger than the error expected of the right law."""
        return difference >= least and self.epsilon_theta > model_error


def rivals_of(
    model: str,
    laws: Sequence[str] = PAPER_MODELS,
    kinematics: Sequence[str] = KINEMATICS,
    free: Mapping[str, Sequence[str]] = BY_DEFAULT.free,
) -> tuple[str, ...]:
    """The rivals of an expected model: candidates that free no more numbers; larger ones are not asked.

    A rival that another one holds as a case is left out, and a block that bounces. The arguments but the
    first are those of `freerock.selection.allowed_hypotheses.candidates`.
    """
    most = n_freed(model, free)
    every = candidates(laws, kinematics, free)
    rivals = [name for name in every if name != model and n_freed(name, free) <= most]
    rivals = [name for name in rivals if not law_of(name).bounces]
    return tuple(name for name in rivals if not any(contains(other, name) for other in rivals))


def expected_motion(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    theta0: float,
    span_s: tuple[float, float],
    debonding: str = "geometric",
    samples: int = 800,
    at_rest: float = 1e-3,
) -> Motion:
    """The motion of a candidate without noise, until its rest, as rivals are fitted to it.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
        Of the contact width expected.
    parameters : mapping of str to float
        [SI]
    theta0 : float
        Release angle [rad].
    span_s : (float, float)
        First and last instant that counts [s].
    debonding : str
        "geometric" or "tensionless".
    samples : int
        Of the motion.
    at_rest : float
        Of the release angle: below it a run has ended.

    Raises
    ------
    FreerockError
        The block overturns, or the motion can't be integrated.
    """
    law = {name: parameters[name] for name in MODELS[model]}

    def theta(time_s: Floats) -> Floats:
        return released_theta(model, block, law, time_s, theta0, debonding, 1e-8)

    time_s = np.linspace(0.0, span_s[1], 4 * samples)
    moving = np.flatnonzero(np.abs(theta(time_s)) > at_rest * abs(theta0))
    time_s = np.linspace(0.0, min(1.1 * time_s[moving[-1]], span_s[1]), samples)
    return Motion(time_s, theta(time_s), 0.0, theta0, fit_start_s=span_s[0])


def best_rival(rival: str, block: Block, motion: Motion, settings: FitSettings | None = None) -> Rival:
    """The rival at its nearest to a motion without noise.

    Parameters
    ----------
    rival : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
        As the fits take it.
    motion : Motion
        As from `expected_motion`, evenly spaced.
    settings : FitSettings, optional
    """
    problem = posed(rival, (block,), (motion,), settings or FitSettings())
    samples, x = problem.samples(), approach(problem).x
    theta = problem.curve(x, samples)
    step = float(motion.time_s[1] - motion.time_s[0])
    return Rival(
        rival,
        problem.named(x),
        float(np.sum((theta - samples.theta) ** 2)) * step,
        epsilon_theta(samples.time_s, theta, samples.theta),
        len(samples.theta) * step,
    )
