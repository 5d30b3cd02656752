"""Are release, release angle and restitution of each impact as certain as stated, whatever the noise?

Motions by SciPy's integrator and equations written out here (docs/physics.md, sections 3 and 8), read by a
beam whose geometry is written out here too, with sixteen kinds of noise, as volts through the public way to
runs and impacts. Nothing is shared with the laws that are fitted.

    python -m freerock.studies.noises results/studies/noises.csv full docs/signals.md

measures (`small`: three records of each noise; `full`: 162, in an hour of processor time) and renews the table
in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.compiled import compiled
from freerock.models.published import TABLE_2
from freerock.rotation.faults import signal_quality
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import Impacts
from freerock.runs.judged import judged_runs
from freerock.runs.quiet import converter_step
from freerock.runs.segment import Run
from freerock.studies.document import publish
from freerock.studies.virtual_run import SEED, Row, rows_of_all
from freerock.virtual_lab.palermo import CONFIGURATIONS

SIZES = {"small": 3, "full": 162}  # records of each noise; eighteen make a round of scenes
RATE_HZ = 2000.0
SIGMA_V = 2e-3
V_PER_M, ZERO_V = 100.0, 5.0
TILT_S, REST_S, LONGEST_S = 1.2, 2.0, 12.0
AT_REST = 2e-5  # [rad]
ALIKE_S = 0.02  # between an impact found and that of the truth
NORMAL_95 = 1.96
KINDS = ("guided", "pivoting", "worn")
BLOCKS, FOUNDATIONS = tuple(CONFIGURATIONS), tuple(TABLE_2)
COLUMNS = ["noise", "record", "scene", "level", "names", "number", "impact", "error", "stderr", "inside"]
MARK = ("<!-- noises -->\n", "<!-- end of the noises -->\n")
Kind = Callable[[Floats, Floats, Any], Floats]


def _correlated(n: int, time_s: float, draw: Any) -> Floats:
    """Noise of variance 1, autoregressive of the first order."""
    a = math.exp(-1 / (RATE_HZ * time_s))
    drive = math.sqrt(1 - a * a) * draw.standard_normal(n)
    return np.asarray(lfilter([1.0], [1.0, -a], drive, zi=[a * draw.standard_normal()])[0])


def _pink(n: int, draw: Any) -> Floats:
    """Noise of variance 1 whose density falls as 1/f."""
    frequency = np.fft.rfftfreq(2 * n)
    frequency[0] = np.inf
    found = np.fft.irfft(np.fft.rfft(draw.standard_normal(2 * n)) / np.sqrt(frequency))[:n]
    return np.asarray(found / np.std(found))


def _hum(n: int, wanders: float, draw: Any) -> Floats:
    """Mains of half the variance 1/4, whose phase goes at random by so much in a second [rad]."""
    phase = draw.uniform(0, 2 * math.pi) + np.cumsum(draw.standard_normal(n)) * wanders / math.sqrt(RATE_HZ)
    return np.asarray(0.5 * math.sqrt(2) * np.sin(2 * math.pi * 50 * np.arange(n) / RATE_HZ + phase))


def _rate(theta: Floats) -> Floats:
    rate = np.abs(np.gradient(theta))
    return np.asarray(rate / rate.max())


def _white(theta: Floats, draw: Any) -> Floats:
    return np.asarray(draw.standard_normal(len(theta)))


NOISES: dict[str, Kind] = {  # in standard deviations of the noise, of the rotation and a generator
    "white": lambda theta, draw, moving: _white(theta, draw),
    "white, ¼ of 50 ms": lambda theta, draw, moving: _white(theta, draw)
    + 0.25 * _correlated(len(theta), 0.05, draw),
    "2 ms": lambda theta, draw, moving: _correlated(len(theta), 2e-3, draw),
    "20 ms": lambda theta, draw, moving: _correlated(len(theta), 0.02, draw),
    "200 ms": lambda theta, draw, moving: _correlated(len(theta), 0.2, draw),
    "hum": lambda theta, draw, moving: _white(theta, draw) + _hum(len(theta), 0.0, draw),
    "wandering hum": lambda theta, draw, moving: _white(theta, draw) + _hum(len(theta), 1.0, draw),
    "1/f": lambda theta, draw, moving: _pink(len(theta), draw),
    "white, ½ of 1/f": lambda theta, draw, moving: _white(theta, draw) + 0.5 * _pink(len(theta), draw),
    **{f"step {step:g} σ": lambda theta, draw, moving: _white(theta, draw) for step in (0.5, 2.0, 5.0, 10.0)},
    "Student's t₃": lambda theta, draw, moving: draw.standard_t(3, len(theta)) / math.sqrt(3),
    "speckle by rate": lambda theta, draw, moving: _white(theta, draw) * (1 + 1.2 * _rate(theta)),
    "speckle by angle": lambda theta, draw, moving: _white(theta, draw)
    * (1 + 1.2 * np.abs(theta) / np.abs(theta).max()),
    "10 ms in motion": lambda theta, draw, moving: _white(theta, draw)
    + moving * _correlated(len(theta), 0.01, draw),
}
STEPS = {name: float(name.split()[1]) for name in NOISES if name.startswith("step")}


@dataclass(frozen=True)
class Scene:
    """A block as it moves, its half width b [m] and law."""

    block: Block
    b: float
    law: tuple[float, float, float]  # k, c, λ
    pivoting: bool
    theta0: float
    fade_s: float
    held_s: float


@dataclass(frozen=True)
class Truth:
    """A record without noise and what is true of it.

    Angles are those that the beam shows by the geometry of a corner that does not sink [rad]; energies above
    rest of release and tops [J].
    """

    scene: Scene
    volts: Floats
    theta: Floats
    moving: Floats
    release_s: float
    theta0: float
    impacts_s: Floats
    peaks: Floats
    energies: Floats


@compiled()
def _bed(z, theta, z_rate, w, b, k, c, lam):  # type: ignore[no-untyped-def]
    """Force [N], moment about the base's centre [N m] and stored energy [J]: k z + c ż + λ z ż, z > 0."""
    sin, cos = math.sin(theta), math.cos(theta)
    low, high = -b, b
    if z - b * abs(sin) < 0.0:
        edge = -z / sin if sin != 0.0 else math.inf
        if sin > 0.0:
            low = max(low, edge)
        else:
            high = min(high, edge)
    force = moment = stored = 0.0
    if high <= low or z + b * abs(sin) <= 0.0:
        return force, moment, stored
    for node in (-(3**-0.5), 3**-0.5):  # exact for cubics
        u = 0.5 * (low + high) + 0.5 * (high - low) * node
        depth, rate = z + u * sin, z_rate + u * w * cos
        part = 0.5 * (high - low) * (k * depth + (c + lam * depth) * rate)
        force, moment = force + part, moment + part * u
        stored += 0.25 * (high - low) * k * depth**2
    return force, moment * cos, stored


