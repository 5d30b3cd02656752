"""Kinds of laboratories: blocks, beds, tables, hands and sensors, from volts to verdict and cause.

Each record is made by `springs`, whose method and code are apart from the laws that are fitted. Its inputs
are off by normal draws of what is stated of them: block and beam by callipers in every other record, by the
defaults of a campaign in the others. Releases, fingers, noise and soil scatter.

    python -m freerock_bench.kinds results/studies/kinds.csv medium docs/evidence.md

measures (`small`: a record of each kind; `medium`: three, in an hour of processor time; `full`: five) and
renews the table in the documentation, where it is named.
"""

import math
import re
import sys
import zlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from ruamel.yaml import YAML

from freerock.arrays import Floats
from freerock.config.uncertainty import DEFAULTS
from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.virtual_lab.added_noise import Disturbance
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench import disturbances as faults
from freerock_bench.analysed import Analysed, analysed
from freerock_bench.document import in_markdown
from freerock_bench.harness import NUMBERS, Study, rows_of_fit
from freerock_bench.springs import Motion, Scene, read
from freerock_bench.truths import place, table_2
from freerock_bench.virtual_run import SEED, Row, correlated

SIZES = {"small": 1, "medium": 3, "full": 5, "long": 20}  # records of each kind
RATE_HZ, REST_S = 1000.0, 2.0
ZERO_V, WHITE_V, SPAN_V, RANGE_V = 5.0, 2e-3, 20.0, 10.0
SCATTER, ANGLES = 0.1, (0.6, 1.0)
# Blocks of other sizes: depth in widths, stiffness of the bed over that of table 2 under the same pressure,
# largest angle over the critical one.
HEIGHT_M, SLENDER, DEPTH, KG_M3 = (0.12, 1.6), (2.0, 7.0), (1.0, 4.0), (600.0, 2700.0)
STIFFER, CRITICAL = (0.4, 3.0), 0.8
CALIPER = {"height_m": 3e-5, "width_m": 3e-5, "position_m": 2e-4, "scale_fraction": 5e-4}
CALIPER |= {"sampling_rate_fraction": 2e-5, "com_height_m": 1e-4, "inertia_kg_m2": 2e-3}
INPUTS = ["height_m", "width_m", "mass_kg", "com_height_m", "inertia_kg_m2"]
INPUTS += ["position_m", "scale_fraction", "sampling_rate_fraction", "response_ms"]
OF_LASER = ("position_m", "scale_fraction", "sampling_rate_fraction", "response_ms")
ADVICE = re.compile(
    r"(\w+) of (\S+) (?:fitted|off by) ([+-][\d.e+-]+)"  # measure it again
    r"|(\w+), ([+-][\d.e+-]+)(?: [\w ]+?)? of (\w+)"  # a cause, by how much it is off
    r"|(?:response_ms, |averages over )([\d.]+) ms"
)
COLUMNS = [*NUMBERS, "run", "law", "block", "foundation", "known", "verdict", "candidate", "explained"]
COLUMNS += ["causes", "names", "first", "among", "error", "z", "z_u", "advice", "advised", "advised_z_u"]
CAUSE = re.compile(r",? \(\d\) ")  # before each cause of a misfit
OWN = ("incline", "volts", "lost", "bits", "slow")  # what differs beside the scene
Draw = Any


@dataclass(frozen=True)
class Kind:
    """What is besides a law, as `kinds.yaml` states it.

    Parameters
    ----------
    law : str
    pivoting : bool, optional
    sizes : bool
        Whether blocks have other sizes than those of table 1.
    names : set of str
        Reasons and inputs that name it rightly; none of a clean one.
    differs : dict
        All else that the file states.
    """

    law: str = "hunt_crossley"
    pivoting: bool | None = None
    sizes: bool = False
    names: Collection[str] = ()
    differs: dict[str, Any] = field(default_factory=dict)


def _kind(names: Any = (), **stated: Any) -> Kind:
    parts = [[each] if isinstance(each, str) else each for each in names]
    own = {key: stated.pop(key) for key in ("law", "pivoting", "sizes") if key in stated}
    return Kind(**own, names={name for part in parts for name in part}, differs=stated)


STATED = YAML(typ="safe", pure=True).load(Path(__file__).with_suffix(".yaml"))
KINDS = {name: _kind(**stated) for name, stated in STATED["kinds"].items()}


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


def cases(size: str) -> list[tuple[str, int]]:
    """Kind and number of each record."""
    return [(name, i) for i in range(SIZES[size]) for name in KINDS]


