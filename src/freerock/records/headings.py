"""Names, units, time and sampling rate as people write them in headings."""

import re
import string
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike

from freerock import bounds
from freerock.errors import FreerockError
from freerock.records.channels import SECONDS_OF_UNIT, Channel, Even, Stamps, differ
from freerock.units import quantity_of_other, understood

NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?|[-+]?nan|[-+]?inf", re.IGNORECASE | re.ASCII)
WANTED = {"n": "a number", "c": "a time"}  # kinds of cells of a table
KNOWN_UNITS = (
    {unit for unit in SECONDS_OF_UNIT if unit}
    | {"v", "mv", "volt", "volts", "a", "ma", "amp", "amps"}
    | {"m", "mm", "cm", "um", "µm", "rad", "mrad", "deg", "°", "degrees", "radians"}
    | {"hz", "khz", "n", "kn", "g", "m/s", "m/s2", "m/s^2", "m/s²", "rad/s", "-", "1"}
)
IN_BRACKETS = re.compile(r"[\[(]([^\[\]()]*)[\])]$")
OVER = re.compile(r"\s/\s")  # quantity over unit, as of DIN 1313 and ISO 80000: U / V
BLANK = f"_{string.whitespace}\N{NO-BREAK SPACE}\N{THIN SPACE}"
HERTZ = {  # units of a sampling rate
    prefix + unit: factor
    for prefix, factor in (("", 1.0), ("k", 1e3), ("m", 1e6))
    for unit in ("hz", "s/s", "sa/s", "sps", "sample/s", "samples/s", "samples")
} | {"": 1.0, "1/s": 1.0}
NEXT_CELL = {  # units that, behind a number, don't begin another statement: Min, Samples
    True: HERTZ.keys() - {"samples", "ksamples", "msamples"},
    False: SECONDS_OF_UNIT.keys() - {"min", "minute", "minutes"},
}
TIMES = {"t", "time", "times", "zeit", "tempo", "temps", "tiempo", "xvalue", "timestamp", "elapsedtime"}
RATES = {"fs", "samplingrate", "samplerate", "samplingfrequency", "samplefrequency", "abtastrate"}
STEPS = {"dt", "ts", "deltat", "deltax", "samplinginterval", "sampleinterval", "samplingperiod"}
STEPS |= {"wfincrement"}


def split_unit(text: str) -> tuple[str, str]:
    """Name and unit of a heading such as "Time [s]", "volts (V)", "theta_deg", "U / V", "t/ms" or "laser"."""
    text = " ".join(line.strip() for line in text.splitlines()).strip('" ')
    if bracketed := IN_BRACKETS.search(text):
        name = text[: bracketed.start()].rstrip(BLANK).strip()
        return name.removesuffix("/").rstrip(BLANK), bracketed[1].strip()
    parts = OVER.split(text)
    if len(parts) > 1 and parts[0].strip() and _is_quotient(unit := parts[-1].strip()):
        return text[: -len(parts[-1])].rstrip(BLANK).removesuffix("/").rstrip(BLANK), unit
    unit = re.split(r"[_/\s]", text)[-1]
    name = text.removesuffix(unit) if unit else text
    if name.endswith(("_", "/")):
        name = name[:-1]
    elif name.split()[-1:] == ["in"] and name[-1:].isspace():
        name = name.rstrip().removesuffix("in")
        name = name if name[-1:].isspace() else ""
    else:
        name = ""
    if name.strip() and unit.casefold() in KNOWN_UNITS - {"1", "-", "t", "a", "m", "n", "g"}:
        return name.strip(), unit
    return text, ""


def is_time(text: str) -> bool:
    """Whether a heading names a column of time."""
    name, _ = split_unit(text)
    return _plain(name) in TIMES and name != "T"  # a temperature


