"""A simulated record of free-rocking tests, with its truth.

A record begins at rest. For every release there follow a tilt by hand (the hand in the beam now and then), a
hold by a finger, the finger's fading support, free rocking to rest, and a pause. For the laser the block
turns by θ about its corner, which does not slide but sinks as the law has it (`freerock.rotation.beam`). That
is how a pivoting block and a rigid one move sideways; a guided one goes b(1 - cosθ) less far.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.block_on_bed import State, lean, static_depth
from freerock.models.kernel import accelerations
from freerock.models.laws import GEOMETRIC, LAWS, Foundation, Rules
from freerock.models.simulate import Response, Solver, simulate
from freerock.rotation.beam import displacement_from_rotation, rotation_from_displacement
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.added_noise import AddedNoise, Disturbance, converted

# Motion is integrated exactly and kept to 1 µrad: no byte depends on a processor's last digit.
EXACT = Solver(rtol=1e-12)
THETA_DECIMALS = 6
KINEMATICS_OF = {
    "guided": "base centre restrained in the law; for the laser the block turns by θ about a corner",
    "pivoting": "the block turns by θ about a corner, in the law and for the laser",
}
REST_RAD = 2e-5  # the operator's eye: below this the block has come to rest
VOLTS = (  # what the truth says of a laser: all its outputs are volts
    *("beam", "position_m", "range_m", "face", "sign", "release_side", "volts_at_start", "volts_at_end"),
    *("valid_low_v", "valid_high_v", "error_level_v", "error_tolerance_v"),
)


@dataclass(frozen=True)
class VirtualRelease:
    """One release: how the operator does it, and the parameters of the law on that occasion.

    Parameters
    ----------
    theta0 : float
        Release angle [rad], positive clockwise.
    parameters : mapping
        Parameters of the model, see `freerock.models`.
    tilt_s, held_s, fade_s, pause_s : float
        Durations of the tilt by hand, of the hold, of the fading of the finger's support and of the pause
        after the block has come to rest [s]. fade_s = 0 is a sudden release.
    blocked_s : sequence of (float, float)
        When, counted from the start of the tilt, a hand is in the beam [s].
    impacts : sequence of float
        δ of each of the first impacts: the rate after it is multiplied by 1 + δ.
    """

    theta0: float
    parameters: Mapping[str, float]
    tilt_s: float = 1.5
    held_s: float = 2.0
    fade_s: float = 0.01
    pause_s: float = 2.0
    blocked_s: Sequence[tuple[float, float]] = ()
    impacts: Sequence[float] = ()


@dataclass(frozen=True)
class Recording:
    """How a record is taken.

    Parameters
    ----------
    rate_hz : float
        Sampling rate [Hz].
    rest_s : float
        Rest before the first tilt [s].
    longest_s : float
        Rocking is followed at most this long [s].
    zero_v : float
        Sensor output at rest [V].
    noise : AddedNoise
    """

    rate_hz: float = 2000.0
    rest_s: float = 2.0
    longest_s: float = 20.0
    zero_v: float = 5.0
    noise: AddedNoise = field(default_factory=AddedNoise)


@dataclass(frozen=True)
class VirtualRecord:
    """A simulated record: time [s], true θ [rad] (NaN once overturned), what of it the beam shows by the
    geometry of a corner that does not sink, converter counts and the truth."""

    time_s: Floats
    theta: Floats
    seen: Floats
    counts: NDArray[np.int32]
    volts_per_count: float
    truth: dict[str, Any] = field(repr=False)

    @property
    def volts(self) -> Floats:
        """Volts as a reader of the record gets them."""
        return np.asarray(self.counts * self.volts_per_count, dtype=float)


def simulate_record(
    block: Block,
    laser: Laser,
    model: str,
    releases: Sequence[VirtualRelease],
    *,
    seed: int,
    recording: Recording = Recording(),
    faults: Sequence[Disturbance] = (),
    rules: Rules = GEOMETRIC,
) -> VirtualRecord:
    """Simulate one record.

    Parameters
    ----------
    block : Block
    laser : Laser
    model : str
        "housner", "winkler" or "hunt_crossley".
    releases : sequence of VirtualRelease
    seed : int
        Of the noise.
    recording : Recording
    faults : sequence of callable
        Each takes (time_s, volts, generator) and returns volts, between sensor and converter.
    rules : Rules
        The rule of debonding and the kinematics.

    Returns
    -------
    VirtualRecord
    """
    rate_hz, noise, clock = recording.rate_hz, recording.noise, recording.rest_s
    runs, parts = [], [np.zeros((2, math.ceil(clock * rate_hz)))]
    for number, release in enumerate(releases, 1):
        part, truth, clock = _release(model, block, rules, release, clock, recording)
        if laser.beam == "vertical" and LAWS[model].is_foundation:
            part[1] -= static_depth(block, Foundation.of(release.parameters), 0.0)  # where its zero is
        parts.append(part)
        runs.append({"run": number} | truth)
    rotation, depth = np.hstack(parts)
    rotation = rotation.round(THETA_DECIMALS)
    time_s = np.arange(rotation.size) / rate_hz
    distance_m = displacement_from_rotation(rotation, block, laser, depth)
    seen = rotation_from_displacement(distance_m, block, laser, np.sign(rotation))
    volts = _volts(laser, time_s, distance_m, runs, recording.zero_v)
    counts = converted(time_s, volts, noise, np.random.RandomState(seed), faults)
    truth = {
        **_law(model, rules),
        "block": {key: value for key, value in asdict(block).items() if value is not None},
        "laser": {key: getattr(laser, key) for key in VOLTS},
        "noise": asdict(noise),
        "zero_v": recording.zero_v,
        "seed": seed,
        "sampling_rate_hz": rate_hz,
        "duration_s": rotation.size / rate_hz,
        "runs": runs,
    }
    return VirtualRecord(time_s, rotation, seen, counts, noise.volts_per_count, truth)


def _law(model: str, rules: Rules) -> dict[str, str]:
    """What the truth says of the law; a rigid block has no choice of kinematics."""
    kinematics = KINEMATICS_OF[rules.kinematics if LAWS[model].is_foundation else "pivoting"]
    return {"origin": "simulated", "model": model, "debonding": rules.debonding, "kinematics": kinematics}


def _volts(
    laser: Laser, time_s: Floats, distance_m: Floats, runs: Sequence[Mapping[str, Any]], zero_v: float
) -> Floats:
    """What the sensor says of its target's displacement, and of the hands in its beam."""
    volts: Floats = zero_v + distance_m / laser.metres_per()
    volts[~((volts >= laser.valid_low_v) & (volts <= laser.valid_high_v))] = laser.error_level_v
    for start, end in (blocked for run in runs for blocked in run["blocked_s"]):
        volts[(time_s >= start) & (time_s < end)] = laser.error_level_v
    return volts


