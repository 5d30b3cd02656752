"""Dates, times of day and durations as loggers write them, as seconds since the first."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import date, timedelta

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError

_MONTHS = "jan feb mar|mär|mrz apr may|mai jun jul aug sep oct|okt nov dec|dez"
MONTHS = {name: n for n, names in enumerate(_MONTHS.split(), start=1) for name in names.split("|")}
_MONTH = rf"(?:{'|'.join(MONTHS)})[a-zä]*\.?"
ISO = r"\d{4}-\d\d-\d\d|\d{4}/\d\d/\d\d|\d{4}\.\d\d\.\d\d"
DAYS = r"\d\d?\.\d\d?\.(?:\d{4}|\d\d)|\d\d?/\d\d?/(?:\d{4}|\d\d)|\d\d?-\d\d?-\d{4}"  # day or month first
NAMED = rf"\d\d?\.?[-/ ]{_MONTH}[-/ ]\d{{4}}|{_MONTH}[ -]\d\d?,?[ -]\d{{4}}"  # 14-Sep-2024, Sep 14, 2024
WEEKDAY = r"(?:(?:mon|tue|wed|thu|fri|sat|sun|mo|di|mi|do|fr|sa|so)[a-z]*\.?,? )?"
_UNITS = {
    1.0: "s sec secs second seconds sek sekunde sekunden second(s)",
    1e-3: "ms msec msek millisecond milliseconds millisekunden",
    1e-6: "us µs μs usec µsec μsec microsecond microseconds mikrosekunden",
    1e-9: "ns nsec nanosecond nanoseconds nanosekunden",
    60.0: "min mins minute minutes minuten",
    3600.0: "h hr hrs hour hours std stunden",
    86400.0: "d day days tage",
}
SECOND_UNITS = {unit: size for size, units in _UNITS.items() for unit in units.split()}
_FLAGS = re.ASCII | re.IGNORECASE
_OF_DAY = r"(?:(?P<hour>\d{1,4}):)?(?P<minute>[0-5]?\d):(?P<second>[0-5]?\d(?:[.,:]\d+)?)"
_ZONE = r" ?(?:Z|UTC|GMT|[-+]\d\d:?\d\d|[-+]\d\d)"
STAMP = re.compile(
    rf"{WEEKDAY}(?:(?P<day>{ISO}|{DAYS}|{NAMED})(?:,? +|T|,))?{_OF_DAY}"
    rf"(?:[ \N{{NO-BREAK SPACE}}\u202f]?(?P<half>[ap])\.?m\.?)?(?P<zone>{_ZONE})?",
    _FLAGS,
)
DATE = re.compile(rf"{WEEKDAY}(?:{ISO}|{DAYS}|{NAMED})", _FLAGS)
DURATION = re.compile(r"([-+]?[\d.,]+(?:e[-+]?\d+)?) ?([a-zµμ]+(?:\(s\))?)", re.IGNORECASE)
TIMEDELTA = re.compile(r"(\d+) days? \+?(\d\d?:\d\d:\d\d(?:\.\d+)?)", _FLAGS)
ORDERS = {"dmy": "day, month, year", "mdy": "month, day, year"}
EXPORT = "export the times as 2026-11-22T09:30:00.125, or as seconds"
DAY_S, HOUR_S = 86400.0, 3600.0


def is_date(cell: str) -> bool:
    """Whether a cell is a date without a time."""
    return bool(DATE.fullmatch(cell))


def is_clock(cell: str) -> bool:
    """Whether a cell is a time of day, with a date or without, or a duration with its unit."""
    if found := STAMP.fullmatch(cell):
        return bool(found["hour"] or re.search(r"[.,]", found["second"]))  # 12:30 may be hours or minutes
    return bool(TIMEDELTA.fullmatch(cell)) or bool(
        (found := DURATION.fullmatch(cell)) and found[2].casefold() in SECOND_UNITS
    )


def seconds(where: object, column: "pd.Series[str]") -> tuple[Floats, list[str]]:
    """Seconds since the first of a column of times, NaN for an empty cell, and what was found out.

    Raises
    ------
    FreerockError
        A cell that is no time, or another than the first; a day that no month has; days that may be months.
    """
    text = column.str.strip()
    known = text.dropna()
    if STAMP.fullmatch(first := known.iloc[0]):
        return _of_stamps(where, text, known)
    pattern = TIMEDELTA if TIMEDELTA.fullmatch(first) else DURATION
    parts = text.str.extract(rf"^(?:{pattern.pattern})$", flags=pattern.flags)
    _refuse_others(where, text, parts[0])
    if pattern is TIMEDELTA:
        since = parts[0].astype(float) * DAY_S + pd.to_timedelta(parts[1]).dt.total_seconds()
    else:
        units = parts[1].str.casefold()
        unknown = known[~units[known.index].isin([*SECOND_UNITS])]
        if unknown.size:
            raise FreerockError(where, f"{unknown.iloc[0]!r} is no time", EXPORT)
        since = parts[0].str.replace(",", ".").astype(float) * units.map(SECOND_UNITS).astype(float)
    return since.to_numpy(float), []


def start(stamps: Iterable[str]) -> str:
    """The first of some dates with times in ISO 8601; "" where its day is not told."""
    found = [match for stamp in stamps if (match := STAMP.fullmatch(stamp.strip())) and match["day"]]
    days = list(dict.fromkeys(match["day"] for match in found))
    if not days or not (order := _order(days)) or not (day := _day(days[0], order)):
        return ""
    part = found[0].groupdict("")
    hour = int(part["hour"] or 0)
    hour = hour % 12 + 12 * (part["half"] in "pP") if part["half"] else hour
    zone = re.sub("(?i)utc|gmt", "Z", part["zone"].strip())
    return f"{day}T{hour:02}:{part['minute']}:{part['second'].replace(',', '.')}{zone}"


def unwrapped(time_s: Floats) -> tuple[Floats, list[str]]:
    """Times whose clock begins again at midnight or the full hour, or is set by an hour, made to run on."""
    steps = np.diff(time_s)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    notes = []
    for period, told in ((DAY_S, "midnight"), (HOUR_S, "an hour")):
        for sign in (-1, 1):
            at = np.flatnonzero(np.abs(steps - sign * period) <= 3 * usual)
            if at.size != 1 or (sign > 0 and period == DAY_S) or usual > period / 100:
                continue
            time_s = time_s - sign * period * (np.arange(time_s.size) > at[0])
            steps = np.diff(time_s)
            moved = "passes midnight" if period == DAY_S else f"is set by {told}, or begins the next one,"
            notes.append(f"the clock {moved} after sample {at[0]}: {-sign * period:+g} s from there on")
    return (np.round(time_s, 9) if notes else time_s), notes


def _of_stamps(where: object, text: "pd.Series[str]", known: "pd.Series[str]") -> tuple[Floats, list[str]]:
    """Seconds since the first of times of day, with dates or without."""
    parts = text.str.extract(rf"^(?:{STAMP.pattern})$", flags=STAMP.flags)
    days, hours, minutes, rest, halves, zones = (parts[name] for name in STAMP.groupindex)
    _refuse_others(where, text, minutes)
    for part in (days, hours, halves, zones):
        odd = known[part[known.index].isna()]
        if 0 < odd.size < known.size:
            what = f"{odd.iloc[0]!r} is written otherwise than {known[part[known.index].notna()].iloc[0]!r}"
            raise FreerockError(where, what, EXPORT)
    hour = hours.astype(float).fillna(0.0)
    if halves.notna().any():
        wrong = text[halves.notna() & ~hour.between(1, 12)]
        if wrong.size:
            raise FreerockError(where, f"{wrong.iloc[0]!r} is no time of a clock of 12 hours", EXPORT)
        hour = hour % 12 + 12 * halves.str.lower().eq("p")
    rest = rest.str.replace(r"[,:]", ".", regex=True)
    since = pd.to_timedelta("00:" + minutes + ":" + rest) + pd.to_timedelta(hour, unit="h")
    told: list[str] = []
    if days.notna().any():
        midnights, order = _midnights(where, list(days.dropna().unique()))
        told = [f"dates are read as {ORDERS[order]}"] if order in ORDERS else []
        since += days.map(midnights)
    if zones.notna().any():
        since -= zones.map({zone: _offset(zone) for zone in zones.dropna().unique()})
    first = since.dropna().iloc[0]
    found: Floats = ((since - first) / pd.Timedelta(1, "s")).to_numpy(float)
    if zones.notna().any():
        return found, told
    found, notes = unwrapped(found)
    return found, [*told, *notes]


def _refuse_others(where: object, text: "pd.Series[str]", found: "pd.Series[str]") -> None:
    """Refuse the first cell that the pattern of the first one does not fit."""
    other = text[text.notna() & found.isna()]
    if other.size:
        what = f"row {int(other.index[0]) + 1} of the table: {other.iloc[0][:40]!r} is no time"
        if is_clock(other.iloc[0]):
            what = f"{other.iloc[0]!r} is written otherwise than {text.dropna().iloc[0]!r}"
        raise FreerockError(where, what, EXPORT)


def _offset(zone: str) -> timedelta:
    """What a zone is ahead of UTC."""
    digits = re.sub(r"\D", "", zone).ljust(4, "0")
    ahead = timedelta(hours=int(digits[:2]), minutes=int(digits[2:4]))
    return -ahead if "-" in zone else ahead


def _midnights(where: object, days: Sequence[str]) -> tuple[Mapping[str, timedelta], str]:
    """Midnight of each day since that of the first, and the order of the numbers in dates."""
    order = _order(days)
    if len(days) == 1 and not order:
        return {days[0]: timedelta(0)}, ""
    if not order:
        what = f"the dates {days[0]} and {days[-1]} may begin with the day or the month"
        raise FreerockError(where, what, EXPORT)
    found = {text: _day(text, order) for text in days}
    wrong = [text for text, day in found.items() if not day]
    if wrong:
        raise FreerockError(where, f"{wrong[0]} is no date of {ORDERS.get(order, 'any month')}", EXPORT)
    first = found[days[0]]
    return {text: day - first for text, day in found.items() if day and first}, order


def _order(days: Collection[str]) -> str:
    """Order of the numbers in dates: a key of ORDERS, "named" or "ymd"; "" where the dates don't tell it.

    With slashes both orders are in use. A number above 12 is no month; of two dates in one month, which may
    be days of one recording, the number that differs is the day.
    """
    if all(re.search("[a-z]", day, re.IGNORECASE) for day in days):
        return "named"
    if all(re.match(ISO, day) for day in days):
        return "ymd"
    if any("." in day for day in days):
        return "dmy" if all("." in day for day in days) else ""
    first, second, _ = ({*numbers} for numbers in zip(*map(_numbers, days), strict=True))
    if max(first) > 12 or (len(second) == 1 < len(first)):
        return "dmy"
    return "mdy" if max(second) > 12 or (len(first) == 1 < len(second)) else ""


def _numbers(day: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", day)]


def _day(text: str, order: str) -> date | None:
    """A date; None where there is no such day. Years of two digits are of this century."""
    numbers = _numbers(text)
    if order == "named":
        name = re.search("[a-zä]{3}", text.casefold())
        day, year = numbers
        month = MONTHS[name[0]] if name else 0
    elif order == "ymd":
        year, month, day = numbers
    else:
        first, second, year = numbers
        day, month = (first, second) if order == "dmy" else (second, first)
    try:
        return date(year if year > 99 else 2000 + year, month, day)
    except ValueError:
        return None
