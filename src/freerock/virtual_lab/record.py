"""The virtual laboratory: simulated records of free-rocking tests, with their truth.

    python -m freerock.virtual_lab.record raw/palermo_virtual

writes six records, three blocks (Table 1) on two foundations (Table 2 of Spanos et al. 2017,
doi:10.1016/j.proeng.2017.09.024), and their truth. Nothing in them was measured.

A record goes: rest; then for every release a tilt by hand (the hand in the beam now and then), a hold by a
finger, the finger's fading support, free rocking to rest, a pause. The law of motion restrains the base
centre, as the models do; for the laser the block turns by the same θ about its corner (see
`freerock.rotation.beam`).
"""

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import accelerations, contact_force, static_depth
from freerock.models.simulate import simulate
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.sensor import Laser

CONFIGURATIONS = {  # Table 1 with its release angle [rad], and the laser that suits the block
    "config1": (Block(0.42, 0.07, 8.67), math.radians(6), Laser("horizontal", 0.22, 0.1)),
    "config2": (Block(0.28, 0.07, 5.84), math.radians(10), Laser("horizontal", 0.20, 0.1)),
    "config3": (Block(0.14, 0.07, 2.98), math.radians(20), Laser("horizontal", 0.10, 0.1)),
}
FOUNDATIONS = {  # Table 2, proposed model
    "marble": {"k": 6.88e6, "lambda": 1.30e8},
    "aerstop": {"k": 2.86e6, "lambda": 8.16e7},
}
THETA_DECIMALS = (
    6  # motion is integrated to 1e-12 and kept to 1 µrad: no byte hangs on a processor's last digit
)
REST_RAD = 2e-5  # the operator's eye: below this the block has come to rest
VOLTS = (  # what the truth tells of a laser: all its outputs are volts
    *("beam", "position_m", "range_m", "face", "sign", "release_side", "volts_at_start", "volts_at_end"),
    *("valid_low_v", "valid_high_v", "error_level_v", "error_tolerance_v"),
)
START = "2017-05-02T09:00:00"


@dataclass(frozen=True)
class Noise:
    """What sensor and converter add: white noise, hum, slow drift [V], and the converter's resolution."""

    white_v: float = 2e-3
    hum_v: float = 1e-3
    hum_hz: float = 50.0
    drift_v: float = 1e-3
    drift_period_s: float = 120.0
    bits: int = 24
    span_v: float = 10.5


@dataclass(frozen=True)
class Release:
    """One release: how the operator does it, and the parameters of the law on that occasion.

    Parameters
    ----------
    theta0 : float
        Held angle [rad], positive clockwise.
    parameters : mapping
        Parameters of the model, see `freerock.models`.
    tilt_s, held_s, fade_s, pause_s : float
        Durations of the tilt by hand, of the hold, of the fading of the finger's support and of the pause
        after the block has come to rest [s]. fade_s = 0 is a sudden release.
    blocked_s : sequence of (float, float)
        When, counted from the start of the tilt, a hand is in the beam [s].
    """

    theta0: float
    parameters: Mapping[str, float]
    tilt_s: float = 1.5
    held_s: float = 2.0
    fade_s: float = 0.01
    pause_s: float = 2.0
    blocked_s: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True)
class VirtualRecord:
    """A simulated record: time [s], true θ [rad] (NaN once overturned), converter counts and the truth."""

    time_s: np.ndarray
    theta: np.ndarray
    counts: np.ndarray
    volts_per_count: float
    truth: dict = field(repr=False)

    @property
    def volts(self) -> np.ndarray:
        """Volts as a reader of the record gets them."""
        return self.counts * self.volts_per_count