def other_size(draw: Draw) -> tuple[Block, float, Laser]:
    """A block of another size, the largest angle of its releases [rad], and a laser whose range suffices."""
    height = round(_log_uniform(draw, *HEIGHT_M), 3)
    width = round(height / draw.uniform(*SLENDER), 3)
    block = Block(height, width, round(draw.uniform(*KG_M3) * height * width**2 * draw.uniform(*DEPTH), 3))
    at_m, angle = round(0.8 * height, 3), CRITICAL * block.theta_cr
    return block, angle, Laser("horizontal", at_m, round(3 * (at_m * math.sin(angle) + 2e-3), 3))


def _log_uniform(draw: Draw, low: float, high: float) -> float:
    return float(low * (high / low) ** draw.uniform())


def stated_laboratory(name: str, block: Block, laser: Laser, caliper: bool) -> Laboratory:
    """What is stated of a block and its laser; the rest by default."""
    u = DEFAULTS | (CALIPER if caliper else {})
    u["mass_kg"] = DEFAULTS["mass_fraction"] * block.mass_kg
    u["inertia_kg_m2"] = u.get("inertia_kg_m2", DEFAULTS["inertia_fraction"]) * block.inertia_cm
    owners = dict.fromkeys(OF_LASER, "laser")
    inputs = (Input(owners.get(each, name), each, u[each], caliper) for each in INPUTS)
    return Laboratory(block, {"laser": laser}, tuple(inputs))


class Record(NamedTuple):
    """Volts, the stated and the true laboratory, the true parameters, and what the record is of."""

    volts: Floats
    stated: Laboratory
    laboratory: Laboratory
    true: dict[str, float]
    row: Row


