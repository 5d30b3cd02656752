"""Names, units, time and sampling rate as people write them in headings.

The words that loggers write in headings, cells and dates are in `words.toml` beside this file.
"""

import re
import string
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from itertools import compress
from pathlib import Path

from freerock.errors import FreerockError
from freerock.records.channels import Even, differ, is_possible
from freerock.units import quantity_of_other, understood

WORDS = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
HEADINGS = {name: frozenset(words.split()) for name, words in WORDS["headings"].items()}
MONTHS = {
    name: n for n, names in enumerate(WORDS["dates"]["months"].split(), start=1) for name in names.split("|")
}


def by_word(table: Mapping[str, str]) -> dict[str, str]:
    """The key of each word in a table of words."""
    return {word: key for key, words in table.items() for word in words.split()}


SECOND_UNITS = {unit: float(size) for unit, size in by_word(WORDS["seconds"]).items()}
HERTZ = {"": 1.0} | {unit: float(size) for unit, size in by_word(WORDS["hertz"]).items()}


Values = Mapping[str, object]  # by name

KNOWN_UNITS = {*SECOND_UNITS, *HEADINGS["units"]}
BRACKETED = re.compile(r"[\[({<]([^\[\](){}<>]*)[\])}>]")
QUOTIENT = re.compile(r"(.*\S)\s+/\s+(\S.*)")  # quantity over unit, as of DIN 1313 and ISO 80000: U / V
BEHIND = re.compile(r"(.*?[^\s_/,])(\s+in\s+|[_/\s,]+)([^\s_/,]+)")
ALONE = re.compile(r"\[.*\]|\(.*\)")  # in a row of units
BRACKETS = "[](){}<> "
BLANK = f"_/{string.whitespace}\N{NO-BREAK SPACE}\N{THIN SPACE}"
NAMES_ITS_UNIT = dict(pair.split("=") for pair in HEADINGS["units_alone"])
TIME_WORDS = re.compile(
    r"(?:^|[:|.] *)(?:(?:rel|relative|elapsed|abs|absolute|unix|mess|uhr|local|date|test|(?:run|set) *#?\d*)"
    rf"[\s_./]*)?(?:{'|'.join(HEADINGS['time_words'])})(?![^\W\d_])"
)
THIN = " '’\N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}"  # between thousands, and nowhere else
AMBIGUOUS = re.compile(
    r"[1-9]\d{0,2}[.,]\d{3}"
)  # a comma is, a point only without decimal points in the table
STATEMENT = re.compile(  # value, unit, next cell
    rf"\s*([-+]?[\d.,]*\d(?:[{THIN}]\d{{3}}(?!\d))*(?:[eE][-+]?\d+)?)\s*([a-zA-Zµμ/]*)(?:[\s;,(\[]+([a-zA-Zµμ/]+))?"
)


def split_unit(text: str) -> tuple[str, str]:
    """Name and unit of a heading such as "Time [s]", "volts (V)", "theta_deg", "U / V", "t/ms" or "laser"."""
    text = " ".join(line.strip() for line in text.splitlines()).strip('" ')
    for bracketed in reversed([*BRACKETED.finditer(text)]):
        unit, behind = bracketed[1].strip(), text[bracketed.end() :].strip()
        if not unit.isdecimal() and (not behind or unit.casefold() in KNOWN_UNITS):
            return f"{text[: bracketed.start()].strip(BLANK)} {behind}".strip(), unit
    if (found := QUOTIENT.fullmatch(text)) and _is_quotient(found[2]):
        return found[1], found[2]
    if found := BEHIND.fullmatch(text):
        name, between, unit = found.groups()
        of_time = unit.casefold() in SECOND_UNITS and is_time_word(name)
        parted = between.strip(" ,") and unit.casefold() not in HEADINGS["units_in_brackets"]
        if of_time or (parted and unit.casefold() in KNOWN_UNITS):
            return name, unit
    return text, NAMES_ITS_UNIT.get(text.casefold(), "")


def is_time(text: str) -> bool:
    """Whether a heading names a column of time."""
    return is_time_word(split_unit(text)[0])


def is_time_word(name: str) -> bool:
    """Whether a name without its unit is one of time."""
    found = plain(name) in HEADINGS["times"] or TIME_WORDS.search(name.casefold())
    return name != "T" and bool(found)  # a temperature


def seconds_in(where: object, unit: str) -> float:
    """A unit of time [s]; also of the form "seconds since 2017-05-01".

    Raises
    ------
    FreerockError
        No unit of time that is known.
    """
    plain = unit.casefold().split(" since ")[0].strip(" .")
    if plain not in SECOND_UNITS:
        raise FreerockError(where, f"the time is in {unit[:40]!r}", "give it in s, ms, us or min")
    return SECOND_UNITS[plain]


def stated_rate(path: object, values: Values, decimal: str = ".") -> Even | None:
    """Sampling interval from values by name, such as fs, "Sampling rate [kHz]" or dt.

    Raises
    ------
    FreerockError
        A unit that is not known, a mark that may stand between thousands, or two that contradict each other.
    """
    rates = dict(_rates(path, values, decimal))
    first: Even | None = None
    for even in rates.values():
        if isinstance(even, FreerockError):
            raise even
        first = first or even
        if differ(even.step_s, first.step_s):
            hertz = f"{' and '.join(rates)} give {1 / first.step_s:.6g} and {1 / even.step_s:.6g} Hz"
            raise FreerockError(path, hertz, "correct the one that is wrong, or leave it out")
    return first


