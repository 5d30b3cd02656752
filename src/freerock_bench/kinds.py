"""Kinds of laboratories: blocks, beds, tables, hands and sensors, with and without impacts that scatter.

Each record is one run made by `springs`, whose method and code are apart from the laws that are fitted. Its
inputs are off by normal draws of what is stated of them. Releases, fingers, noise and soil scatter.
`kinds.yaml` states the kinds; each is a case with each σ_r.
"""

import math
import zlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from freerock.arrays import Floats
from freerock.config.yaml_lines import Yaml12
from freerock.models.block import GRAVITY, Block
from freerock.virtual_lab.added_noise import Disturbance
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock_bench import campaigns, scattered
from freerock_bench import disturbances as faults
from freerock_bench.document import in_markdown
from freerock_bench.scattered import NOISE_V, Truth, written
from freerock_bench.springs import Motion, Scene, read

RATE_HZ, REST_S = 1000.0, 2.0
SEED, SIGMAS = 0, (0.01,)
SCATTER, ANGLES = 0.1, (0.6, 1.0)
# Blocks of other sizes: depth in widths, stiffness of the bed over that of table 2 under the same pressure,
# largest angle over the critical one.
HEIGHT_M, SLENDER, DEPTH, KG_M3 = (0.12, 1.6), (2.0, 7.0), (1.0, 4.0), (600.0, 2700.0)
STIFFER, CRITICAL = (0.4, 3.0), 0.8
OWN = ("incline", "volts", "lost", "bits", "slow")  # what differs beside the scene
OF_TRUTH = {"position_m": "position_m", "scale_fraction": "scale", "sampling_rate_fraction": "clock"}
Draw = Any


@dataclass(frozen=True)
class Kind:
    """What is besides a law, as `kinds.yaml` states it.

    Parameters
    ----------
    law : str
    pivoting : bool, optional
        Guided or pivoting at random where it is left out.
    sizes : bool
        Whether blocks have other sizes than those of table 1.
    differs : dict
        All else that the file states.
    """

    law: str = "hunt_crossley"
    pivoting: bool | None = None
    sizes: bool = False
    differs: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, stated: dict[str, Any]) -> "Kind":
        """From what the file states."""
        own = {key: stated[key] for key in ("law", "pivoting", "sizes") if key in stated}
        return cls(**own, differs={key: each for key, each in stated.items() if key not in own})

    @cached_property
    def is_clean(self) -> bool:
        """Whether nothing is besides the law."""
        return not self.differs or set(self.differs) <= {"damping", "bits"}


STATED = yaml.load(Path(__file__).with_suffix(".yaml").read_bytes(), Yaml12)
KINDS = {name: Kind.of(stated) for name, stated in STATED["kinds"].items()}


def differing(kind: Kind, block: Block, draw: Draw) -> dict[str, Any]:
    """What differs in a record of a kind: fields of `Scene`, `block`, `off`, `damping` and those of `OWN`."""
    found: dict[str, Any] = {}
    for key, stated in kind.differs.items():
        given = _drawn(stated, draw)
        if key in ("base", "besides", "off"):
            found[key] = dict(_in_si(name, value, block) for name, value in given.items())
        elif key == "incline_deg":
            found["incline"] = math.radians(given)
        elif key == "glued":
            found["block"] = _glued(block, **given)
        elif key == "blow":
            at_s, added = math.pi / 2 / block.p * given["swings"], given["added"] * draw.choice([-1, 1])
            found["blow"] = (at_s, given["kept"], added)
        elif key == "volts":
            ((fault, arguments),) = given.items()
            found["volts"] = _bent(*arguments) if fault == "bent" else getattr(faults, fault)(*arguments)
        else:
            found[key] = given
    return found


def _drawn(stated: Any, draw: Draw) -> Any:
    """What is stated, two numbers in a list drawn between them."""
    if isinstance(stated, dict):
        return {key: _drawn(value, draw) for key, value in stated.items()}
    if isinstance(stated, list) and len(stated) == 2 and not isinstance(stated[0], list):
        return draw.uniform(*stated)
    return [_drawn(each, draw) for each in stated] if isinstance(stated, list) else stated


