"""Names, units, time and sampling rate as people write them in headings."""

import re
import string
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress

from freerock import bounds
from freerock.errors import FreerockError
from freerock.records.channels import Even, differ
from freerock.records.times import SECOND_UNITS
from freerock.units import quantity_of_other, understood

_UNITS = "v mv volt volts a ma amp amps m mm cm um µm rad mrad deg ° degrees radians hz khz n kn g - 1"
KNOWN_UNITS = {*SECOND_UNITS, *_UNITS.split(), "m/s", "m/s2", "m/s^2", "m/s²", "rad/s"}
BRACKETED = re.compile(r"[\[({<]([^\[\](){}<>]*)[\])}>]")
OVER = re.compile(r"\s/\s")  # quantity over unit, as of DIN 1313 and ISO 80000: U / V
BLANK = f"_{string.whitespace}\N{NO-BREAK SPACE}\N{THIN SPACE}"
HERTZ = {  # units of a sampling rate
    prefix + unit: factor
    for prefix, factor in (("", 1.0), ("k", 1e3), ("m", 1e6))
    for unit in ("hz", "s/s", "sa/s", "sps", "sample/s", "samples/s", "samples")
} | {"": 1.0, "1/s": 1.0}
NEXT_CELL = {  # units that, behind a number, don't begin another statement: Min, Samples
    True: HERTZ.keys() - {"samples", "ksamples", "msamples"},
    False: SECOND_UNITS.keys() - {"min", "minute", "minutes"},
}
_NAMES = "second=s seconds=s sec=s secs=s sekunden=s milliseconds=ms millis=ms micros=us"
NAMES_ITS_UNIT = dict(pair.split("=") for pair in _NAMES.split())
TIMES = {"t", "xvalue", "elapsed", "epoch", "unix"}
TIME_WORDS = re.compile(
    r"(?:^|[:|.] *)(?:(?:rel|relative|elapsed|abs|absolute|unix|mess|uhr|local|date|test|(?:run|set) *#?\d*)"
    r"[\s_./]*)?(?:times?|zeit|tempo|temps|tiempo|tijd|time[\s_]?stamp|zeitstempel|datetime|datum)(?![a-zäöüé])"
)
_COUNTERS = """
sample samples sampleno samplenr samplenumber index idx frame frames frameno framenumber sequence seq no nr
n i num count counter point points pointno pointnumber row rowid record scan scans scanno scannumber id
messwert messwertnr lfdnr nummer number unnamed0 step datapoint reading block tick ticks
"""
_RATES = """
fs samplingrate samplerate samplingfrequency samplefrequency abtastrate abtastfrequenz messrate scanrate
datarate acquisitionrate rate framerate capturerate fps bildrate
"""
_STEPS = """
dt ts deltat deltax samplinginterval sampleinterval samplingperiod sampleperiod wfincrement increment
xincrement xincr xinc tinc timeincrement timestep abtastintervall abtastzeit horizontalinterval timeinterval
"""
COUNTERS, RATES, STEPS = ({*words.split()} for words in (_COUNTERS, _RATES, _STEPS))
KEY = ", or give sampling_rate_hz"


def split_unit(text: str) -> tuple[str, str]:
    """Name and unit of a heading such as "Time [s]", "volts (V)", "theta_deg", "U / V", "t/ms" or "laser"."""
    text = " ".join(line.strip() for line in text.splitlines()).strip('" ')
    for bracketed in reversed([*BRACKETED.finditer(text)]):
        unit = bracketed[1].strip()
        if bracketed.end() == len(text) or unit.casefold() in KNOWN_UNITS:
            before = text[: bracketed.start()].rstrip(BLANK).removesuffix("/").rstrip(BLANK)
            return f"{before.strip()} {text[bracketed.end() :].strip()}".strip(), unit
    parts = OVER.split(text)
    if len(parts) > 1 and parts[0].strip() and _is_quotient(unit := parts[-1].strip()):
        return text[: -len(parts[-1])].rstrip(BLANK).removesuffix("/").rstrip(BLANK), unit
    unit = re.split(r"[_/\s,]", text)[-1]
    name = text.removesuffix(unit) if unit else text
    if unit.casefold() in SECOND_UNITS and is_time_word(name.strip(" _/,")):
        return name.strip(" _/,").removesuffix(" in"), unit
    if name.endswith(("_", "/")):
        name = name[:-1]
    elif name.split()[-1:] == ["in"] and name[-1:].isspace():
        name = name.rstrip().removesuffix("in")
        name = name if name[-1:].isspace() else ""
    else:
        name = ""
    if name.strip() and unit.casefold() in KNOWN_UNITS - {"1", "-", "t", "a", "m", "n", "g", "d", "h"}:
        return name.strip(), unit
    return text, NAMES_ITS_UNIT.get(text.casefold(), "")