def stated_rate(path: object, values: Mapping[str, object]) -> Even | None:
    """Sampling interval from values by name, such as fs, "Sampling rate [kHz]" or dt.

    Raises
    ------
    FreerockError
        A unit that is not known, a comma that may stand between thousands, or two that contradict each other.
    """
    rates = [*stated_rates(path, values).items()]
    for place, even in rates[1:]:
        first, known = rates[0]
        if differ(even.step_s, known.step_s):
            hertz = f"{first} gives {1 / known.step_s:.6g} Hz and {place} gives {1 / even.step_s:.6g} Hz"
            raise FreerockError(path, hertz, "correct the one that is wrong, or leave it out")
    return rates[0][1] if rates else None


def stated_rates(path: object, values: Mapping[str, object]) -> dict[str, Even]:
    """Sampling intervals by the names under which they are stated; raises as `stated_rate`, but for two."""
    rates: dict[str, Even] = {}
    for heading, is_rate, number, unit in _statements(values):
        if re.fullmatch(r"[1-9]\d{0,2}(,\d{3})+", str(number)):
            what = f"the comma of {heading} {number} may stand for a point, or between thousands"
            raise FreerockError(path, what, "write the number without it")
        written = str(number).replace(",", ".")
        value = float(written) if NUMBER.fullmatch(written) else 0.0
        if not bounds.SHORTEST_STEP_S < value < bounds.LONGEST_STEP_S:
            continue
        factor = (HERTZ if is_rate else SECONDS_OF_UNIT).get(unit.casefold())
        if factor is None:
            remedy = f"give it in {'Hz, kHz, MHz or samples/s' if is_rate else 's, ms, us or ns'}"
            raise FreerockError(path, f"{heading} is in {unit[:40]!r}", remedy)
        rates[heading] = Even(1 / (value * factor) if is_rate else value * factor)
    return rates


def also_stated(path: object, values: Mapping[str, object]) -> tuple[Even, ...]:
    """What is stated beside a column of time, as far as it can be understood."""
    rates: dict[str, Even] = {}
    for heading, value in values.items():
        with suppress(FreerockError):
            rates |= stated_rates(path, {heading: value})
    return tuple(rates.values())


def states_rate(values: Mapping[str, object]) -> bool:
    """Whether one of the values is a sampling rate or interval, in whatever unit."""
    return any(True for _ in _statements(values))


def _statements(values: Mapping[str, object]) -> Iterator[tuple[str, bool, object, str]]:
    """Rates and intervals among values by name: heading, whether it is a rate, number as written, unit."""
    for heading, value in values.items():
        name, unit = split_unit(heading)
        name = _plain(name)
        is_rate = name in RATES or name.removesuffix("hz") in RATES
        if not is_rate and name not in STEPS:
            continue
        if isinstance(value, str):
            number = re.match(r"\s*([-+\d.,eE]*\d)\s*([a-zA-Zµμ/]*)(?:[\s;,(\[]+([a-zA-Zµμ/]+))?", value)
            value, here, next_cell = number.groups("") if number else (None, "", "")
            unit = here or unit or (next_cell if next_cell.casefold() in NEXT_CELL[is_rate] else "")
        if value is not None:
            yield heading.strip(), is_rate, value, unit


def headed(rows: Sequence[Sequence[object]], width: int) -> list[tuple[str, str]]:
    """Name and unit of each column under one or several rows of headings.

    A row of units gives units. A label over several columns (a merged cell) counts for each of them; what all
    columns share is left out of the names.
    """
    names: list[list[str]] = [[] for _ in range(width)]
    units = [""] * width
    for row in rows:
        cells = [str(cell).strip() for cell in row[:width]] + [""] * (width - len(row))
        filled = [cell for cell in cells if cell]
        if filled and all(_is_unit(cell) for cell in filled):
            units = [_bare(cell) or unit for cell, unit in zip(cells, units, strict=True)]
            continue
        if cells[0] and "" in cells[:-1]:
            for i in range(1, width):
                cells[i] = cells[i] or cells[i - 1]
        for i, cell in enumerate(cells):
            name, unit = split_unit(cell)
            names[i].append(name)
            units[i] = unit or units[i]
    return list(zip(_joined(names), units, strict=True))