def record(name: str, i: int) -> Record:
    """The i-th record of a kind."""
    kind, draw = KINDS[name], np.random.default_rng([SEED, 38, zlib.crc32(name.encode()), i])
    turn = i + zlib.crc32(name.encode())
    configuration, foundation = place(turn)
    of_table = CONFIGURATIONS[configuration]
    size, angle, laser = other_size(draw) if kind.sizes else of_table
    block_name = "other" if kind.sizes else configuration
    stated = stated_laboratory(block_name, size, laser, bool(turn // 2 % 2))
    drawn = tuple(each for each in stated.inputs if each.name != "response_ms")
    true = stated.at(drawn, draw.standard_normal(len(drawn)))
    differs = differing(kind, true.block, draw)
    for key, by in differs.pop("off", {}).items():
        owner = "laser" if key in OF_LASER else block_name
        true = true.moved(Input(owner, key, by, True), 1.0)
    block = differs.pop("block", true.block)
    soil = {
        key: value * draw.uniform(1 - SCATTER, 1 + SCATTER)
        for key, value in table_2(kind.law, foundation).items()
    }
    damping = differs.pop("damping", 1.0)
    soil = {key: value * (damping if key in ("c", "lambda") else 1.0) for key, value in soil.items()}
    if kind.sizes:  # as deep under its weight, and as far from Housner's r, as the block of table 1
        heavier = size.mass_kg / of_table[0].mass_kg * of_table[0].width_m / size.width_m
        heavier *= _log_uniform(draw, *STIFFER)
        better = size.restitution_housner / of_table[0].restitution_housner
        soil = {key: value * (better if key == "r" else heavier) for key, value in soil.items()}
    if "r" in soil:
        soil["r"] = min(soil["r"], 0.98)
    pivoting = bool(draw.integers(2)) if kind.pivoting is None else kind.pivoting
    angle = angle * draw.uniform(*ANGLES) * draw.choice([-1, 1])
    own: dict[str, Any] = {key: differs.pop(key) for key in OWN if key in differs}
    release = {"fade_s": draw.uniform(5e-3, 20e-3)} | differs
    scene = Scene(block, soil, pivoting or "r" in soil, float(angle), **release)
    volts = _measured(scene, true, own, draw)
    row = {"case": name, "run": i + 1, "law": kind.law, "block": block_name, "foundation": foundation}
    row["known"] = "callipers" if stated.inputs[0].stated else "defaults"
    return Record(volts, stated, replace(true, block=block), soil, row)


def _measured(scene: Scene, true: Laboratory, own: dict[str, Any], draw: Draw) -> Floats:
    """Volts: rest, tilt, hold, run, rest."""
    rate_hz, (laser,) = RATE_HZ / true.clock, true.lasers.values()
    motion = Motion(scene, rate_hz)
    still = REST_S, draw.uniform(1.5, 2.5), draw.uniform(1.5, 2.5)
    states, begins = motion.record(*(int(each * rate_hz) for each in still))
    way = read(states, scene, laser.position, own.get("incline", 0.0))
    assert laser.range_m is not None
    volts = ZERO_V + RANGE_V / laser.range_m * (way - way[0]) / true.scales[0]
    if "lost" in own:
        at = begins + int(motion.states.shape[1] * draw.uniform(0.1, 0.4))
        volts = np.delete(volts, np.s_[at : at + own["lost"]])
    time_s = np.arange(volts.size) / RATE_HZ
    if "volts" in own:
        volts = own["volts"](time_s, volts, np.random.RandomState(draw.integers(2**31)))
    noise = draw.standard_normal(volts.size)
    if "slow" in own:
        noise = noise + own["slow"] * correlated(volts.size, 0.05, RATE_HZ, draw)
    count = SPAN_V / 2 ** own.get("bits", 24)
    return np.asarray(count * np.rint((volts + WHITE_V * noise) / count))


def rows_of(case: tuple[str, int]) -> list[Row]:
    """A row per parameter of one record; one without a number where nothing was fitted."""
    name, i = case
    made = record(name, i)
    row = made.row
    try:
        result = analysed_as_stated(made.volts, made.stated)
    except FreerockError as error:
        return [row | {"parameter": "", "verdict": "fail", "causes": "", "names": str(error.what)}]
    row = row | _named(result, name) | _advised(made, result, name)
    return [row | each for each in _numbers(result, name, made.true)]


def analysed_as_stated(volts: Floats, stated: Laboratory) -> Analysed:
    """A record with the inputs of a laboratory; its clock and scale are those of the record."""
    (laser,), time_s = stated.lasers.values(), np.arange(volts.size) / RATE_HZ * stated.clock
    volts = volts[0] + stated.scales[0] * (volts - volts[0])
    stated = replace(stated, clock=1.0, scales=(1.0, 1.0))
    return analysed(time_s, volts, laser, stated.block, laboratory=stated)


class Advice(NamedTuple):
    """To measure an input of an owner again, or to set it otherwise by so much [SI]; `response_ms` to a
    value [ms]."""

    name: str
    owner: str
    by: float
    measure: bool


def advice(result: Analysed) -> Iterator[Advice]:
    """What warnings advise on inputs of the laboratory."""
    for reason in result.verdict.reasons:
        if reason.verdict == "warn":
            for found in ADVICE.finditer(reason.text.replace("−", "-")):
                again, owner, by, name, off, of, slow_ms = found.groups()
                if again == "response_ms":
                    continue  # what it truly is, no record of a kind states
                if again:
                    yield Advice(again, owner, float(by), True)
                elif name:
                    yield Advice(name, of, float(off), False)
                else:
                    yield Advice("response_ms", "laser", float(slow_ms), False)


def followed(stated: Laboratory, true: Laboratory, to: Advice, draw: Draw) -> Laboratory:
    """The stated laboratory as an advice has it, followed blindly; what is measured again has its
    uncertainty, drawn."""
    if to.name == "response_ms":
        lasers = {key: replace(each, response_ms=to.by) for key, each in stated.lasers.items()}
        return replace(stated, lasers=lasers)
    by = to.by
    if to.measure:
        (u,) = [each.u for each in stated.inputs if each.name == to.name] or [0.0]
        by = _value(true, to.name) - _value(stated, to.name)
        by += u * draw.standard_normal()
    return stated.moved(Input(to.owner, to.name, by, True), 1.0)


def _value(laboratory: Laboratory, name: str) -> float:
    (laser,), block = laboratory.lasers.values(), laboratory.block
    known = {"com_height_m": block.h, "com_offset_m": block.e, "inertia_kg_m2": block.inertia_cm}
    known |= {"position_m": laser.position, "scale_fraction": laboratory.scales[0]}
    known |= {"sampling_rate_fraction": 1 / laboratory.clock, "levelled_deg": math.degrees(laboratory.tilt)}
    return known[name] if name in known else float(getattr(block, name))


def _advised(made: Record, result: Analysed, name: str) -> Row:
    """What the first advice on an input leads to."""
    to = next(advice(result), None)
    if to is None:
        return {}
    row: Row = {"advice": f"{to.name} {to.by:+g}" if not to.measure else f"{to.name} again"}
    draw = np.random.default_rng([SEED, 39, zlib.crc32(name.encode()), made.row["run"]])
    try:
        then = analysed_as_stated(made.volts, followed(made.stated, made.laboratory, to, draw))
    except FreerockError:
        return row | {"advised": "fail"}
    off = [abs(each["z_u"]) for each in _numbers(then, name, made.true) if "z_u" in each]
    return row | {"advised": then.verdict.level, "advised_z_u": max(off, default=math.nan)}


def causes_of(result: Analysed) -> list[str]:
    """What a verdict warns of, the likeliest first: reasons, and causes in them; twins share a place."""
    found = list[str]()
    for reason in result.verdict.reasons:
        if reason.verdict == "ok":
            continue
        if reason.name == "pulled_input":
            found += re.findall(r"(\w+) of \S+ (?:fitted|off)", reason.text)
            found += ["width_m"] * reason.text.startswith("contact width")
        elif reason.name == "unmodelled_effect":
            found += re.findall(r"requires (\w+),", reason.text)
        elif reason.name == "unexplained":
            causes = CAUSE.split(reason.text)[1:]
            found += ["/".join(re.findall(r"(?:^| or )(\w+),", cause)) for cause in causes]
        else:
            found.append(reason.name)
    return [*dict.fromkeys(found)]


def _named(result: Analysed, name: str) -> Row:
    """Verdict and causes of a record; whether the first, and one of the first three, is right."""
    causes, right = causes_of(result), {*KINDS[name].names}
    choice = result.found.choice(BY_DEFAULT)
    if "width" in choice.selected and choice.explained:
        causes.append("width_m")
    row: Row = {"verdict": result.verdict.level, "candidate": choice.selected, "explained": choice.explained}
    row |= {"causes": " ".join(causes), "names": " ".join(result.verdict.names)}
    first, *others = [bool({*cause.split("/")} & right) for cause in causes[:3]] or [False]
    return row | {"first": first, "among": first or any(others)}


def _numbers(result: Analysed, name: str, true: dict[str, float]) -> list[Row]:
    choice = result.found.choice(BY_DEFAULT)
    fit = result.found.fits.get(choice.selected)
    if fit is None or not fit.success:
        return [{"parameter": ""}]
    rows = []
    for row in rows_of_fit(name, fit, true):
        off = row["value"] - row["truth"]
        rows.append(row | {"error": off / row["truth"], "z": off / row["stderr"], "z_u": off / row["u"]})
    return rows or [{"parameter": ""}]


def markdown(frame: pd.DataFrame) -> str:
    """A row per kind: verdicts, numbers, causes; then all, clean ones, and the rest."""
    heads = ["kind", "ok", "warn", "fail", "first cause right", "among three", "inside ± 1.96 u"]
    heads += ["ok beyond 2 u", "3 u", "advice followed", "then ok", "beyond 3 u", "first causes"]
    clean = frame["case"].map(lambda name: not KINDS[name].names).astype(bool)
    groups = [*frame.groupby("case", sort=False)]
    groups += [("**clean**", frame[clean]), ("**others**", frame[~clean]), ("**all**", frame)]
    return in_markdown(heads, [_cells(str(name), own) for name, own in groups])


def _cells(name: str, own: pd.DataFrame) -> list[str]:
    runs = own.drop_duplicates(["case", "run"])
    known = own.dropna(subset=["inside"])
    ok = known.loc[known["verdict"] == "ok", "z_u"].abs().astype(float)
    warned = runs["verdict"] != "ok"
    truly = runs["case"].map(lambda each: bool(KINDS[each].names)).astype(bool)
    seen = runs[warned & truly]
    cells = [name, *(str((runs["verdict"] == level).sum()) for level in ("ok", "warn", "fail"))]
    right = [int(seen[each].eq(True).sum()) for each in ("first", "among")]  # refused: NaN
    cells += [f"{n} of {len(seen)}" * bool(len(seen)) for n in right]
    cells += [f"{int(known['inside'].astype(bool).sum())} of {len(known)}" * bool(len(known))]
    cells += [str(int((ok > limit).sum()) or "") for limit in (2, 3)]
    followed = runs[runs["advice"].notna()]
    then = followed[followed["advised"] == "ok"]
    cells += [str(n or "") for n in (len(followed), len(then), (then["advised_z_u"] > 3).sum())]
    first = runs.loc[warned, "causes"].fillna("").str.split().str[0].value_counts()
    told = ", ".join(f"{each} {n}" for each, n in first.head(3).items()) if not name.startswith("**") else ""
    return [*cells, told]


STUDY = Study(cases, rows_of, COLUMNS, "kinds", markdown)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
