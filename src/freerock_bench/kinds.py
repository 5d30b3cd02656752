"""Kinds of laboratories: blocks, beds, tables, hands and sensors, from volts to verdict and cause.

Each record is made by `springs`, whose method and code are apart from the laws that are fitted. Its inputs
are off by normal draws of what is stated of them: block and beam by callipers in every other record, by the
defaults of a campaign in the others. Releases, fingers, noise and soil scatter.

    python -m freerock_bench.kinds results/studies/kinds.csv medium docs/validation.md

measures (`small`: a record of each kind; `medium`: three, in an hour of processor time; `full`: five) and
renews the table in the documentation, where it is named.
"""

import math
import re
import sys
import zlib
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.config.uncertainty import DEFAULTS
from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.rotation.laboratory import Input, Laboratory
from freerock.selection.hypotheses import BY_DEFAULT
from freerock.virtual_lab.noise import Disturbance
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench import disturbances as faults
from freerock_bench.analysed import Analysed, analysed
from freerock_bench.harness import Study, number_row
from freerock_bench.springs import Motion, Scene, read
from freerock_bench.truths import place, table_2
from freerock_bench.virtual_run import SEED, Row, correlated

SIZES = {"small": 1, "medium": 3, "full": 5, "long": 20}  # records of each kind
RATE_HZ, REST_S, TILT_S = 1000.0, 2.0, 1.2
V_PER_M, ZERO_V, WHITE_V, SPAN_V = 100.0, 5.0, 2e-3, 20.0
SCATTER, ANGLES = 0.1, (0.6, 1.0)
CALIPER = {"height_m": 3e-5, "width_m": 3e-5, "position_m": 2e-4, "scale_fraction": 5e-4}
CALIPER |= {"sampling_rate_fraction": 2e-5, "com_height_m": 1e-4, "inertia_kg_m2": 2e-3}
BY_HAND = ("disturbed", "disturbed_release", "pushed", "held_back", "touched", "outlying_restitution")
LEVEL = ("off_level", "levelled_deg", "com_offset_m", "alternating_restitution", "uneven_restitution")
BLOCK = ("com_height_m", "inertia_kg_m2", "height_m", "position_m", "com_offset_m")
SCALES = ("scale_fraction", "position_m", "beam", "sensor")
SLOW = ("slow_sensor", "response_ms")
EDGES = ("rounded_edges", "width_m", "edge_radius")
ADVICE = re.compile(
    r"(\w+) of (\S+) (?:fitted|off by) ([+-][\d.e+-]+)"  # measure it again
    r"|(\w+), ([+-][\d.e+-]+)(?: [\w ]+?)? of (\w+)"  # a cause, by how much it is off
    r"|(?:response_ms, |averages over )([\d.]+) ms"
)
MARK = ("<!-- kinds -->\n\n", "\n\n<!-- end of the kinds -->")
COLUMNS = [
    "run",
    "law",
    "block",
    "foundation",
    "known",
    "verdict",
    "candidate",
    "explained",
    "causes",
    "names",
]
COLUMNS += ["first", "among", "error", "z", "z_u", "advice", "advised", "advised_z_u"]
OWN = ("incline", "volts", "lost", "bits", "slow")  # what differs beside the scene
Draw = Any


@dataclass(frozen=True)
class Kind:
    """What is besides a law.

    Parameters
    ----------
    law : str
        "" of Hunt and Crossley's, pivoting or guided in turn.
    pivoting : bool, optional
    differs : callable
        (block, draw) → fields of `Scene`; `block` of its own; `incline` of the beam; `volts`, faults of
        `disturbances`; `off`, by which inputs are besides; `lost`, samples; `bits`; `slow`.
    names : collection of str
        Reasons and inputs that name it rightly; none of a clean one.
    """

    differs: Callable[[Block, Draw], dict[str, Any]] = lambda block, draw: {}
    names: Collection[str] = ()
    law: str = "hunt_crossley"
    pivoting: bool | None = None


def _base(names: Collection[str], **base: float) -> Kind:
    return Kind(lambda block, draw: {"base": base}, names)


def _besides(names: Collection[str], law: str = "hunt_crossley", **besides: float) -> Kind:
    return Kind(lambda block, draw: {"besides": besides}, names, law)


