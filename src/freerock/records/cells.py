"""What a cell of a table says: a number, a mark of a missing sample, a time, a date, or text."""

import re
from collections.abc import Callable, Sequence
from datetime import date, timedelta
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError, number_of
from freerock.records.headings import MONTHS, SECOND_UNITS, WORDS

NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE | re.ASCII)
THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:([.,'’ \N{NO-BREAK SPACE}\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d+)?")
MARKS = {
    sign + mark.replace("_", " "): value
    for kind, value in {"over": np.inf, "under": -np.inf, "missing": np.nan}.items()
    for mark in WORDS["marks"][kind].split()
    for sign in ("", "+")
}
OVERLOAD = 9.9e37  # instruments write it, or a little more, for a sample out of range

Samples = tuple[Floats, list[str]]  # and what was found out
_MONTH = rf"(?:{'|'.join(MONTHS)})[a-zäéûô]*\.?"
ISO = r"\d{4}-\d\d-\d\d|\d{4}/\d\d/\d\d|\d{4}\.\d\d\.\d\d"
DAYS = r"\d\d?\.\d\d?\.(?:\d{4}|\d\d)|\d\d?/\d\d?/(?:\d{4}|\d\d)|\d\d?-\d\d?-\d{4}"  # day or month first
NAMED = rf"\d\d?\.?[-/ ]{_MONTH}[-/ ]\d{{4}}|{_MONTH}[ -]\d\d?,?[ -]\d{{4}}"  # 14-Sep-2024, Sep 14, 2024
PASSED = r"\d+ days?"  # of a duration
WEEKDAY = r"(?:(?:mon|tue|wed|thu|fri|sat|sun|mo|di|mi|do|fr|sa|so)[a-z]*\.?,? )?"
_FLAGS = re.ASCII | re.IGNORECASE
_OF_DAY = r"(?:(?P<hour>\d{1,4}):)?(?P<minute>[0-5]?\d):(?P<second>[0-5]?\d(?:[.,:]\d+)?)"
_ZONE = r" ?(?:Z|UTC|GMT|[-+]\d\d:?\d\d|[-+]\d\d)"
STAMP = re.compile(
    rf"{WEEKDAY}(?:(?P<day>{ISO}|{DAYS}|{NAMED}|{PASSED})(?:,? +\+?|T|,))?{_OF_DAY}"
    rf"(?:[ \N{{NO-BREAK SPACE}}\u202f]?(?P<half>[ap])\.?m\.?)?(?P<zone>{_ZONE})?",
    _FLAGS,
)
DATE = re.compile(rf"{WEEKDAY}(?:{ISO}|{DAYS}|{NAMED})", _FLAGS)
DURATION = re.compile(r"([-+]?[\d.,]+(?:e[-+]?\d+)?) ?([a-zµμ]+(?:\(s\))?)", re.IGNORECASE)
ORDERS = {"ymd": "year, month, day", "dmy": "day, month, year", "mdy": "month, day, year"}
NO_DATE = date.max
EXPORT = "export the times as 2026-11-22T09:30:00.125, or as seconds"
CLOCK_JUMPS_S = (-86400.0, -3600.0, 3600.0)  # at midnight; at a full hour, or where the clock is set


def mark(cell: str) -> float | None:
    """inf or −inf for a mark of a sample out of range, NaN for one of a missing sample, else None."""
    plain = cell.strip().casefold().replace("_", " ")
    blank = plain and plain[0] in "#*-–—_?." and not plain.strip(plain[0])
    return np.nan if blank else MARKS.get(plain)


def kind_of(cell: str, decimal: str) -> str:
    """n for a number, m for a mark, c for a time, d for a date alone, t for other text, "" where empty."""
    if not cell:
        return ""
    if NUMBER.fullmatch(cell.replace(decimal, ".")):
        return "t" if decimal == "," and "." in cell else "n"
    if mark(cell) is not None:
        return "m"
    if DATE.fullmatch(cell):
        return "d"
    return "c" if is_clock(cell) else "t"


def numbers(where: object, cells: "pd.Series[Any]", decimal: str, place: Callable[[int], str]) -> Samples:
    """Cells as numbers, inf for a sample out of range, NaN for a missing one; and a note on each mark.

    Parameters
    ----------
    where : object
        The file, for errors.
    cells : pandas.Series
        Numbers, or texts; its index numbers the rows.
    decimal : str
        The decimal mark.
    place : callable
        How a cell is named, by its row's number.

    Raises
    ------
    FreerockError
        A cell that is neither a number nor a mark.
    """
    if cells.dtype.kind in "iuf":
        return cells.to_numpy(float), []
    text = cells.str.strip().replace("", None)
    plain = text
    if decimal != ".":
        plain = text.where(~text.str.contains(".", regex=False, na=False)).str.replace(decimal, ".")
    values = pd.to_numeric(plain, errors="coerce").to_numpy(float, copy=True)
    odd = text[np.isnan(values) & text.notna().to_numpy()]
    marked = {cell: mark(cell) for cell in odd.unique()}
    for row, cell in odd.items():
        if marked[cell] is None:
            what = f"{place(row)}: {why_no_number(cell)}"
            raise FreerockError(where, what, "correct the line, or export the file again")
    values[cells.index.get_indexer(odd.index)] = odd.map(marked).to_numpy(float)
    marks = odd.value_counts().items()
    return values, [f"{number_of(n, 'cell')} marked {cell!r} taken as missing" for cell, n in marks]


def why_no_number(cell: str) -> str:
    """What is wrong with a cell that should hold a number, in words."""
    if THOUSANDS.fullmatch(cell):
        return f"{cell[:40]!r} has a mark between thousands, or another decimal mark than the file"
    return f"{cell[:40]!r} is not a number"


def is_clock(cell: str) -> bool:
    """Whether a cell is a time of day, with a date or without, or a duration with its unit."""
    if found := STAMP.fullmatch(cell):
        return bool(found["hour"] or re.search(r"[.,]", found["second"]))  # 12:30 may be hours or minutes
    return bool((found := DURATION.fullmatch(cell)) and found[2].casefold() in SECOND_UNITS)


def seconds(where: object, column: "pd.Series[str]") -> tuple[Floats, list[str], str]:
    """Seconds since the first of a column of times, what was found out, and the first in ISO 8601.

    An empty cell is NaN; the first is "" where its day is not told.

    Raises
    ------
    FreerockError
        A cell that is no time, or another than the first; a day that no month has; days that may be months.
    """
    text = column.str.strip()
    if DURATION.fullmatch(text.dropna().iloc[0]):
        parts = text.str.extract(rf"^(?:{DURATION.pattern})$", flags=DURATION.flags)
        sizes = parts[1].str.casefold().map(SECOND_UNITS)
        _refuse_others(where, text, sizes)
        return (parts[0].str.replace(",", ".").astype(float) * sizes).to_numpy(float), [], ""
    parts = text.str.extract(rf"^(?:{STAMP.pattern})$", flags=STAMP.flags)
    for part in ("minute", "day", "hour", "half", "zone"):
        if part == "minute" or parts[part].notna().any():
            _refuse_others(where, text, parts[part])
    hour = parts["hour"].astype(float).fillna(0.0)
    if parts["half"].notna().any():
        _refuse_others(where, text, hour.where(hour.between(1, 12)))
        hour = hour % 12 + 12 * parts["half"].str.lower().eq("p")
    second = parts["second"].str.replace(r"[,:]", ".", regex=True)
    since = pd.to_timedelta("00:" + parts["minute"] + ":" + second) + pd.to_timedelta(hour, unit="h")
    first, told, start = since.first_valid_index(), list[str](), ""
    if parts["day"].notna().any():
        dates, told = _dates(where, list(parts["day"].dropna().unique()))
        origin = min(dates.values())
        since += parts["day"].map({text: day - origin for text, day in dates.items()})
        start = (pd.Timestamp(origin) + since[first]).isoformat() if origin > date.min else ""
    zones = parts["zone"].dropna().unique()
    if zones.size:
        start += re.sub("(?i)utc|gmt", "Z", parts["zone"][first].strip())
        since -= parts["zone"].map({zone: _offset(zone) for zone in zones})
    found: Floats = ((since - since[first]) / pd.Timedelta(1, "s")).to_numpy(float)
    found, notes = (found, []) if zones.size else unwrapped(found)
    return found, [*told, *notes], start


def unwrapped(time_s: Floats) -> tuple[Floats, list[str]]:
    """Times whose clock begins again at midnight or the full hour, or is set by an hour, made to run on."""
    steps = np.diff(time_s)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    notes = []
    for jump in CLOCK_JUMPS_S:
        at = np.flatnonzero(np.abs(steps - jump) <= 3 * usual)
        if at.size == 1 and usual <= abs(jump) / 100:
            time_s = time_s - jump * (np.arange(time_s.size) > at[0])
            steps = np.diff(time_s)
            notes.append(f"the clock jumps by {jump:+g} s after sample {at[0]}, and runs on here")
    return (np.round(time_s, 9) if notes else time_s), notes


def _refuse_others(where: object, text: "pd.Series[str]", found: "pd.Series[Any]") -> None:
    """Refuse the first cell in which a part that the first one has is not found."""
    other, alike = text[text.notna() & found.isna()], text[found.notna()]
    if other.size:
        cell = other.iloc[0][:40]
        like = alike.size and is_clock(cell)
        written = f"is written otherwise than {alike.iloc[0]!r}" if like else "is no time"
        raise FreerockError(where, f"{cell!r} in row {other.index[0]} {written}", EXPORT)


def _offset(zone: str) -> timedelta:
    """What a zone is ahead of UTC."""
    digits = re.sub(r"\D", "", zone).ljust(4, "0")
    ahead = timedelta(hours=int(digits[:2]), minutes=int(digits[2:4]))
    return -ahead if "-" in zone else ahead


def _dates(where: object, days: Sequence[str]) -> tuple[dict[str, date], list[str]]:
    """Dates of the days of a column, and a note on the order of their numbers.

    Of the orders in use it is that in which the recording is shortest.
    """
    found = {order: [_date(day, order) for day in days] for order in ORDERS}
    spans = {order: max(dates) - min(dates) for order, dates in found.items() if NO_DATE not in dates}
    fits = [order for order, span in spans.items() if span == min(spans.values())]
    if not fits:
        raise FreerockError(where, f"{days[0]} to {days[-1]} are no dates in one order", EXPORT)
    if any(found[order] != found[fits[0]] for order in fits):
        if len(days) == 1:
            return {days[0]: date.min}, []
        what = f"the dates {days[0]} and {days[-1]} may begin with the day or the month"
        raise FreerockError(where, what, EXPORT)
    told = [f"dates are read as {ORDERS[fits[0]]}"] if fits[0] != "ymd" else []
    return dict(zip(days, found[fits[0]], strict=True)), told


def _date(text: str, order: str) -> date:
    """A date, NO_DATE where there is no such day; years of two digits are of this century."""
    parts = re.findall(r"\d+|[^\W\d]+", text.casefold())
    if re.fullmatch(PASSED, text):
        return date.min + timedelta(days=int(parts[0]))
    numbers = [int(part) if part.isdecimal() else MONTHS.get(part[:3], 0) for part in parts]
    named = re.search(r"[^\W\d]", text)
    if named:
        order = "dmy" if parts[0].isdecimal() else "mdy"
    of = dict(zip(order, numbers, strict=True))
    if (order == "ymd" and of["y"] < 100) or (order == "mdy" and "." in text and not named):
        return NO_DATE
    try:
        return date(of["y"] if of["y"] > 99 else 2000 + of["y"], of["m"], of["d"])
    except ValueError:
        return NO_DATE