def simulate_record(
    block: Block,
    laser: Laser,
    model: str,
    releases: Sequence[Release],
    *,
    seed: int,
    rate_hz: float = 2000.0,
    rest_s: float = 2.0,
    longest_s: float = 20.0,
    zero_v: float = 5.0,
    noise: Noise = Noise(),
    faults: Sequence[Callable] = (),
    **options,
) -> VirtualRecord:
    """Simulate one record.

    Parameters
    ----------
    block : Block
    laser : Laser
    model : str
        "housner", "winkler" or "hunt_crossley".
    releases : sequence of Release
    seed : int
        Of the noise.
    rate_hz : float
        Sampling rate [Hz].
    rest_s : float
        Rest before the first tilt [s].
    longest_s : float
        Rocking is followed at most this long [s].
    zero_v : float
        Sensor output at rest [V].
    noise : Noise
    faults : sequence of callable
        Each takes (time_s, volts, generator) and returns volts, between sensor and converter.
    **options
        Passed on to `freerock.models.simulate.simulate` from the moment the finger has left, such as
        debonding and rtol.

    Returns
    -------
    VirtualRecord
    """
    options = {"debonding": "geometric", "rtol": 1e-12} | options
    clock, theta, runs = rest_s, [np.zeros(math.ceil(rest_s * rate_hz))], []
    for number, release in enumerate(releases, 1):
        part, truth, clock = _release(block, model, release, clock, rate_hz, longest_s, options)
        theta.append(part)
        runs.append({"run": number} | truth)
    theta = np.round(np.concatenate(theta), THETA_DECIMALS)
    time_s = np.arange(theta.size) / rate_hz

    generator = np.random.RandomState(seed)  # its streams, unlike a Generator's, never change with NumPy
    volts = zero_v + displacement_from_rotation(theta, block, laser) / laser.metres_per()
    volts[~((volts >= laser.valid_low_v) & (volts <= laser.valid_high_v))] = laser.error_level_v
    for start, end in (blocked for run in runs for blocked in run["blocked_s"]):
        volts[(time_s >= start) & (time_s < end)] = laser.error_level_v
    phases = generator.uniform(0, 2 * np.pi, 2)
    volts += noise.hum_v * np.sin(2 * np.pi * noise.hum_hz * time_s + phases[0])
    volts += noise.drift_v * np.sin(2 * np.pi * time_s / noise.drift_period_s + phases[1])
    volts += noise.white_v * generator.standard_normal(time_s.size)
    for fault in faults:
        volts = fault(time_s, volts, generator)

    top = 2 ** (noise.bits - 1)
    counts = np.clip(np.rint(volts * (top / noise.span_v)), -top, top - 1).astype(np.int32)
    truth = {
        "origin": "simulated",
        "model": model,
        "debonding": options["debonding"],
        "kinematics": "base centre restrained in the law; for the laser the block turns by θ about a corner",
        "block": {key: value for key, value in asdict(block).items() if value is not None},
        "laser": {key: value for key, value in asdict(laser).items() if key in VOLTS},
        "noise": asdict(noise),
        "zero_v": zero_v,
        "seed": seed,
        "sampling_rate_hz": rate_hz,
        "duration_s": theta.size / rate_hz,
        "runs": runs,
    }
    return VirtualRecord(time_s, theta, counts, noise.span_v / top, truth)


def _release(block, model, release, clock, rate_hz, longest_s, options):
    """θ [rad] at the samples from the start of a tilt to the end of the pause, the truth, that end [s]."""
    hold, let_go = clock + release.tilt_s, clock + release.tilt_s + release.held_s
    free = let_go + release.fade_s
    first = math.ceil(clock * rate_hz)
    grid = np.arange(first, math.ceil((free + longest_s) * rate_hz)) / rate_hz

    share = np.clip((grid - clock) / release.tilt_s, 0, 1)
    theta = release.theta0 * share**3 * (10 - 15 * share + 6 * share**2)
    fading, rocking = (grid >= let_go) & (grid < free), grid >= free
    theta[fading], state = _fade(block, model, release, grid[fading] - let_go, options["debonding"])
    motion = simulate(model, block, release.parameters, grid[rocking] - free, **state, **options)
    theta[rocking] = motion.theta

    moving = np.flatnonzero(np.abs(theta) > REST_RAD)  # NaN, once overturned, is not
    rest = round(float(grid[moving[-1]]) + 1 / rate_hz, 6) if moving.size else free
    end = rest + release.pause_s
    lifted = motion.time[motion.contact != 0]
    impacts = motion.impacts[motion.impacts < lifted[-1]] if lifted.size else motion.impacts[:0]
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
    return theta[: math.ceil(end * rate_hz) - first], truth, end


def _fade(block, model, release, times, debonding):
    """θ [rad] while the finger's holding moment fades as (1 + cos)/2, and the state at the end of it."""
    from scipy.integrate import solve_ivp

    theta0 = release.theta0
    if release.fade_s == 0:
        return np.empty(0), {"theta0": theta0}

    def support(t):
        return 0.5 * (1 + math.cos(math.pi * min(t / release.fade_s, 1.0)))

    if model == "housner":
        start = [theta0, 0.0]

        def rates(t, y):
            fall = -math.copysign(block.p**2 * math.sin(block.theta_cr - abs(y[0])), theta0)
            return [y[1], (1 - support(t)) * fall]

    else:
        k, c, lam = (release.parameters.get(key, 0.0) for key in ("k", "c", "lambda"))
        start = [theta0, 0.0, static_depth(block, k, theta0), 0.0]
        moment = contact_force(block, k, c, lam, start[2], 0.0, theta0, 0.0, debonding)[1]
        moment -= block.mass_kg * GRAVITY * block.h * math.sin(theta0)  # what the finger bears at first

        def rates(t, y):
            z_rate2, theta_rate2 = accelerations(block, k, c, lam, y[2], y[3], y[0], y[1], debonding)
            arm = block.h * math.sin(y[0])
            turn = support(t) * moment / (block.inertia_base - block.mass_kg * arm**2)
            return [y[1], theta_rate2 + turn, y[3], z_rate2 - arm * turn]

    fade = solve_ivp(
        rates, (0, release.fade_s), start, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True, max_step=1e-3
    )
    return fade.sol(times)[0], dict(
        zip(("theta0", "theta_rate0", "z0", "z_rate0"), map(float, fade.y[:, -1]), strict=False)
    )