def _off(names: Collection[str], law: str = "hunt_crossley", **off: float) -> Kind:
    return Kind(lambda block, draw: {"off": off}, names, law)


def _volts(names: Collection[str], fault: Callable[[Draw], Disturbance]) -> Kind:
    return Kind(lambda block, draw: {"volts": fault(draw)}, names)


def _table(direction: str, low: float, high: float) -> Kind:
    def differs(block: Block, draw: Draw) -> dict[str, Any]:
        mode = {"table_kg": 15 * block.mass_kg, f"table_{direction}_hz": draw.uniform(low, high)}
        return {"besides": mode}

    return Kind(differs, ("oscillation",))


def _top(low: float, high: float) -> Kind:
    return Kind(
        lambda block, draw: {"besides": {"top": 0.2, "top_hz": draw.uniform(low, high)}}, ("oscillation",)
    )


def _tilted(tilt_deg: float) -> Kind:
    return _besides(LEVEL, tilt=math.radians(tilt_deg))


def _glued(kg: float, across: float) -> Kind:
    """A mass on top, so far right of the middle, in half widths."""

    def differs(block: Block, draw: Draw) -> dict[str, Any]:
        m, share = block.mass_kg + kg, kg / (block.mass_kg + kg)
        x, z = across * block.width_m / 2, block.height_m
        inertia = block.inertia_cm + block.mass_kg * share * ((z - block.h) ** 2 + (x - block.e) ** 2)
        com = {"com_height_m": block.h + share * (z - block.h), "com_offset_m": share * (x - block.e)}
        return {"block": replace(block, mass_kg=m, inertia_kg_m2=inertia, **com)}

    return Kind(differs, BLOCK if not across else (*BLOCK, *LEVEL))


def _weighed(name: str, share: float) -> Kind:
    """By a share of weight times half the width."""
    return Kind(
        lambda block, draw: {"besides": {name: share * block.mass_kg * GRAVITY * block.width_m / 2}},
        {"air_nms2": ("air",), "rub_nm": ("friction", "air")}[name],
    )


def _blow(kept: float, added: float) -> Kind:
    def differs(block: Block, draw: Draw) -> dict[str, Any]:
        swing_s = math.pi / 2 / block.p
        at = swing_s * (draw.uniform(1.0, 3.0) if added else draw.uniform(0.2, 0.4))
        return {"blow": (at, kept, added * draw.choice([-1, 1]))}

    return Kind(differs, BY_HAND)