def is_time(text: str) -> bool:
    """Whether a heading names a column of time."""
    return is_time_word(split_unit(text)[0])


def is_time_word(name: str) -> bool:
    """Whether a name without its unit is one of time."""
    if name == "T":  # a temperature
        return False
    return plain(name) in TIMES or bool(TIME_WORDS.search(name.casefold()))


def seconds_in(where: object, unit: str) -> float:
    """A unit of time [s]; also of the form "seconds since 2017-05-01".

    Raises
    ------
    FreerockError
        No unit of time that is known.
    """
    plain = unit.casefold().split(" since ")[0].strip(" .")
    if plain not in SECOND_UNITS:
        raise FreerockError(
            where, f"the time is in {unit[:40]!r}", "give it in s, ms, us or min, or give time_unit"
        )
    return SECOND_UNITS[plain]


def stated_rate(path: object, values: Mapping[str, object], decimal: str = ".") -> Even | None:
    """Sampling interval from values by name, such as fs, "Sampling rate [kHz]" or dt.

    Raises
    ------
    FreerockError
        A unit that is not known, a mark that may stand between thousands, or two that contradict each other.
    """
    rates = [*stated_rates(path, values, decimal).items()]
    for place, even in rates[1:]:
        first, known = rates[0]
        if differ(even.step_s, known.step_s):
            hertz = f"{first} gives {1 / known.step_s:.6g} Hz and {place} gives {1 / even.step_s:.6g} Hz"
            raise FreerockError(path, hertz, "correct the one that is wrong, or leave it out")
    return rates[0][1] if rates else None


def stated_rates(path: object, values: Mapping[str, object], decimal: str = ".") -> dict[str, Even]:
    """Sampling intervals by the names under which they are stated; raises as `stated_rate`, but for two."""
    rates: dict[str, Even] = {}
    for heading, is_rate, number, unit in _statements(values):
        value = _number(path, heading, number, decimal) if isinstance(number, str) else float(number)
        if not bounds.SHORTEST_STEP_S < value < bounds.LONGEST_STEP_S:
            continue
        factor = (HERTZ if is_rate else {"": 1.0} | SECOND_UNITS).get(unit.casefold())
        if factor is None:
            remedy = f"give it in {'Hz, kHz, MHz or samples/s' if is_rate else 's, ms, us or ns'}"
            raise FreerockError(path, f"{heading} is in {unit[:40]!r}", remedy)
        rates[heading] = Even(1 / (value * factor) if is_rate else value * factor)
    return rates


def also_stated(path: object, values: Mapping[str, object], decimal: str = ".") -> tuple[Even, ...]:
    """What is stated beside a column of time, as far as it can be understood."""
    rates: dict[str, Even] = {}
    for heading, value in values.items():
        with suppress(FreerockError):
            rates |= stated_rates(path, {heading: value}, decimal)
    return tuple(rates.values())


def states_rate(values: Mapping[str, object]) -> bool:
    """Whether one of the values is a sampling rate or interval, in whatever unit."""
    return any(True for _ in _statements(values))


def _statements(values: Mapping[str, object]) -> Iterator[tuple[str, bool, str | float, str]]:
    """Rates and intervals among values by name: heading, whether it is a rate, number as written, unit."""
    for heading, value in values.items():
        name, unit = split_unit(heading)
        name = plain(name)
        is_rate = name in RATES or name.removesuffix("hz") in RATES
        if not is_rate and name not in STEPS:
            continue
        if isinstance(value, str):
            number = re.match(r"\s*([-+\d.,eE]*\d)\s*([a-zA-Zµμ/]*)(?:[\s;,(\[]+([a-zA-Zµμ/]+))?", value)
            value, here, next_cell = number.groups("") if number else (None, "", "")
            unit = here or unit or (next_cell if next_cell.casefold() in NEXT_CELL[is_rate] else "")
        if isinstance(value, str | int | float):
            yield heading.strip(), is_rate, value, unit