def _release(
    model: str, block: Block, rules: Rules, release: VirtualRelease, clock: float, recording: Recording
) -> tuple[Floats, dict[str, Any], float]:
    """θ [rad] and how deep the lower corner is [m] from the start of a tilt to the end of the pause, shape
    (2, n_time); the truth; that end [s]."""
    rate_hz = recording.rate_hz
    hold, let_go = clock + release.tilt_s, clock + release.tilt_s + release.held_s
    free = let_go + release.fade_s
    first = math.ceil(clock * rate_hz)
    grid = np.arange(first, math.ceil((free + recording.longest_s) * rate_hz)) / rate_hz

    share = np.clip((grid - clock) / release.tilt_s, 0, 1)
    soil = Foundation.of(release.parameters) if LAWS[model].is_foundation else None
    stands = lean(block, soil, 0.0) if soil and block.e else 0.0
    theta = stands + release.theta0 * share**3 * (10 - 15 * share + 6 * share**2)
    fading, rocking = (grid >= let_go) & (grid < free), grid >= free
    held = replace(release, theta0=release.theta0 + stands)
    theta[fading], begin = _fade(model, block, rules, held, grid[fading] - let_go)
    since = grid[rocking] - free
    law: dict[str, Any] = {**release.parameters, "impacts": np.array(release.impacts, float)}
    motion = simulate(model, block, law, since, theta0=begin, rules=rules, solver=EXACT)
    n_lifting = len(_before_lifting(motion)) + 1
    if soil and len(release.impacts) > n_lifting:  # at the passages of a base that rings nothing is hit
        law["impacts"] = law["impacts"][:n_lifting]
        motion = simulate(model, block, law, since, theta0=begin, rules=rules, solver=EXACT)
    theta[rocking] = motion.theta
    depth = np.zeros(grid.size)
    if soil:
        depth[~rocking] = [static_depth(block, soil, each) for each in theta[~rocking]]
        depth[rocking] = motion.z_cb
        depth += block.b * np.abs(np.sin(theta))

    theta -= stands  # where the sensor has its zero
    moving = np.flatnonzero(np.abs(theta) > REST_RAD)  # NaN, once overturned, is not
    rest = round(float(grid[moving[-1]]) + 1 / rate_hz, 6) if moving.size else free
    end = rest + release.pause_s
    impacts = _before_lifting(motion)
    truth = {
        "theta0_rad": release.theta0,
        **release.parameters,
        "hold_start_s": round(hold, 6),
        "release_s": round(let_go, 6),
        "fade_s": release.fade_s,
        "free_s": round(free, 6),
        "impacts_s": np.round(free + impacts, 6).tolist(),
        "rest_s": rest,
        "outcome": motion.outcome,
        "blocked_s": [[round(clock + t, 6) for t in blocked] for blocked in release.blocked_s],
    }
    if release.impacts:
        truth["impact_factors"] = [round(1 + each, 6) for each in release.impacts[: impacts.size]]
    return np.stack([theta, depth])[:, : math.ceil(end * rate_hz) - first], truth, end