KINDS = {
    "clean, rigid": Kind(law="housner"),
    "clean, Winkler, guided": Kind(law="winkler", pivoting=False),
    "clean, Winkler, pivoting": Kind(law="winkler", pivoting=True),
    "clean, Hunt–Crossley, guided": Kind(pivoting=False),
    "clean, Hunt–Crossley, pivoting": Kind(pivoting=True),
    "clean, both dampings": Kind(law="general"),
    "clean, little damping": Kind(lambda block, draw: {"damping": 0.1}),
    "corners worn by 0.5 mm": _base(EDGES, left_m=5e-4, right_m=5e-4),
    "corners worn by 2 mm": _base(EDGES, left_m=2e-3, right_m=2e-3),
    "one corner worn by 0.5 mm": _base(("corner", *EDGES, *LEVEL), left_m=5e-4),
    "one corner worn by 2 mm": _base(("corner", *EDGES, *LEVEL), left_m=2e-3),
    "edges rounded by 0.7 mm": _base(EDGES, radius_m=7e-4),
    "edges rounded by 2 mm": _base(EDGES, radius_m=2e-3),
    "base hollow by 0.05 mm": _base(("base",), hollow_m=5e-5),
    "base tilted by 0.05°": _tilted(0.05),
    "base tilted by 0.3°": _tilted(0.3),
    "beam tilted by 2°": Kind(lambda block, draw: {"incline": math.radians(2)}, SCALES),
    "beam tilted by 5°": Kind(lambda block, draw: {"incline": math.radians(5)}, SCALES),
    "centre of mass 2 mm too high": _off(BLOCK, com_height_m=2e-3),
    "centre of mass 5 mm too low": _off(BLOCK, com_height_m=-5e-3),
    "centre of mass 0.3 mm off": _off(LEVEL, com_offset_m=3e-4),
    "centre of mass 1.5 mm off": _off(LEVEL, com_offset_m=1.5e-3),
    "rigid, centre of mass 0.5 mm off": _off(LEVEL, "housner", com_offset_m=5e-4),
    "30 g glued on top": _glued(0.03, 0.0),
    "60 g glued on top, aside": _glued(0.06, 0.8),
    "inertia 3 % too large": Kind(
        lambda block, draw: {"off": {"inertia_kg_m2": 0.03 * block.inertia_cm}}, BLOCK
    ),
    "rigid, inertia 3 % too small": Kind(
        lambda block, draw: {"off": {"inertia_kg_m2": -0.03 * block.inertia_cm}}, BLOCK, "housner"
    ),
    "mat of 12 mm that hardens": _besides(("hardening",), thickness_m=12e-3),
    "mat of 4 mm that hardens": _besides(("hardening",), thickness_m=4e-3),
    "bed relaxes by a tenth in 20 ms": _besides(("relaxation",), relaxing=0.1, relaxes_s=0.02),
    "bed relaxes by half in 50 ms": _besides(("relaxation",), relaxing=0.5, relaxes_s=0.05),
    "right bed 10 % stiffer": _besides(("two_beds", *LEVEL), two_beds=0.05),
    "right bed 50 % stiffer": _besides(("two_beds", *LEVEL), two_beds=0.2),
    "bed can't pull": _besides(("other_debonding",), "winkler", tensionless=1.0),
    "table sways at 15 to 30 Hz": _table("x", 15, 30),
    "table sways at 30 to 60 Hz": _table("x", 30, 60),
    "table heaves at 15 to 60 Hz": _table("y", 15, 60),
    "top bends at 30 to 50 Hz": _top(30, 50),
    "top bends at 50 to 80 Hz": _top(50, 80),
    "slips, μ = 0.2": Kind(lambda block, draw: {"besides": {"grip": 0.2}}, ("slip",), pivoting=True),
    "slips, μ = 0.1": Kind(lambda block, draw: {"besides": {"grip": 0.1}}, ("slip",), pivoting=True),
    "air": _weighed("air_nms2", 0.002),
    "a cable rubs": _weighed("rub_nm", 0.002),
    "rigid, in air": replace(_weighed("air_nms2", 0.002), law="housner"),
    "pushed by 0.06 rad/s": Kind(lambda block, draw: {"rate": 0.06}, BY_HAND),
    "finger leaves over 80 ms": Kind(lambda block, draw: {"fade_s": 0.08}, BY_HAND),
    "hit, 0.05 rad/s": _blow(1.0, 0.05),
    "braked by a fifth": _blow(0.8, 0.0),
    "sensor averages over 3 ms": _volts(SLOW, lambda draw: faults.averaged(3e-3)),
    "sensor averages over 6 ms": _volts(SLOW, lambda draw: faults.averaged(6e-3)),
    "sensor averages over 8 ms": _volts(SLOW, lambda draw: faults.averaged(8e-3)),
    "three samples lost": Kind(lambda block, draw: {"lost": 3}, ("samples", "disturbed")),
    "twenty samples lost": Kind(lambda block, draw: {"lost": 20}, ("samples", "disturbed")),
    "clock 0.2 % fast": _off(("sampling_rate_fraction", *BLOCK), sampling_rate_fraction=2e-3),
    "sensor bent by 0.3 % of its range": _volts(SCALES, lambda draw: _bent(0.003)),
    "sensor bent by 1 % of its range": _volts(SCALES, lambda draw: _bent(0.01)),
    "scale 1 % off": _off(SCALES, scale_fraction=0.01),
    "beam 5 mm too high": _off(("position_m", "scale_fraction", *BLOCK), position_m=5e-3),
    "width 1 mm less": _off(("width_m", *EDGES), width_m=-1e-3),
    "card of 12 bits": Kind(lambda block, draw: {"bits": 12}),
    "slow noise": Kind(lambda block, draw: {"slow": 0.5}),
    "hold beyond the range": _volts(("hold_unseen",), lambda draw: faults.saturated(0.8)),
    "mains of 60 Hz": _volts(
        ("other_mains",), lambda draw: faults.tone(60 + draw.uniform(-0.05, 0.05), 0.005)
    ),
}


