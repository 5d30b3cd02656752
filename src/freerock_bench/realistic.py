"""A realistic laboratory, where no law is true, by `springs`: volts, and the energies of each impact.

Corners are rounded, the bed varies along the base and has hysteresis, the table gives, the base may slip, air
drags, the sensor is not quite linear, k and λ differ from impact to impact. A hand trembles, lets go slowly.
Six scenes of five runs; a case is a foundation.
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.signal import butter, sosfiltfilt

from freerock.arrays import Floats
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import GRAVITY, Block
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock_bench import campaigns, scattered
from freerock_bench.scattered import RATE_HZ
from freerock_bench.springs import TILT_S, Motion, Scene, _held, read

SEED, RUNS, SCENES = 1, 5, {"full": 6, "small": 1}
K_BY_IMPACT, LAMBDA_BY_IMPACT, K_BY_RUN = 0.02, 0.22, 0.02
BENT, TREMOR_RAD, TREMOR_HZ = 0.002, math.radians(0.01), (4.0, 12.0)
FADE_S = (0.02, 0.05)
BASE = {"radius_m": 1e-3}
BESIDES = {"varies": 0.1, "hysteresis": 0.03, "table_x_hz": 35.0, "table_y_hz": 45.0, "grip": 0.3}
TABLE_BLOCKS, DRAG = 20.0, 5e-4  # masses of the block; air by weight times half the width


def make(folder: Path, i: int) -> Path:
    """Make the record of a scene, unless it is there."""
    name, foundation = list(BLOCKS)[i % 3], list(TABLE_2)[i // 3 % 2]
    path = folder / f"{name}_{foundation}_{i:02d}.npz"
    if path.exists():
        return path
    draw = np.random.default_rng([SEED, 74, i])
    law = TABLE_2[foundation]["hunt_crossley"]
    soil = {key: value * draw.uniform(0.9, 1.1) for key, value in law.items()}
    own = "realistic", "", name, foundation, 0.0, K_BY_RUN, soil, "callipers"
    truth = scattered.Truth(
        *own, **scattered.inputs(BLOCKS[name], scattered.BEAMS_M[name], "callipers", draw)
    )
    angle, phase = RELEASE_ANGLES[name] * draw.uniform(0.7, 1.0), draw.uniform(0, 2 * math.pi)
    runs = [_run(truth.block, soil, phase, angle, RATE_HZ / truth.clock, draw) for _ in range(RUNS)]
    ways, begins = _ways(runs, truth.position_m, draw)
    volts = 10 / truth.range_m * (ways - ways[0]) / truth.scale
    volts = scattered.written(volts * (1 + BENT * (1 - np.abs(volts) / 5)), draw)
    more: dict[str, Any] = {}
    for j, (motion, known) in enumerate(runs):
        known["k"] *= 1 + BESIDES["varies"] * math.sin(phase)  # under the edges
        known |= scattered.impacts_in_volts(motion, begins[j], truth.clock)
        more |= {f"run{j}_{key}": each for key, each in known.items()}
    scattered.write(path, truth, volts, begins, RATE_HZ, more)
    return path


def _run(
    block: Block, soil: dict[str, float], phase: float, angle: float, rate_hz: float, draw: Any
) -> tuple[Motion, Any]:
    """A run and what is true of it."""
    own = soil | {"k": soil["k"] * math.exp(K_BY_RUN * draw.standard_normal())}
    by = np.column_stack([np.zeros(400), *draw.standard_normal((2, 400))])
    impacts = np.exp(by * [0.0, K_BY_IMPACT, LAMBDA_BY_IMPACT])
    weight = block.mass_kg * GRAVITY * block.b
    besides = BESIDES | {"varies_from": phase, "air_nms2": DRAG * weight}
    besides["table_kg"] = TABLE_BLOCKS * block.mass_kg
    theta0, rate = angle + math.radians(draw.uniform(-0.3, 0.3)), TREMOR_RAD * 2 * math.pi * 8 / math.sqrt(2)
    scene = Scene(
        block,
        own,
        True,
        float(theta0),
        draw.uniform(*FADE_S),
        BASE,
        besides,
        float(rate * draw.standard_normal()),
        impacts=impacts,
    )
    motion = Motion(scene, rate_hz, 20.0)
    return motion, {"theta0": scene.theta0, **own}


def _ways(runs: list[tuple[Motion, Any]], height_m: float, draw: Any) -> tuple[Floats, list[float]]:
    """Way of the beam [m] over rest, and tilt, hold, run and rest of each; when hands begin to leave [s]."""
    scene = runs[0][0].scene
    still = runs[0][0].stands[:12, None]
    parts, begins, now = [np.repeat(still, int(scattered.REST_S * RATE_HZ), axis=1)], [], still
    share = np.linspace(0, 1, int(TILT_S * RATE_HZ))
    share = share**3 * (10 - 15 * share + 6 * share**2)
    for motion, _ in runs:
        slid = now - still  # it is tilted again where it lies
        held = motion.states[:, :1] + slid
        at = [motion.scene.theta0 + by for by in (0.0, 1e-4)]
        less, more = (_held(replace(motion.scene, theta0=each, besides={}))[:12, None] for each in at)
        hold, after = (int(each * RATE_HZ) for each in draw.uniform(1.5, 2.5, 2))
        parts += [now + share * (held - now), held + (more - less) / 1e-4 * _tremor(hold, draw)]
        begins.append(sum(part.shape[1] for part in parts) / RATE_HZ)
        now = now.copy()
        now[0] += motion.slid_m
        parts += [motion.states + slid, np.repeat(now, after, axis=1)]
    return read(np.hstack(parts), scene, height_m), begins


def _tremor(n: int, draw: Any) -> Floats:
    """Of a hand that holds [rad]; none at the start and at the end, where the run has its rate."""
    band = butter(2, TREMOR_HZ, "bandpass", fs=RATE_HZ, output="sos")
    noise = sosfiltfilt(band, draw.standard_normal(n + 2000))[1000 : 1000 + n]
    ends = np.minimum(1.0, np.minimum(np.arange(n), np.arange(n)[::-1]) / (0.05 * RATE_HZ))
    return np.asarray(TREMOR_RAD * noise / noise.std() * ends)


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table; truth of k is that under the edges."""
    found = campaigns.study(folder, make, range(SCENES[size]), lambda of: str(of["true_foundation"]), cores)
    return pd.concat([found, _between(found[found["parameter"] == "k"])], ignore_index=True)


def _between(k: pd.DataFrame) -> pd.DataFrame:
    """Whether k of a run, over its truth, is that of the other runs of its record within their u."""
    off, u2 = np.log(k["value"] / k["truth"]), (k["u"] / k["value"]) ** 2
    n, sums, u2s = (each.groupby(k["test"]).transform("sum") for each in (off * 0 + 1, off, u2))
    between, u = off - (sums - off) / (n - 1), np.sqrt(u2 + (u2s - u2) / (n - 1) ** 2)
    answers = {"parameter": "k between runs", "inside": between.abs() <= NORMAL_95 * u}
    return k[["case", "test", "run", "scene"]].assign(**answers)


markdown = campaigns.markdown