def columns(
    path: object,
    headings: Sequence[tuple[str, str]],
    numeric: Iterable[int],
    clocks: Sequence[int],
    first_rises: bool,
    stated: Mapping[str, object],
    group: str = "",
) -> tuple[list[Channel], list[str]]:
    """Channels of a table, and what had to be found out.

    Parameters
    ----------
    headings : sequence of (str, str)
        Name and unit of each column, as `headed` gives them.
    numeric : iterable of int
        The columns that hold numbers.
    clocks : sequence of int
        The columns that hold times of a clock.
    first_rises : bool
        Whether the first numeric column rises steadily, as time does.
    stated : mapping
        What the file states by name, maybe its sampling rate, which counts where no column holds the time.
    group : str
        Of these channels; their columns are named (group, column).

    Returns
    -------
    (list of Channel, list of str)
        Each channel belongs to the column of time next to its left, else to the first one.

    Raises
    ------
    FreerockError
        Neither a column of time nor a sampling rate, or one whose meaning is open; nothing but time.
    """
    numeric, notes = list(numeric), []
    times = [*clocks, *(i for i in numeric if is_time(headings[i][0]))]
    rate = None if times else stated_rate(path, stated)
    also = also_stated(path, stated) if times else ()
    if not times and rate is None and first_rises and len(numeric) > 1:
        times = numeric[:1]
        notes.append(f"column {times[0] + 1} rises steadily and is taken for time")
    channels: list[tuple[str, str, int, Stamps | None]] = []
    clock: Stamps | None = None
    for i in sorted({*numeric, *clocks}):
        name, unit = headings[i]
        if i in times:
            clock = Stamps(name or f"column {i + 1}", (group, i), "s" if i in clocks else unit)
        else:
            channels.append((name or f"column {i + 1}", unit, i, clock))
    first = next((left for *_, left in channels if left), clock) or rate
    if first is None:
        remedy = "head the column of time with time [s], or state the sampling rate"
        raise FreerockError(path, "no column of time and no sampling rate", remedy)
    if not channels:
        raise FreerockError(path, "no channel beside the time", "export at least one channel")
    names = _distinct(name for name, *_ in channels)
    return [
        Channel(name, unit, (group, i), left or first, group, also)
        for name, (_, unit, i, left) in zip(names, channels, strict=True)
    ], notes


def rises(values: ArrayLike) -> bool:
    """Whether numbers rise as steadily as time does."""
    numbers = np.asarray(values, float)
    steps = np.diff(numbers[np.isfinite(numbers)])
    return bool(steps.size > 1 and steps.min() >= 0 and 0 < steps.max() <= 1.5 * np.median(steps))


def _plain(name: str) -> str:
    return re.sub(r"[\s_.:-]+", "", name).casefold()


def _is_quotient(unit: str) -> bool:
    """Whether what stands below a quantity is a unit; numbers and signs may be part of a name: laser / 1."""
    if unit in ("1", "-"):
        return False
    return unit.casefold() in KNOWN_UNITS or bool(understood(unit) or quantity_of_other(unit))


def _bare(cell: str) -> str:
    return cell.strip("[]() ")


def _is_unit(cell: str) -> bool:
    return _bare(cell).casefold() in KNOWN_UNITS or bool(re.fullmatch(r"\[.*\]|\(.*\)", cell))


def _joined(names: Sequence[Sequence[str]]) -> list[str]:
    """Names from the parts of each column, less the parts that all columns but those of time share."""
    data = [parts for parts in names if not (parts and is_time(parts[-1]))] or names
    depth = len(data[0])
    kept: Collection[int] = [level for level in range(depth) if len({parts[level] for parts in data}) > 1]
    short = [" ".join(parts[level] for level in kept if parts[level]) for parts in data]
    if len(data) == 1 or "" in short or len(set(short)) < len(short):
        kept = range(max(0, depth - 1), depth) if len(data) == 1 else range(depth)
    return [
        parts[-1]
        if parts and is_time(parts[-1])
        else " ".join(dict.fromkeys(parts[level] for level in kept if parts[level]))
        for parts in names
    ]


def _distinct(names: Iterable[str]) -> list[str]:
    """Names with (2), (3) … after repeated ones."""
    seen: dict[str, int] = {}
    distinct = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        distinct.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return distinct