@compiled()
def _rates(y, hand, m, inertia, h, b, k, c, lam, pivoting):  # type: ignore[no-untyped-def]
    z, theta, z_rate, w = y
    force, moment, _ = _bed(z, theta, z_rate, w, b, k, c, lam)
    sin, cos = math.sin(theta), math.cos(theta)
    lever, bends = h * cos, -h * sin
    if pivoting:
        lever, bends = lever + b * abs(sin), bends + math.copysign(b * cos, theta)
    turn = (force * h * sin - moment - m * lever * bends * w * w + hand) / (inertia + m * lever**2)
    fall = GRAVITY - force / m - h * sin * turn - h * cos * w * w
    return np.array([z_rate, w, fall, turn])


def scene_of(i: int) -> Scene:
    """The i-th scene: blocks, foundations and kinds in turn."""
    draw = np.random.default_rng([SEED, 35, i])
    name, foundation = BLOCKS[i % 3], FOUNDATIONS[i // 3 % 2]
    kind = KINDS[i // 6 % 3]
    block, angle, _ = CONFIGURATIONS[name]
    table = TABLE_2[foundation]["winkler" if kind == "pivoting" and i // 18 % 2 else "hunt_crossley"]
    soil = {key: value * draw.uniform(0.9, 1.1) for key, value in table.items()}
    worn = draw.uniform(0.92, 0.98) if kind == "worn" else 1.0
    return Scene(
        block,
        block.width_m / 2 * worn,
        (soil["k"], soil.get("c", 0.0), soil.get("lambda", 0.0)),
        kind == "pivoting",
        angle * draw.uniform(0.6, 1.0) * draw.choice([-1, 1]),
        draw.uniform(3e-3, 12e-3),
        round(draw.uniform(1.5, 2.5), 3),  # whole samples
    )


@lru_cache(64)
def truth_of(i: int) -> Truth:
    """The record of the i-th scene without noise."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    scene = scene_of(i)
    block, m = scene.block, scene.block.mass_kg
    width, height = block.width_m, block.height_m
    law = (scene.b, *scene.law)
    body = (m, m * (width**2 + height**2) / 12, height / 2)

    def depth_at(theta: float) -> float:
        def excess(z: float) -> float:
            return float(_bed(z, theta, 0.0, 0.0, *law)[0]) - m * GRAVITY

        return float(brentq(excess, -scene.b, scene.b, xtol=1e-14))

    held = np.array([depth_at(scene.theta0), scene.theta0, 0.0, 0.0])
    hand = -_rates(held, 0.0, *body, *law, scene.pivoting)[3] * _inertia(scene, body)

    def rates(t: float, y: Floats) -> Any:
        support = 0.5 * (1 + math.cos(math.pi * min(t / scene.fade_s, 1.0)))
        return _rates(y, support * hand, *body, *law, scene.pivoting)

    clock = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    options = {"method": "LSODA", "rtol": 1e-10, "atol": 1e-13, "dense_output": True}
    fades = solve_ivp(rates, (0.0, scene.fade_s), held, max_step=1e-3, **options)
    goes = solve_ivp(rates, (scene.fade_s, LONGEST_S), fades.y[:, -1], max_step=5e-3, **options)
    states = np.where(clock < scene.fade_s, fades.sol(clock), goes.sol(clock))
    last = int(np.flatnonzero(np.abs(states[1]) > AT_REST)[-1])
    states = states[:, : last + 1]
    at = REST_S + TILT_S + scene.held_s
    before = np.arange(0.0, at - 0.5 / RATE_HZ, 1 / RATE_HZ)
    share = np.clip((before - REST_S) / TILT_S, 0, 1)
    tilted = scene.theta0 * share**3 * (10 - 15 * share + 6 * share**2)
    grid = np.linspace(0, scene.theta0, 200)
    depths = np.interp(np.abs(tilted), np.abs(grid), [depth_at(each) for each in grid])
    rests = np.zeros(int(scene.held_s * RATE_HZ))
    theta = np.concatenate([tilted, states[1], rests])
    z = np.concatenate([depths, states[0], rests + depth_at(0.0)])
    moving = np.concatenate([0 * tilted, 1 + 0 * states[1], rests])
    fine = np.arange(scene.fade_s, clock[last], 1e-4)
    path = goes.sol(fine)
    passes = np.flatnonzero(path[1, 1:] * path[1, :-1] < 0)
    tops = [i + int(np.argmax(np.abs(path[1, i:j]))) for i, j in zip(passes[:-1] + 1, passes[1:], strict=True)]
    seen = np.array([scene.theta0, *path[1, tops]]), np.array([held[0], *path[0, tops]])
    energy = [_energy(path[:, i], scene, body, law) for i in [0, *tops]]
    at_rest = _energy(np.array([depth_at(0.0), 0.0, 0.0, 0.0]), scene, body, law)
    laser = _laser(i)
    return Truth(
        scene,
        ZERO_V + V_PER_M * _displacement(theta, z, scene, laser),
        theta,
        moving,
        at + scene.fade_s / 2,
        float(_seen(seen[0][:1], seen[1][:1], scene, laser)[0]),
        at + fine[passes[: len(tops)]],
        _seen(*seen, scene, laser),
        np.array(energy) - at_rest,
    )


def _inertia(scene: Scene, body: tuple[float, float, float]) -> float:
    m, inertia, h = body
    theta = scene.theta0
    lever = h * math.cos(theta) + (scene.b * abs(math.sin(theta)) if scene.pivoting else 0.0)
    return inertia + m * lever**2


def _energy(
    y: Floats, scene: Scene, body: tuple[float, float, float], law: tuple[float, float, float, float]
) -> float:
    """Kinetic, of weight and of the bed [J]."""
    z, theta, z_rate, w = y
    m, inertia, h = body
    lever = h * math.cos(theta) + (scene.b * abs(math.sin(theta)) if scene.pivoting else 0.0)
    kinetic = m * ((lever * w) ** 2 + (z_rate + h * math.sin(theta) * w) ** 2) / 2 + inertia * w**2 / 2
    stored = float(_bed(z, theta, 0.0, 0.0, *law)[2])
    return float(kinetic + stored + m * GRAVITY * (h * math.cos(theta) - z))


def _laser(i: int) -> Laser:
    return CONFIGURATIONS[BLOCKS[i % 3]][2]


def _displacement(theta: Floats, z: Floats, scene: Scene, laser: Laser) -> Floats:
    """Of the left face at the beam's height: the block has turned about its lower corner, which has sunk."""
    face, corner = scene.block.width_m / 2, np.sign(theta) * scene.b
    depth = z + scene.b * np.abs(np.sin(theta))
    along = (laser.position + depth - (face + corner) * np.sin(theta)) / np.cos(theta)
    return np.asarray(corner - (face + corner) * np.cos(theta) + along * np.sin(theta) + face)


def _seen(theta: Floats, z: Floats, scene: Scene, laser: Laser) -> Floats:
    """Rotation by the geometry of the nominal block, whose corner does not sink."""
    from dataclasses import replace

    from scipy.optimize import brentq

    nominal = replace(scene, b=scene.block.width_m / 2)
    read = _displacement(theta, z, scene, laser)

    def turned(s: float) -> float:
        def off(angle: float) -> float:
            t = np.array([angle])
            return float(_displacement(t, -nominal.b * np.abs(np.sin(t)), nominal, laser)[0]) - s

        return float(brentq(off, -0.7, 0.7, xtol=1e-13))

    return np.array([turned(float(s)) for s in read])


def record_of(noise: str, i: int) -> tuple[Truth, Floats]:
    """A record without noise, and its volts with noise."""
    truth = truth_of(i)
    draw = np.random.default_rng([SEED, list(NOISES).index(noise), i])
    volts = truth.volts + SIGMA_V * NOISES[noise](truth.theta, draw, truth.moving)
    step = STEPS.get(noise, 0.0) * SIGMA_V or 20.0 / 2**24
    offset = draw.uniform()
    return truth, step * (np.rint(volts / step + offset) - offset)


def measured(noise: str, i: int) -> tuple[Truth, Run, Impacts]:
    """The first run of the i-th record with a noise, on the public way."""
    truth, volts = record_of(noise, i)
    block, laser = truth.scene.block, _laser(i)
    time_s = np.arange(len(volts)) / RATE_HZ
    found = find_rotation(time_s, volts, laser, block, "V")
    signal = [found[name].values for name in ("time", "theta", "sigma_theta", "flags")]
    step = converter_step(volts, signal[1])
    run, impacts = judged_runs(signal, block, signal_quality(found), step=step)[0]
    return truth, run, impacts


def run(size: str = "full") -> pd.DataFrame:
    """Every noise on every scene in turn.

    Returns
    -------
    pandas.DataFrame
        A row per number: noise; record; scene (block, foundation, kind); level and names of the verdict;
        number ("release" [s], "theta0" [rad] or "restitution"), impact (from 1; 0 of the others), error and
        stderr, and inside: the 95 % interval holds the truth.
    """
    cases = [(noise, i) for i in range(SIZES[size]) for noise in NOISES]
    return pd.DataFrame(rows_of_all(rows_of, cases), columns=COLUMNS)


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one record."""
    noise, i = case
    scene = f"{BLOCKS[i % 3]} {FOUNDATIONS[i // 3 % 2]} {KINDS[i // 6 % 3]}"
    of_record = {"noise": noise, "record": i, "scene": scene}
    try:
        truth, run, impacts = measured(noise, i)
    except FreerockError as error:
        return [of_record | {"level": "fail", "names": str(error.what), "number": "none"}]
    of_record |= {"level": run.verdict.level, "names": " ".join(run.verdict.names)}
    numbers = [
        ("release", 0, run.release_s - truth.release_s, run.release_stderr_s),
        ("theta0", 0, run.theta0 - truth.theta0, run.theta0_stderr),
    ]
    nearest = [int(np.argmin(np.abs(truth.impacts_s - each))) for each in impacts.time_s]
    for j, at in enumerate(nearest):
        if abs(truth.impacts_s[at] - impacts.time_s[j]) < ALIKE_S:
            before, after = (_rigid_energy(truth.peaks[at + by], truth.scene.block) for by in (0, 1))
            off = impacts.restitution[j] - math.sqrt(after / before)
            numbers.append(("restitution", at + 1, off, impacts.restitution_stderr[j]))
    return [
        of_record
        | {"number": number, "impact": impact, "error": error, "stderr": stderr}
        | {"inside": bool(abs(error) <= NORMAL_95 * stderr)}
        for number, impact, error, stderr in numbers
    ]


def _rigid_energy(peak: float, block: Block) -> float:
    """cos φ - cos θ_cr, φ = θ_cr - |θ|."""
    critical = math.atan(block.width_m / block.height_m)
    return math.cos(critical - abs(peak)) - math.cos(critical)


def markdown(frame: pd.DataFrame) -> str:
    """A row per noise: how many records and verdicts, and how often each interval holds the truth."""
    lines = [
        "| noise | records | not ok | release | median error [ms] | release angle | r of an impact |",
        "|---|---|---|---|---|---|---|",
    ]
    for noise, own in frame.groupby("noise", sort=False):
        records = own.drop_duplicates("record")
        usable = own[own["level"] != "fail"]
        by = {number: rows for number, rows in usable.groupby("number")}
        inside = {number: f"{100 * rows['inside'].astype(float).mean():.0f} %" for number, rows in by.items()}
        cells = [
            str(noise),
            str(len(records)),
            str(int((records["level"] != "ok").sum())),
            inside.get("release", ""),
            f"{1e3 * by['release']['error'].abs().median():.2f}" if "release" in by else "",
            inside.get("theta0", ""),
            inside.get("restitution", ""),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main(product: str, size: str, document: str = "") -> None:
    """Measure, write the product, and renew the table of a document."""
    publish(run(size), product, document, MARK, markdown)


if __name__ == "__main__":
    main(*sys.argv[1:])