def _in_si(name: str, value: float, block: Block) -> tuple[str, float]:
    """A number by the name and in the unit of the simulator."""
    match name:
        case "tilt_deg":
            return "tilt", math.radians(value)
        case "table_blocks":
            return "table_kg", value * block.mass_kg
        case "inertia_fraction":
            return "inertia_kg_m2", value * block.inertia_cm
        case "air" | "rub":
            unit = {"air": "air_nms2", "rub": "rub_nm"}[name]
            return unit, value * block.mass_kg * GRAVITY * block.width_m / 2
    return name, value


def _glued(block: Block, kg: float, across: float) -> Block:
    """With a mass on top, so far right of the middle, in half widths."""
    m, share = block.mass_kg + kg, kg / (block.mass_kg + kg)
    x, z = across * block.width_m / 2, block.height_m
    inertia = block.inertia_cm + block.mass_kg * share * ((z - block.h) ** 2 + (x - block.e) ** 2)
    com = {"com_height_m": block.h + share * (z - block.h), "com_offset_m": share * (x - block.e)}
    return replace(block, mass_kg=m, inertia_kg_m2=inertia, **com)


def _bent(share: float) -> Disturbance:
    """A sensor whose scale bends by a share of its range, between its ends [V]."""
    return lambda time_s, volts, _: volts + 4 * share * volts * (1 - volts / 10)


def _other_size(draw: Draw) -> tuple[Block, float, float, float]:
    """A block of another size, its largest angle [rad], height of the beam and range of a laser [m]."""
    height = round(_log_uniform(draw, *HEIGHT_M), 3)
    width = round(height / draw.uniform(*SLENDER), 3)
    block = Block(height, width, round(draw.uniform(*KG_M3) * height * width**2 * draw.uniform(*DEPTH), 3))
    at_m, angle = round(0.8 * height, 3), CRITICAL * block.theta_cr
    return block, angle, at_m, round(3 * (at_m * math.sin(angle) + 2e-3), 3)


def _log_uniform(draw: Draw, low: float, high: float) -> float:
    return float(low * (high / low) ** draw.uniform())


def table_2(law: str, foundation: str) -> dict[str, float]:
    """Parameters of table 2; of the general law k of Hunt and Crossley's and half of each damping."""
    published = TABLE_2[foundation]
    if law != "general":
        return dict(published[law])
    both = published["winkler"]["c"] / 2, published["hunt_crossley"]["lambda"] / 2
    return {"k": published["hunt_crossley"]["k"], "c": both[0], "lambda": both[1]}


