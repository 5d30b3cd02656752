"""What a cell of a table says: a number, a mark of a missing sample, a time, a date, or text."""

import re
from math import inf, nan

from freerock.records.times import is_clock, is_date

NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE | re.ASCII)
THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:([.,'’ \N{NO-BREAK SPACE}\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d+)?")
_UNDER = (
    "-ovl -over -overflow -overload -inf -infinity -1.#inf -1.#inf00 -∞ underflow underrange unterlauf under"
)
_OVER = """
ovl ovld ovrld ovr over overflow overload overrange over-range over_range ol o.l o.l. oor out_of_range inf
infinity 1.#inf 1.#inf00 1.#j #inf ∞ überlauf ueberlauf übersteuert übersteuerung überbereich sat saturated
clip clipped
"""
_MISSING = """
nan 1.#qnan 1.#ind 1.#nan 1.#snan nan(ind) nan(snan) #nv #n/a #n/v #na n/a na n.a. nv n.v. n/v <na> nat null
none nil #num! #zahl! #div/0! #value! #wert! #ref! #bezug! #name? - -- --- ---- ----- – — ? * ** *** .
invalid ungültig error fehler err missing fehlt no_data nodata no_signal no_value bad void n/d nd
"""
MARKS = {
    **dict.fromkeys(_MISSING.split(), nan),
    **dict.fromkeys([sign + word for word in _OVER.split() for sign in ("", "+")], inf),
    **dict.fromkeys(_UNDER.split(), -inf),
}
MARKS |= {mark.replace("_", " "): value for mark, value in MARKS.items()}
OVERLOAD = 9.9e37  # instruments write it, or a little more, for a sample out of range
SPECIAL = re.compile(r'[^\d\s.,;:eE+\-/"|]|(?<![\w.])[-+.]+(?![\w.])')  # no table without it holds a mark


def mark(cell: str) -> float | None:
    """inf or −inf for a mark of a sample out of range, NaN for one of a missing sample, else None."""
    plain = cell.strip().casefold()
    if plain[:1] in "+-" and plain[1:].startswith(("nan", "1.#qnan", "1.#ind")):
        plain = plain[1:]
    return nan if plain and not plain.strip("#") else MARKS.get(plain)


def kind_of(cell: str, decimal: str) -> str:
    """n for a number, m for a mark, c for a time, d for a date alone, t for other text, "" where empty."""
    if not cell:
        return ""
    if (decimal == "." or "." not in cell) and NUMBER.fullmatch(cell.replace(decimal, ".")):
        return "n"
    if NUMBER.fullmatch(cell):
        return "t"
    if mark(cell) is not None:
        return "m"
    if is_date(cell):
        return "d"
    return "c" if is_clock(cell) else "t"


def why_no_number(cell: str) -> str:
    """What is wrong with a cell that should hold a number, in words."""
    shown = repr(cell[:40])
    if THOUSANDS.fullmatch(cell):
        return f"{shown} has a mark between thousands, or another decimal mark than the file"
    return f"{shown} is not a number"


def with_plain_marks(text: str, delimiter: str) -> tuple[str, dict[str, int]]:
    """Lines of a table with nan, inf or -inf for its marks, and how often each mark occurs."""
    text = text.replace("\N{MINUS SIGN}", "-")
    found: dict[str, int] = {}
    edge = r"\s" if delimiter == " " else re.escape(delimiter)

    def plain(match: re.Match[str]) -> str:
        cell = match[0].strip().strip('"').strip()
        value = mark(cell)
        if value is None or cell in ("nan", "inf"):
            return match[0]
        found[cell] = found.get(cell, 0) + 1
        return f"{value}"

    # A cell without a digit, or that begins as Windows' 1.#INF does.
    cell = rf"(?:(?<=^)|(?<={edge}))(?:[^\d{edge}\n\r]+|[^\S\n\r]*[-+]?1\.#[^{edge}\n\r]*)(?={edge}|$)"
    return re.sub(cell, plain, text, flags=re.MULTILINE), found
