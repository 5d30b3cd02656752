"""Records of blocks whose impacts scatter, with their truth, by `springs`: as volts and as θ(t).

Block, foundation, law and kinematics come in turn, thirty make a round. Inputs are off by normal draws of
what is stated of them, by callipers or by a rule. A record has three runs, and the numbers of the next one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock_bench.springs import Motion, Scene, read, restitution_of

RATE_HZ, RUNS = 2000.0, 3
SIGMA_RAD = np.radians(0.006)  # of the noise of θ(t)
NOISE_V, ZERO_V = 2e-3, 5.0
T0_STDERR_S = 2e-4  # of θ(t)
FADES_S, AT_ONCE_S, REST_S = (3e-3, 12e-3), (1e-7, 1e-7), 2.0
BEAMS_M = {"config1": 0.22, "config2": 0.20, "config3": 0.10}
CASES = [("hunt_crossley", "guided"), ("hunt_crossley", "pivoting"), ("winkler", "guided")]
CASES += [("winkler", "pivoting"), ("housner", "pivoting")]
INPUTS = ("height_m", "width_m", "mass", "position_m", "scale_fraction", "sampling_rate_fraction")
KNOWN = {  # standard uncertainties of these; that of the mass as a share
    "exact": dict.fromkeys(INPUTS, 0.0),
    "callipers": dict(zip(INPUTS, (3e-5, 3e-5, 1e-3, 2e-4, 5e-4, 2e-5), strict=True)),
    "rule": dict(zip(INPUTS, (3e-4, 3e-4, 1e-3, 6e-4, 1e-3, 6e-5), strict=True)),
}
SPREADS = (0.0, 0.02)  # of ln k, ln c, ln λ, and of ln(1 - r), between runs


@dataclass(frozen=True)
class Truth:
    """What is true of a record, and what is stated of it.

    Parameters
    ----------
    law, kinematics, block_name, foundation : str
    sigma_r : float
        Spread of the impacts.
    tau : float
        Spread between runs of the logarithm of each parameter (of 1 - r of Housner's).
    parameters : dict of str to float
        Of the foundation: the medians over runs [SI].
    known : str
        A key of `KNOWN`.
    block, stated : Block
        As it truly is, and as it is stated.
    position_m, scale, clock : float
        True height of the beam; true displacement over that read; true over stated time.
    beam_m, range_m : float
        Stated height of the beam, measuring range of the laser.
    """

    law: str
    kinematics: str
    block_name: str
    foundation: str
    sigma_r: float
    tau: float
    parameters: dict[str, float]
    known: str
    block: Block
    stated: Block
    position_m: float
    scale: float
    clock: float
    beam_m: float
    range_m: float = 0.1

    @classmethod
    def drawn(cls, i: int, sigma_r: float, known: str, draw: np.random.Generator) -> Self:
        """The i-th of a cell."""
        (law, kinematics), name = CASES[i % len(CASES)], list(BLOCKS)[i % 3]
        foundation = list(TABLE_2)[i // 3 % 2]
        values = {key: value * draw.uniform(0.9, 1.1) for key, value in TABLE_2[foundation][law].items()}
        if law == "housner":
            values = {"r": TABLE_2[foundation][law]["r"] ** draw.uniform(0.7, 1.5)}
        tau = SPREADS[int(draw.integers(len(SPREADS)))]
        own = law, kinematics, name, foundation, sigma_r, tau, values
        return cls(*own, known, **inputs(BLOCKS[name], BEAMS_M[name], known, draw))

    def of_run(self, draw: np.random.Generator) -> dict[str, float]:
        """Parameters of a run."""
        by = {key: np.exp(self.tau * draw.standard_normal()) for key in self.parameters}
        if "r" in by:
            return {"r": 1 - (1 - self.parameters["r"]) * by["r"]}
        return {key: value * by[key] for key, value in self.parameters.items()}


def inputs(stated: Block, beam_m: float, known: str, draw: np.random.Generator) -> dict[str, Any]:
    """Fields of `Truth` on block and laser: true inputs are off by normal draws of what is known of them."""
    off = {key: each * draw.standard_normal() for key, each in KNOWN[known].items()}
    sizes = stated.height_m + off["height_m"], stated.width_m + off["width_m"]
    found: dict[str, Any] = {"block": Block(*sizes, stated.mass_kg * (1 + off["mass"])), "stated": stated}
    found |= {"position_m": beam_m + off["position_m"], "beam_m": beam_m}
    clock = 1 / (1 + off["sampling_rate_fraction"])
    return found | {"scale": 1 + off["scale_fraction"], "clock": clock}


@dataclass(frozen=True)
class Run:
    """A run of a record.

    Parameters
    ----------
    parameters : dict of str to float
    deltas : ndarray, shape (n_impact,)
        δ of the impacts in turn.
    motion : Motion
        Since the hand begins to leave.
    """

    parameters: dict[str, float]
    deltas: Floats
    motion: Motion


def runs_of(
    truth: Truth, draw: np.random.Generator, fades_s: tuple[float, float] = FADES_S, moved: int = RUNS
) -> list[Run]:
    """The runs of a record, so many of them moved, whose hands leave over times between two."""
    angle, sign = RELEASE_ANGLES[truth.block_name] * draw.uniform(0.6, 1.0), draw.choice([-1.0, 1.0])
    found = list[Run]()
    for i in range(RUNS):
        law, deltas = truth.of_run(draw), truth.sigma_r * draw.standard_normal(400)
        theta0 = float(sign * (angle + np.radians(draw.uniform(-0.3, 0.3))))
        fade_s, impacts = draw.uniform(*fades_s), np.column_stack([1 + deltas, np.ones((400, 2))])
        scene = Scene(truth.block, law, truth.kinematics == "pivoting", theta0, fade_s, impacts=impacts)
        found += [Run(law, deltas, Motion(scene, RATE_HZ / truth.clock))] if i < moved else []
    return found


def volts_of(
    truth: Truth,
    runs: list[Run],
    draw: np.random.Generator,
    noise: Callable[[int, Any], Floats] | None = None,
    sigma_v: float = NOISE_V,
    bits: int = 24,
) -> tuple[Floats, list[float]]:
    """Rest, and of each run tilt, hold, motion, rest, as the laser writes them; stated instants at which the
    hand begins to leave [s].

    Parameters
    ----------
    truth : Truth
    runs : list of Run
    draw : numpy.random.Generator
    noise : callable, optional
        Of a number of samples and a generator, in units of `sigma_v`; white by default.
    sigma_v : float
        Standard deviation of the noise [V].
    bits : int
        Of a converter of ±10 V.
    """
    parts, begins, rest = list[Floats](), list[float](), int(REST_S * RATE_HZ)
    for run in runs:
        states, at = run.motion.record(rest, *(int(each * RATE_HZ) for each in draw.uniform(1.5, 2.5, 2)))
        begins.append((sum(part.size for part in parts) + at) / RATE_HZ)
        parts.append(read(states, run.motion.scene, truth.position_m))
        rest = 0
    way = np.concatenate(parts)
    added = noise(len(way), draw) if noise else draw.standard_normal(len(way))
    return written(10 / truth.range_m * (way - way[0]) / truth.scale, draw, sigma_v * added, bits), begins


def written(volts: Floats, draw: np.random.Generator, noise: Floats | None = None, bits: int = 24) -> Floats:
    """Volts over those at rest, with noise (white by default) [V], as a converter of ±10 V writes them."""
    noise = NOISE_V * draw.standard_normal(len(volts)) if noise is None else noise
    count = 20.0 / 2**bits
    return np.asarray(count * np.rint((ZERO_V + volts + noise) / count))


def save(path: Path, truth: Truth, runs: list[Run], draw: np.random.Generator) -> None:
    """Write a record as .npz: volts; of each run θ(t) let go at once, and its truth; what is stated."""
    volts, begins = volts_of(truth, runs, draw)
    values: dict[str, Any] = {"sigma_theta": SIGMA_RAD, "t0_stderr": T0_STDERR_S}
    values |= {f"next_{key}": value for key, value in truth.of_run(draw).items()}
    for j, run in enumerate(runs):
        values |= {f"run{j}_{key}": each for key, each in _of_run(truth, run, begins[j], draw).items()}
    write(path, truth, volts, begins, RATE_HZ, values)


def write(
    path: Path, truth: Truth, volts: Floats, begins: list[float], rate_hz: float, more: dict[str, Any]
) -> None:
    """Write volts, what is stated, what is true, and more."""
    known = {key: value for key, value in vars(truth).items() if isinstance(value, str | float)}
    values: dict[str, Any] = {f"true_{key}": value for key, value in known.items()}
    values |= {f"mean_{key}": value for key, value in truth.parameters.items()}
    for key in ("height_m", "width_m", "mass_kg"):
        values |= {f"true_{key}": getattr(truth.block, key), f"stated_{key}": getattr(truth.stated, key)}
    values |= {"stated_position_m": truth.beam_m, "stated_range_m": truth.range_m}
    values |= {f"u_{key}": value for key, value in KNOWN[truth.known].items()}
    values |= {"volts": volts, "begins_s": begins, "rate_hz": rate_hz}
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, **values, **more)


def _of_run(truth: Truth, run: Run, begins_s: float, draw: np.random.Generator) -> dict[str, Any]:
    """Arrays of a run: of θ(t), whose clock begins a little beside the release, and of the volts."""
    off_s, motion = T0_STDERR_S * draw.standard_normal(), run.motion
    noise = SIGMA_RAD * draw.standard_normal(motion.theta.size + 1)
    return run.parameters | {
        "time": np.arange(motion.theta.size) / RATE_HZ - off_s,
        "theta": motion.theta + noise[1:],
        "theta0": motion.scene.theta0,
        "theta0_measured": motion.scene.theta0 + noise[0] / 50,
        "delta": run.deltas[: len(motion.passages_s)],
        **impacts_in_volts(run.motion, begins_s, truth.clock),
    }


def impacts_in_volts(motion: Motion, begins_s: float, clock: float) -> dict[str, Floats]:
    """Instants of the impacts by the stated clock [s], and √(energy after / before) of each."""
    passages_s, restitution = restitution_of(motion)
    return {"volts_impacts_s": begins_s + passages_s / clock, "volts_true_r": restitution}


def make(folder: Path, sigma_r: float, i: int, seed: int, known: str = "", at_once: bool = False) -> Path:
    """Make the i-th record of a cell, unless it is there; of a hand that leaves at once, for θ(t)."""
    path = folder / f"sigma_{1e4 * sigma_r:03.0f}_{i:03d}.npz"
    if not path.exists():
        draw = np.random.default_rng([seed, round(1e6 * sigma_r), i])
        known = known or ("callipers", "rule")[int(draw.integers(2))]
        truth = Truth.drawn(i, sigma_r, known, draw)
        save(path, truth, runs_of(truth, draw, AT_ONCE_S if at_once else FADES_S), draw)
    return path
