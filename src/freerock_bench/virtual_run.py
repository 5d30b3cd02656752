"""Virtual runs with known truth for the Monte-Carlo studies of the identification.

Every case is drawn from its own seed, so that a study's numbers do not depend on the number of processes.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver, simulate_theta
from freerock.noise.at_rest import noise_at_rest
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.disturbances import correlated

SEED = 2017
RATE_HZ = 2000.0
HOLD_S = 1.0
T0_STDERR_S = 2e-4
LONGEST_S = 8.0
Row = dict[str, Any]
CORRELATED_S = {"2 ms": 2e-3, "20 ms": 2e-2, "200 ms": 0.2}  # correlation times of noise
REST_SIGMAS = 1.0  # a run lasts until the swings are lost in the noise


@dataclass(frozen=True)
class Truth:
    """One virtual run: block, law, release and noise.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
        With its true contact width.
    parameters : mapping of str to float
        SI units.
    theta0 : float
        Angle of release [rad].
    sigma_theta : float
        Standard deviation of the white noise of θ [rad].
    noise : str
        "white"; "2 ms" and other keys of `CORRELATED_S`, all of it correlated over that time; "mains", white
        with mains interference of 0.5 σ; "coloured", half of its variance correlated over 5 ms.
    rtol : float
        Of the integrator that gives the true motion.
    """

    model: str
    block: Block
    parameters: Mapping[str, float]
    theta0: float
    sigma_theta: float
    noise: str = "white"
    rtol: float = 1e-10

    @property
    def nominal(self) -> Block:
        """The block as it was measured: of its full width."""
        return replace(self.block, contact_width_m=None)

    def motion(self, time_s: Floats) -> tuple[Floats, str]:
        """True θ at instants since the release [s], and its outcome as in `simulate_theta`."""
        candidate = CANDIDATES[self.model]
        return simulate_theta(
            candidate.law,
            self.block,
            self.parameters,
            time_s,
            theta0=self.theta0,
            rules=candidate.rules(),
            solver=Solver(self.rtol),
        )


def noise(truth: Truth, n: int, generator: np.random.Generator) -> Floats:
    """Noise of θ at RATE_HZ, shape (n,) [rad]."""
    if truth.noise in CORRELATED_S:
        return truth.sigma_theta * correlated(n, CORRELATED_S[truth.noise], RATE_HZ, generator)
    white = generator.standard_normal(n)
    if truth.noise == "coloured":
        white = math.sqrt(0.5) * (white + correlated(n, 5e-3, RATE_HZ, generator))
    elif truth.noise == "mains":
        phase = generator.uniform(0, 2 * math.pi)
        mains = np.sin(2 * math.pi * 50 * np.arange(n) / RATE_HZ + phase)
        white = white + 0.5 * math.sqrt(2) * mains
    return truth.sigma_theta * white


def virtual_motion(
    truth: Truth,
    generator: np.random.Generator,
    exact: tuple[Floats, Floats] | None = None,
    still_s: tuple[float, float] | None = None,
) -> Motion | None:
    """A measured run: θ(t) with noise, and what the rests beside it give; None where the block overturns.

    Parameters
    ----------
    truth : Truth
    generator : numpy.random.Generator
    exact : (ndarray, ndarray), shape (n_time,), optional
        The true motion, time and θ [s, rad], where another than the law's is wanted.
    still_s : (float, float), optional
        Lengths of the hold before the run and of the rest after it [s], which show the noise at rest; none
        follows a run that is not over after LONGEST_S. By default a hold of HOLD_S, which shows its spread
        only.
    """
    time_s = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    if exact is not None:
        time_s, theta = exact
    else:
        theta, outcome = truth.motion(time_s)
        if outcome == "overturned":
            return None
    hold, rest = (int(span * RATE_HZ) for span in still_s or (HOLD_S, 0.0))
    error = noise(truth, hold + len(theta) + rest, generator)
    moving = np.flatnonzero(np.abs(theta) > REST_SIGMAS * truth.sigma_theta)
    n = min(len(theta), moving[-1] + 200)
    t0 = T0_STDERR_S * generator.standard_normal()
    record = np.concatenate([np.full(hold, truth.theta0), theta[:n], np.zeros(rest if n < len(theta) else 0)])
    record = record + error[: len(record)]
    held, after = record[:hold], record[hold + n :]
    return Motion(
        time_s=time_s[:n] + t0,
        theta=record[hold : hold + n],
        sigma_theta=float(np.std(held)),
        theta0=float(np.mean(held)),
        theta0_stderr=truth.sigma_theta * _stderr_of_mean(truth.noise, hold),
        t0_stderr=T0_STDERR_S,
        fit_start_s=0.0,
        noise=noise_at_rest([held, after], RATE_HZ) if still_s else None,
    )


def converted(theta: Floats, step: float, generator: np.random.Generator) -> Floats:
    """θ through a converter of a step, its zero anywhere within a step [rad]."""
    if not step:
        return theta
    offset = generator.uniform()
    return np.asarray(step * (np.round(theta / step + offset) - offset))


def _stderr_of_mean(kind: str, n: int) -> float:
    """Of n samples of noise, in standard deviations of one, with a margin for its colour."""
    correlated = 2 * RATE_HZ * CORRELATED_S.get(kind, 0.0)
    return min(1.0, max(3.0, math.sqrt(correlated)) / math.sqrt(n))


def draw_truth(model: str, noises: Sequence[str], generator: np.random.Generator) -> Truth:
    """A random law, block and noise, over the whole range the models are made for."""
    block, theta0, _ = list(CONFIGURATIONS.values())[generator.integers(3)]
    k = 10 ** generator.uniform(6, 8)
    parameters = {
        "housner": {"r": generator.uniform(0.85, 0.995)},
        "winkler": {"k": k, "c": k * 10 ** generator.uniform(-3, math.log10(2e-2))},
        "hunt_crossley": {"k": k, "lambda": k * generator.uniform(5, 50)},
    }[model]
    sigma = math.radians(10 ** generator.uniform(math.log10(0.005), math.log10(0.05)))
    return Truth(model, block, parameters, theta0, sigma, noises[int(generator.integers(len(noises)))])


Draw = Callable[[str, Sequence[str], np.random.Generator], Truth]


def drawn_run(
    model: str, noises: Sequence[str], key: Sequence[int], draw: Draw = draw_truth
) -> tuple[Truth, Motion]:
    """A random truth whose block does not overturn, and its measured run."""
    generator = np.random.default_rng([SEED, *key])
    while True:
        truth = draw(model, noises, generator)
        if motion := virtual_motion(truth, generator):
            return truth, motion