def make(folder: Path, case: tuple[str, float]) -> Path:
    """Make the record of a kind and a σ_r, unless it is there."""
    name, sigma_r = case
    number, i = zlib.crc32(name.encode()), SEED
    path = folder / f"{number:08x}_{1e4 * sigma_r:03.0f}.npz"
    if path.exists():
        return path
    kind, draw, turn = KINDS[name], np.random.default_rng([2017, 38, number, i]), i + number
    block_name, foundation = list(BLOCKS)[turn % 3], list(TABLE_2)[turn // 3 % 2]
    known = ("callipers", "rule")[turn // 2 % 2]
    usual = BLOCKS[block_name], RELEASE_ANGLES[block_name], scattered.BEAMS_M[block_name], 0.1
    stated, angle, beam_m, range_m = _other_size(draw) if kind.sizes else usual
    inputs = scattered.inputs(stated, beam_m, known, draw) | {"range_m": range_m}
    differs = differing(kind, inputs["block"], draw)
    for key, by in differs.pop("off", {}).items():
        if key in OF_TRUTH:
            where = OF_TRUTH[key]
            inputs[where] = inputs[where] / (1 + by) if where == "clock" else inputs[where] + by
        else:
            inputs["block"] = inputs["block"].moved({key: by})
    inputs["block"] = differs.pop("block", inputs["block"])
    damping = differs.pop("damping", 1.0)
    soil = {
        key: value * draw.uniform(1 - SCATTER, 1 + SCATTER) * (damping if key in ("c", "lambda") else 1.0)
        for key, value in table_2(kind.law, foundation).items()
    }
    if kind.sizes:  # as deep under its weight, and as far from Housner's r, as the block of table 1
        of_table = BLOCKS[block_name]
        heavier = stated.mass_kg / of_table.mass_kg * of_table.width_m / stated.width_m
        heavier *= _log_uniform(draw, *STIFFER)
        better = stated.restitution_housner / of_table.restitution_housner
        soil = {key: value * (better if key == "r" else heavier) for key, value in soil.items()}
    if "r" in soil:
        soil["r"] = min(soil["r"], 0.98)
    pivoting = bool(draw.integers(2)) if kind.pivoting is None else kind.pivoting
    pivoting = pivoting or "r" in soil
    own = kind.law, "pivoting" if pivoting else "guided", block_name, foundation, sigma_r, 0.0, soil
    truth = Truth(*own, known, **inputs)
    angle = float(angle * draw.uniform(*ANGLES) * draw.choice([-1, 1]))
    _save(path, truth, angle, differs, draw, {"kind": name, "clean": kind.is_clean})
    return path


def _save(
    path: Path, truth: Truth, angle: float, differs: dict[str, Any], draw: Draw, more: dict[str, Any]
) -> None:
    """Move the block and write the record."""
    own = {key: differs.pop(key) for key in OWN if key in differs}
    impacts = np.column_stack([1 + truth.sigma_r * draw.standard_normal(400), np.ones((400, 2))])
    release = {"fade_s": draw.uniform(5e-3, 20e-3), "impacts": impacts} | differs
    scene = Scene(truth.block, truth.parameters, truth.kinematics == "pivoting", angle, **release)
    motion = Motion(scene, RATE_HZ / truth.clock)
    volts, begins = _measured(motion, truth, own, draw)
    known: dict[str, Any] = dict(truth.parameters)
    if not scene.known["top"] and not scene.known["relaxing"]:  # energies that `springs.energy` lacks
        known |= scattered.impacts_in_volts(motion, begins / RATE_HZ, truth.clock)
    more |= {f"run0_{key}": value for key, value in known.items()}
    scattered.write(path, truth, volts, [begins / RATE_HZ], RATE_HZ, more)


def _measured(motion: Motion, truth: Truth, own: dict[str, Any], draw: Draw) -> tuple[Floats, int]:
    """Volts: rest, tilt, hold, run, rest; the sample at which the hand begins to leave."""
    rate_hz, scene = motion.rate_hz, motion.scene
    still = REST_S, draw.uniform(1.5, 2.5), draw.uniform(1.5, 2.5)
    states, begins = motion.record(*(int(each * rate_hz) for each in still))
    way = read(states, scene, truth.position_m, own.get("incline", 0.0))
    volts = 10 / truth.range_m * (way - way[0]) / truth.scale
    if "lost" in own:
        at = begins + int(motion.states.shape[1] * draw.uniform(0.1, 0.4))
        volts = np.delete(volts, np.s_[at : at + own["lost"]])
    if "volts" in own:
        time_s, random = np.arange(volts.size) / RATE_HZ, np.random.RandomState(draw.integers(2**31))
        volts = own["volts"](time_s, volts + scattered.ZERO_V, random) - scattered.ZERO_V
    noise = draw.standard_normal(volts.size)
    if "slow" in own:
        noise = noise + own["slow"] * faults.correlated(volts.size, 0.05, RATE_HZ, draw)
    return written(volts, draw, NOISE_V * noise, own.get("bits", 24)), begins


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table."""
    names = [*KINDS] if size == "full" else [*KINDS][:2]
    return campaigns.study(folder, make, [*product(names, SIGMAS)], _case, cores)


def _case(truth: Any) -> str:
    return f"{truth['kind']}; σ_r {100 * float(truth['true_sigma_r']):g} %"


def markdown(frame: pd.DataFrame) -> str:
    """A column for clean kinds and one for others of each σ_r; then a row for each kind."""
    of = dict(zip(("kind", "sigma"), zip(*frame["case"].str.split("; "), strict=True), strict=True))
    rows = frame.assign(**of, z=(frame["value"] - frame["truth"]) / frame["u"])
    clean = rows["kind"].str.startswith("clean").map({True: "clean, ", False: "others, "})
    said = rows[rows["parameter"] == "verdict ok"].groupby(["kind", "sigma"], sort=False)["note"].first()
    off = rows[rows["parameter"].isin(("k", "r"))].groupby(["kind", "sigma"])["z"].first()
    cells = (said + off.reindex(said.index).map("; {:+.1f} u".format)).unstack(sort=False)
    by_kind = in_markdown(["kind", *cells], [[kind, *row] for kind, *row in cells.itertuples()])
    return f"{campaigns.markdown(frame.assign(case=clean + rows['sigma']))}\n\n{by_kind}"