def _bent(share: float) -> Disturbance:
    """A sensor whose scale bends by a share of its range, between its ends [V]."""
    return lambda time_s, volts, _: volts + 4 * share * volts * (1 - volts / 10)


def cases(size: str) -> list[tuple[str, int]]:
    """Kind and number of each record."""
    return [(name, i) for i in range(SIZES[size]) for name in KINDS]


def stated_laboratory(configuration: str, caliper: bool) -> Laboratory:
    """What is stated of a block of table 1 and its laser; the rest by default."""
    block, _, laser = CONFIGURATIONS[configuration]
    u = DEFAULTS | (CALIPER if caliper else {})
    sizes = {"mass_kg": DEFAULTS["mass_fraction"] * block.mass_kg}
    sizes["inertia_kg_m2"] = u.get("inertia_kg_m2", DEFAULTS["inertia_fraction"]) * block.inertia_cm
    of_block = ("height_m", "width_m", "mass_kg", "com_height_m", "inertia_kg_m2")
    of_laser = ("position_m", "scale_fraction", "sampling_rate_fraction", "response_ms")
    owners = [(configuration, name) for name in of_block] + [("laser", name) for name in of_laser]
    inputs = [Input(owner, name, sizes.get(name) or u[name], caliper) for owner, name in owners]
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
    stated = stated_laboratory(configuration, bool(turn // 2 % 2))
    drawn = tuple(each for each in stated.inputs if each.name != "response_ms")
    true = stated.at(drawn, draw.standard_normal(len(drawn)))
    differs = kind.differs(true.block, draw)
    for key, by in differs.pop("off", {}).items():
        owner = "laser" if key in SCALES or key == "sampling_rate_fraction" else configuration
        true = true.moved(Input(owner, key, by, True), 1.0)
    block = differs.pop("block", true.block)
    soil = {key: value * draw.uniform(1 - SCATTER, 1 + SCATTER) for key, value in _soil(kind, foundation)}
    damping = differs.pop("damping", 1.0)
    soil = {key: value * (damping if key in ("c", "lambda") else 1.0) for key, value in soil.items()}
    if "r" in soil:
        soil["r"] = min(soil["r"], 0.98)
    pivoting = bool(draw.integers(2)) if kind.pivoting is None else kind.pivoting
    angle = CONFIGURATIONS[configuration][1] * draw.uniform(*ANGLES) * draw.choice([-1, 1])
    own: dict[str, Any] = {key: differs.pop(key) for key in OWN if key in differs}
    release = {"fade_s": draw.uniform(5e-3, 20e-3)} | differs
    scene = Scene(block, soil, pivoting or "r" in soil, float(angle), **release)
    volts = _measured(scene, true, own, draw)
    row = {"case": name, "run": i + 1, "law": kind.law, "block": configuration, "foundation": foundation}
    row["known"] = "callipers" if stated.inputs[0].stated else "defaults"
    return Record(volts, stated, replace(true, block=block), soil, row)


def _soil(kind: Kind, foundation: str) -> list[tuple[str, float]]:
    return [*table_2(kind.law, foundation).items()]


def _measured(scene: Scene, true: Laboratory, own: dict[str, Any], draw: Draw) -> Floats:
    """Volts: rest, tilt, hold, run, rest."""
    rate_hz, (laser,) = RATE_HZ / true.clock, true.lasers.values()
    motion = Motion(scene, rate_hz)
    stands, held = motion.stands[:6, None], motion.held[:6, None]
    ramp = np.clip(np.arange(0, TILT_S, 1 / rate_hz) / TILT_S, 0, 1)
    ramp = ramp**3 * (10 - 15 * ramp + 6 * ramp**2)
    still = [np.repeat(each, int(s * rate_hz), axis=1) for each, s in _still(stands, held, draw)]
    states = np.hstack([still[0], stands + (held - stands) * ramp, still[1], motion.states, still[2]])
    way = read(states, scene, laser.position, own.get("incline", 0.0))
    volts = ZERO_V + V_PER_M * (way - way[0]) / true.scales[0]
    begins = still[0].shape[1] + ramp.size + still[1].shape[1]
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


def _still(stands: Floats, held: Floats, draw: Draw) -> list[tuple[Floats, float]]:
    return [(stands, REST_S), (held, draw.uniform(1.5, 2.5)), (stands, draw.uniform(1.5, 2.5))]


def rows_of(case: tuple[str, int]) -> list[Row]:
    """A row per parameter of one record; one without a number where nothing was fitted."""
    name, i = case
    made = record(name, i)
    row = made.row
    try:
        result = _analysed(made.volts, made.stated)
    except FreerockError as error:
        return [row | {"parameter": "", "verdict": "fail", "causes": "", "names": str(error.what)}]
    row = row | _named(result, name) | _advised(made, result, name)
    return [row | each for each in _numbers(result, name, made.true)]


def _analysed(volts: Floats, stated: Laboratory) -> Analysed:
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
            text = reason.text.partition("would take: ")[2] or reason.text
            for found in ADVICE.finditer(text):
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
        then = _analysed(made.volts, followed(made.stated, made.laboratory, to, draw))
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
        elif reason.name == "unmodelled_effect":
            found += re.findall(r"requires (\w+),", reason.text)
        elif reason.name == "unexplained":
            _, _, causes = reason.text.partition("would take: ")
            for cause in filter(None, causes.split("; ")):
                found.append("/".join(re.findall(r"(?:^| or )(\w+),", cause)))
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
    rows, known = [], fit.contributions
    u = fit.stderr if known is None else known.total(fit.stderr, fit.discrepancy)
    for at, each in enumerate(fit.parameters):
        if each in true:
            value, stderr = float(fit.value[at]), float(fit.stderr[at])
            off = value - true[each]
            row = number_row(name, each, true[each], value, stderr, float(u[at]))
            rows.append(row | {"error": off / true[each], "z": off / stderr, "z_u": off / float(u[at])})
    return rows or [{"parameter": ""}]


class _Kinds(Study):
    def markdown(self, frame: pd.DataFrame) -> str:
        """A row per kind: verdicts, numbers, causes; then all, clean ones, and the rest."""
        head = "| kind | ok | warn | fail | first cause right | among three | inside ± 1.96 u "
        lines = [
            head + "| ok beyond 2 u | 3 u | advice followed | then ok | beyond 3 u | first causes |",
            "|---" * 13 + "|",
        ]
        clean = frame["case"].map(lambda name: not KINDS[name].names).astype(bool)
        groups = [*frame.groupby("case", sort=False)]
        groups += [("**clean**", frame[clean]), ("**others**", frame[~clean]), ("**all**", frame)]
        for name, own in groups:
            lines.append(f"| {' | '.join(_cells(str(name), own))} |")
        return "\n".join(lines)


def _cells(name: str, own: pd.DataFrame) -> list[str]:
    runs = own.drop_duplicates(["case", "run"])
    known = own.dropna(subset=["inside"])
    ok = known.loc[known["verdict"] == "ok", "z_u"].abs().astype(float)
    warned = runs["verdict"] != "ok"
    truly = runs["case"].map(lambda each: bool(KINDS[each].names)).astype(bool)
    seen = runs[warned & truly]
    cells = [name, *(str((runs["verdict"] == level).sum()) for level in ("ok", "warn", "fail"))]
    right = [int(seen[each].astype(bool).sum()) for each in ("first", "among")]
    cells += [f"{n} of {len(seen)}" * bool(len(seen)) for n in right]
    cells += [f"{int(known['inside'].astype(bool).sum())} of {len(known)}" * bool(len(known))]
    cells += [str(int((ok > limit).sum()) or "") for limit in (2, 3)]
    followed = runs[runs["advice"].notna()]
    then = followed[followed["advised"] == "ok"]
    cells += [str(n or "") for n in (len(followed), len(then), (then["advised_z_u"] > 3).sum())]
    first = runs.loc[warned, "causes"].fillna("").str.split().str[0].value_counts()
    told = ", ".join(f"{each} {n}" for each, n in first.head(3).items()) if not name.startswith("**") else ""
    return [*cells, told]


STUDY = _Kinds(cases, rows_of, COLUMNS, MARK)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
