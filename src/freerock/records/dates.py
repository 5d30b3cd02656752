"""Dates and clock times as loggers write them: ISO 8601, DIN (22.11.2026) and with slashes (11/22/2026)."""

import re
from collections.abc import Collection, Iterable, Sequence
from datetime import date, timedelta

import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError

ISO = r"\d{4}([-/])\d\d\1\d\d"
DAYS = r"\d\d?\.\d\d?\.(?:\d{4}|\d\d)|\d\d?/\d\d?/\d{4}"  # of another order than year, month, day
TIME = r"\d\d?:[0-5]\d:[0-5]\d(?:[.,]\d+)?"
DATE_PATTERN = re.compile(rf"{ISO}|{DAYS}", re.ASCII)
CLOCK = re.compile(
    rf"(?:(?:{DATE_PATTERN.pattern})(?:,? |T))?{TIME}(?:Z|[ \N{{NO-BREAK SPACE}}\u202f]?[AP]M)?",
    re.ASCII | re.IGNORECASE,
)
PARTS = re.compile(
    rf"^(?:({DAYS})(?:,? |T))?({TIME})(?:Z|[ \N{{NO-BREAK SPACE}}\u202f]?([AP]M))?$", re.ASCII | re.IGNORECASE
)
ORDERS = {"dmy": "day, month, year", "mdy": "month, day, year"}
EXPORT = "export the dates as 2026-11-22"


def seconds(where: object, column: "pd.Series[str]") -> Floats:
    """Seconds since the first of a column of dates and times; NaN for an empty cell.

    Raises
    ------
    FreerockError
        A day that no month has, an hour that no half of a day has, days that may be months.
    """
    text = column.str.strip()
    first = text.dropna().iloc[0]
    if re.match(ISO, first, re.ASCII):
        if first[-1] in "Mm":
            what = f"{first!r} has a clock of 12 hours after a date that begins with the year"
            raise FreerockError(where, what, "export the times with 24 hours")
        iso = text.str.replace("/", "-").str.replace(", ", "T").str.replace(",", ".")
        stamps = pd.to_datetime(iso, format="ISO8601")
    else:
        stamps = _since_midnight(where, text)
    since: Floats = ((stamps - stamps.dropna().iloc[0]) / pd.Timedelta(1, "s")).to_numpy()
    return since


def start(stamps: Iterable[str]) -> tuple[str, str]:
    """The first of some dates with times in ISO 8601, and in words what was found out; "" where not told."""
    stamps = [stamp for stamp in stamps if DATE_PATTERN.match(stamp)]
    if not stamps:
        return "", ""
    first, told = stamps[0], ""
    if re.match(ISO, first, re.ASCII):
        day: object = first[:10].replace("/", "-")
        found = PARTS.match(first[10:].lstrip(", Tt"))
    else:
        days = list(dict.fromkeys(match[0] for stamp in stamps if (match := re.match(DAYS, stamp, re.ASCII))))
        order = _order(days)
        if not order:
            return "", f"the date {days[0]} may begin with the day or the month and is left out"
        day, found, told = _day(days[0], order), PARTS.match(first), f"dates are read as {ORDERS[order]}"
    if not found or not day:
        return "", ""
    hour, _, rest = found[2].replace(",", ".").partition(":")
    hours = int(hour) % 12 + 12 * (found[3].upper() == "PM") if found[3] else int(hour)
    return f"{day}T{hours:02}:{rest}{'Z' * first.endswith('Z')}", told


def _since_midnight(where: object, text: "pd.Series[str]") -> "pd.Series[pd.Timedelta]":
    """Times since the first midnight of stamps without dates, or whose dates don't begin with the year."""
    parts = text.str.extract(PARTS)
    days, times, halves = (parts[i] for i in range(3))
    other = text[text.notna() & times.isna()]
    if other.size:
        if not all(map(CLOCK.fullmatch, other)):
            raise ValueError  # its line is told by the reader
        what = f"{other.iloc[0]!r} is written otherwise than {text.dropna().iloc[0]!r}"
        raise FreerockError(where, what, EXPORT)
    since = pd.to_timedelta(times.str.replace(",", "."))
    if halves.notna().any():
        hours = since.dt.total_seconds() // 3600
        wrong = text[times.notna() & (halves.isna() | ~hours.between(1, 12))]
        if wrong.size:
            what = f"{wrong.iloc[0][:40]!r} is no time of a clock of 12 hours"
            raise FreerockError(where, what, "export the times with 24 hours")
        shift = 12 * halves.str.upper().eq("PM") - 12 * hours.eq(12)
        since += pd.to_timedelta(shift, unit="h")
    if days.notna().any():
        since += days.map(_midnights(where, list(days.dropna().unique())))
    return since


def _midnights(where: object, days: Sequence[str]) -> dict[str, timedelta]:
    """Midnight of each day since that of the first."""
    if len(days) == 1 and not _order(days):
        return {days[0]: timedelta(0)}
    order = _order(days)
    if not order:
        what = f"the dates {days[0]} and {days[-1]} may begin with the day or the month"
        raise FreerockError(where, what, EXPORT)
    found = {text: _day(text, order) for text in days}
    known = [day for day in found.values() if day]
    if len(known) < len(days):
        text = next(text for text, day in found.items() if not day)
        raise FreerockError(where, f"{text} is no date of {ORDERS[order]}", EXPORT)
    return {text: day - known[0] for text, day in found.items() if day}


def _order(days: Collection[str]) -> str:
    """Order of the numbers in dates, a key of ORDERS; "" where the dates don't tell it.

    With slashes both orders are in use. A number above 12 is no month; of two dates in one month, which may
    be days of one recording, the number that differs is the day.
    """
    if any("." in day for day in days):
        return "dmy" if all("." in day for day in days) else ""
    first, second, _ = ({*numbers} for numbers in zip(*map(_numbers, days), strict=True))
    if max(first) > 12 or (len(second) == 1 < len(first)):
        return "dmy"
    return "mdy" if max(second) > 12 or (len(first) == 1 < len(second)) else ""


def _numbers(day: str) -> list[int]:
    return [int(number) for number in re.split("[./]", day)]


def _day(text: str, order: str) -> date | None:
    """A date; None where there is no such day. Years of two digits are of this century."""
    first, second, year = _numbers(text)
    day, month = (first, second) if order == "dmy" else (second, first)
    try:
        return date(year if year > 99 else 2000 + year, month, day)
    except ValueError:
        return None