def write_record(path, record: VirtualRecord, *, group: str = "rocking", channel: str = "laser") -> None:
    """Write a record as NI-style TDMS: converter counts with NI's linear scaling to volts, a waveform.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter, types

    from freerock.files import atomic

    root = {
        "name": Path(path).stem,
        "title": "SIMULATED free-rocking record",
        "author": "freerock.twin, the virtual laboratory",  # its name when the shipped files were written
        "description": "SIMULATED laser record of a free-rocking test; nothing in it was measured.",
    }
    waveform = {
        "NI_ChannelName": channel,
        "unit_string": "V",
        "wf_start_time": np.datetime64(START, "us"),
        "wf_start_offset": 0.0,
        "wf_increment": 1 / record.truth["sampling_rate_hz"],
        "wf_samples": record.counts.size,
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": record.volts_per_count,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": types.Uint32(0xFFFFFFFF),
    }
    with atomic(path) as partial, TdmsWriter(partial) as writer:
        writer.write_segment(
            [RootObject(root), GroupObject(group), ChannelObject(group, channel, record.counts, waveform)]
        )


def palermo_releases(
    alpha: float, parameters: Mapping[str, float], generator, *, number: int = 3, scatter: float = 0.03
) -> list[Release]:
    """Releases as an operator does them: angles within ±0.3°, parameters within ±`scatter`, both uniform.

    Holds and pauses last 1.5 to 2.5 s, tilts 1.2 to 2 s, the finger fades over 5 to 20 ms, and a hand gets
    into the beam up to twice a tilt.
    """

    def draw(low, high, digits=4):
        return round(generator.uniform(low, high), digits)

    releases = []
    for _ in range(number):
        tilt = draw(1.2, 2.0)
        releases.append(
            Release(
                theta0=round(alpha + draw(-math.radians(0.3), math.radians(0.3), 6), 6),
                parameters={
                    name: float(f"{value * (1 + draw(-scatter, scatter, 6)):.6g}")
                    for name, value in parameters.items()
                },
                tilt_s=tilt,
                held_s=draw(1.5, 2.5),
                fade_s=draw(0.005, 0.020),
                pause_s=draw(1.5, 2.5),
                blocked_s=[
                    (start, round(start + draw(0.05, 0.3), 4))
                    for start in (draw(0.1, 0.8) for _ in range(generator.randint(3)))
                ],
            )
        )
    return releases


def palermo_records(*, seed: int = 2017, noise: Noise = Noise()) -> Iterator[tuple[str, VirtualRecord]]:
    """Simulate the virtual Palermo campaign: the name of each test and its record."""
    for configuration, (block, alpha, laser) in CONFIGURATIONS.items():
        for foundation, parameters in FOUNDATIONS.items():
            seed += 1
            generator = np.random.RandomState(seed)
            yield (
                f"{configuration}_{foundation}",
                simulate_record(
                    block,
                    laser,
                    "hunt_crossley",
                    palermo_releases(alpha, parameters, generator),
                    seed=seed,
                    zero_v=round(generator.uniform(4.8, 5.2), 3),
                    noise=replace(noise, hum_hz=round(generator.uniform(49.98, 50.02), 3)),
                ),
            )


def write_campaign(folder, records: Iterable[tuple[str, VirtualRecord]]) -> None:
    """Write records of named tests, as `palermo_records` gives them, with truth.json and manifest.csv.

    Raises
    ------
    FreerockError
        A file can't be written.
    """
    from freerock.files import atomic, write_manifest

    folder, truth = Path(folder), {}
    for test, record in records:
        write_record(folder / f"{test}.tdms", record)
        truth[test] = record.truth
    with atomic(folder / "truth.json") as partial:
        partial.write_text(json.dumps(truth, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    write_manifest(folder, [*(f"{test}.tdms" for test in truth), "truth.json"])


def main(arguments: Sequence[str]) -> int:
    """Write the campaign into the folder given on the command line; returns the exit code."""
    try:
        if len(arguments) != 1:
            raise FreerockError(
                "freerock.virtual_lab.record", "no folder given", "name one, as raw/palermo_virtual"
            )
        write_campaign(arguments[0], palermo_records())
    except FreerockError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