def also_stated(path: object, values: Values, decimal: str = ".") -> tuple[Even, ...]:
    """What is stated beside a column of time, as far as it can be understood."""
    return tuple(even for _, even in _rates(path, values, decimal) if isinstance(even, Even))


def states_rate(name: str) -> bool:
    """Whether a name is that of a sampling rate or interval, in whatever unit."""
    return _is_rate(plain(split_unit(name)[0])) is not None


def _is_rate(name: str) -> bool | None:
    """Whether a plain name is that of a sampling rate; False for an interval, None for neither."""
    if {name, name.removesuffix("hz")} & HEADINGS["rates"]:
        return True
    return False if name in HEADINGS["steps"] else None


def _rates(path: object, values: Values, decimal: str) -> Iterator[tuple[str, Even | FreerockError]]:
    """Sampling intervals by the names under which they are stated, or why one is not understood."""
    for heading, value in values.items():
        name, unit = split_unit(heading)
        is_rate = _is_rate(plain(name))
        if is_rate is None or not isinstance(value, str | int | float):
            continue
        units = HERTZ if is_rate else {"": 1.0} | SECOND_UNITS
        if isinstance(value, str):
            match = STATEMENT.match(value)
            text, here, next_cell = match.groups("") if match else ("", "", "")
            behind = next_cell if next_cell.casefold() in units.keys() - HEADINGS["not_a_unit"] else ""
            unit = here or unit or behind
            if AMBIGUOUS.fullmatch(text) and ("," in text or decimal != "."):
                what = f"the comma or point of {heading} {text} may stand between thousands, or be decimal"
                yield heading, FreerockError(path, what, "write the number without it")
                continue
            value = _number(text) if text else 0.0
        if not is_possible(value):
            continue
        factor = units.get(unit.casefold())
        if factor is None:
            remedy = f"give it in {'Hz, kHz, MHz or samples/s' if is_rate else 's, ms, us or ns'}"
            yield heading, FreerockError(path, f"{heading} is in {unit[:40]!r}", remedy)
        else:
            yield heading, Even(1 / (value * factor) if is_rate else value * factor)


def _number(text: str) -> float:
    """A number in which points and commas may stand between thousands."""
    last = max(",.", key=text.rfind)
    text = re.sub(f"[{THIN}]", "", text).replace("." if last == "," else ",", "")
    text = text.replace(last, "" if text.count(last) > 1 else ".")
    return float(text)


def headed(rows: Sequence[Sequence[str]], width: int) -> list[tuple[str, str]]:
    """Name and unit of each column under one or several rows of headings.

    A row of units gives units. A label over several columns (a merged cell) counts for each of them; what all
    signals share is left out of the names.
    """
    names: list[list[str]] = []
    units = [""] * width
    for n, row in enumerate(rows):
        cells = [*row, *[""] * (width - len(row))]
        if of_units(cells, first=n == 0):
            units = [cell.strip(BRACKETS) or unit for cell, unit in zip(cells, units, strict=True)]
            continue
        merged = cells[0] and "" in cells[:-1] and n + 1 < len(rows)
        for i in range(1, width if merged else 0):
            cells[i] = cells[i] or cells[i - 1]
        split = [split_unit(cell) for cell in cells]
        names.append([name for name, _ in split])
        units = [unit or above for (_, unit), above in zip(split, units, strict=True)]
    parts = [*zip(*names, strict=True)] or [("",)] * width
    signals = [each for each in parts if not is_time_word(each[-1])] or parts
    differing = [len({*level}) > 1 for level in zip(*signals, strict=True)]
    if len(signals) == 1:
        differing[-1] = True
    elif "" in (short := [_joined(each, differing) for each in signals]) or len({*short}) < len(short):
        differing = [True] * len(differing)
    return [
        (each[-1] if is_time_word(each[-1]) else _joined(each, differing), unit)
        for each, unit in zip(parts, units, strict=True)
    ]


def _joined(parts: Sequence[str], kept: Sequence[bool]) -> str:
    return " ".join(dict.fromkeys(filter(None, compress(parts, kept))))


def of_units(cells: Sequence[str], first: bool = False) -> bool:
    """Whether a row of headings holds units alone; below another also what counts, as Sequence, Volt."""
    filled = {cell for cell in cells if cell}
    others = {c for c in filled if c.strip(BRACKETS).casefold() not in KNOWN_UNITS and not ALONE.fullmatch(c)}
    counters = not first and all(plain(cell) in HEADINGS["counters"] for cell in others)
    return len(others) < len(filled) and (not others or counters)


def plain(name: str) -> str:
    """A name less its blanks and signs, in lower case."""
    return re.sub(r"[\s_.:#\-()\[\]]+", "", name).casefold()


def _is_quotient(unit: str) -> bool:
    """Whether what stands below a quantity is a unit; numbers and signs may be part of a name: laser / 1."""
    known = unit.casefold() in KNOWN_UNITS or understood(unit) or quantity_of_other(unit)
    return unit not in ("1", "-") and bool(known)