def _number(path: object, heading: str, text: str, decimal: str) -> float:
    """A number of a header, in which points and commas may stand between thousands."""
    used = [mark for mark in ",." if mark in text]
    last = max(used, key=text.rindex, default="")
    if (
        len(used) == 1
        and text.count(last) == 1
        and re.fullmatch(r"[1-9]\d{0,2}[.,]\d{3}", text)
        and (last == "," or decimal != ".")
    ):
        said = "comma" if last == "," else "point"
        what = f"the {said} of {heading} {text} may be the decimal mark, or stand between thousands"
        raise FreerockError(path, what, "write the number without it")
    thousands = last if text.count(last or "x") > 1 else {",": ".", ".": ","}.get(last, "")
    plain = text.replace(thousands, "") if thousands else text
    try:
        return float(plain.replace(",", "."))
    except ValueError:
        return 0.0


def headed(rows: Sequence[Sequence[object]], width: int) -> list[tuple[str, str]]:
    """Name and unit of each column under one or several rows of headings.

    A row of units gives units. A label over several columns (a merged cell) counts for each of them; what all
    columns share is left out of the names.
    """
    names: list[list[str]] = [[] for _ in range(width)]
    units = [""] * width
    for n, row in enumerate(rows):
        cells = [str(cell).strip() for cell in row[:width]] + [""] * (width - len(row))
        if of_units(cells, first=n == 0):
            units = [_bare(cell) or unit for cell, unit in zip(cells, units, strict=True)]
            continue
        if cells[0] and "" in cells[:-1] and n + 1 < len(rows):
            for i in range(1, width):
                cells[i] = cells[i] or cells[i - 1]
        for i, cell in enumerate(cells):
            name, unit = split_unit(cell)
            names[i].append(name)
            units[i] = unit or units[i]
    return list(zip(_joined(names), units, strict=True))


def of_units(cells: Sequence[str], first: bool = False) -> bool:
    """Whether a row of headings holds units alone; below another also what counts, as Sequence, Volt."""
    filled = [cell for cell in cells if cell]
    units = [cell for cell in filled if _is_unit(cell)]
    return bool(units) and (
        len(units) == len(filled) or (not first and all(plain(c) in COUNTERS or c in units for c in filled))
    )


def plain(name: str) -> str:
    """A name less its blanks and signs, in lower case."""
    return re.sub(r"[\s_.:#\-()\[\]]+", "", name).casefold()


def _is_quotient(unit: str) -> bool:
    """Whether what stands below a quantity is a unit; numbers and signs may be part of a name: laser / 1."""
    if unit in ("1", "-"):
        return False
    return unit.casefold() in KNOWN_UNITS or bool(understood(unit) or quantity_of_other(unit))


def _bare(cell: str) -> str:
    return cell.strip("[](){}<> ")


def _is_unit(cell: str) -> bool:
    return _bare(cell).casefold() in KNOWN_UNITS or bool(re.fullmatch(r"\[.*\]|\(.*\)", cell))


def _joined(names: Sequence[Sequence[str]]) -> list[str]:
    """Names from the parts of each column, less the parts that all columns but those of time share."""
    data = [parts for parts in names if not (parts and is_time_word(parts[-1]))] or names
    depth = len(data[0])
    kept: Collection[int] = [level for level in range(depth) if len({parts[level] for parts in data}) > 1]
    short = [" ".join(parts[level] for level in kept if parts[level]) for parts in data]
    if len(data) == 1 or "" in short or len(set(short)) < len(short):
        kept = range(max(0, depth - 1), depth) if len(data) == 1 else range(depth)
    return [
        parts[-1]
        if parts and is_time_word(parts[-1])
        else " ".join(dict.fromkeys(parts[level] for level in kept if parts[level]))
        for parts in names
    ]