def _before_lifting(motion: Response) -> Floats:
    """Instants of the impacts after which a side of the base lifts [s]."""
    lifted = motion.time[motion.contact != 0]
    return motion.impacts[motion.impacts < lifted[-1]] if lifted.size else motion.impacts[:0]


def _fade(
    model: str, block: Block, rules: Rules, release: VirtualRelease, times: Floats
) -> tuple[Floats, State]:
    """θ [rad] while the finger's holding moment fades as (1 + cos)/2, and the state at the end of it."""
    from scipy.integrate import solve_ivp

    theta0, on_bed = release.theta0, LAWS[model].is_foundation
    held = State(0.0, 0.0, theta0, 0.0)
    if on_bed:
        foundation = Foundation.of(release.parameters)
        held = held._replace(z=static_depth(block, foundation, theta0))
    if release.fade_s == 0:
        return np.empty(0), held

    def support(t: float) -> float:
        return 0.5 * (1 + math.cos(math.pi * min(t / release.fade_s, 1.0)))

    if not on_bed:
        start, (critical, p) = [theta0, 0.0], block.corner(theta0)

        def rates(t: float, y: Floats) -> list[float]:
            fall = -math.copysign(p**2 * math.sin(critical - abs(y[0])), theta0)
            return [y[1], (1 - support(t)) * fall]

    else:
        start = [theta0, 0.0, held.z, 0.0]
        law = foundation.constants(block, rules.kinematics == "pivoting")
        tensionless = rules.debonding == "tensionless"

        def turns(theta: float) -> tuple[float, float]:
            """Moment of inertia that a hand moves, over the mass, and how far right the centre of mass is."""
            along, above = block.com(math.sin(theta), math.cos(theta))
            lever = above + law[7] * abs(math.sin(theta))
            return block.inertia_cm / block.mass_kg + lever**2, along

        bears = -accelerations(law, tensionless, held)[1] * turns(theta0)[0]  # the finger at first

        def rates(t: float, y: Floats) -> list[float]:
            z_rate2, theta_rate2 = accelerations(law, tensionless, (y[2], y[3], y[0], y[1]))
            inertia, along = turns(y[0])
            by_hand = support(t) * bears / inertia
            return [y[1], theta_rate2 + by_hand, y[3], z_rate2 - along * by_hand]

    fade = solve_ivp(
        rates, (0, release.fade_s), start, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True, max_step=1e-3
    )
    theta, theta_rate, z, z_rate = map(float, [*fade.y[:, -1], 0.0, 0.0][:4])
    return fade.sol(times)[0], State(z, z_rate, theta, theta_rate)
