"""Quantity and unit of a channel; `units.csv` has them: their size, and how files spell them."""

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.errors import FreerockError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

BASE = {"voltage": "V", "current": "mA", "displacement": "m", "rotation": "rad"}  # units used inside
with open(Path(__file__).with_suffix(".csv"), encoding="utf-8", newline="") as _file:
    _ROWS = [*csv.DictReader(_file)]
# What may be declared: its quantity, and its size in the unit used inside.
CHANNEL_UNITS = {row["unit"]: (row["quantity"], float(row["size"])) for row in _ROWS if row["unit"]}
# What else files give, in lower case: no sensor of displacement or rotation gives it, or no unit above is it.
OTHER_UNITS = {row["quantity"]: row["spelled"].split("|") for row in _ROWS if not row["unit"]}
SPELLINGS = {text: row["unit"] for row in _ROWS if row["unit"] for text in row["spelled"].split("|") if text}
SPELLINGS |= {unit.lower(): unit for unit in CHANNEL_UNITS if unit.lower() not in ("mv", "ma")} | {"v": "V"}


def understood(unit: str) -> str | None:
    """The name in `CHANNEL_UNITS` of a unit as a file may write it; None for any other text.

    The case counts between m and M (milli, mega) only where a word would not settle it: "mV" and "mA" are
    taken as written, "MV" is refused.

    Examples
    --------
    >>> understood("Volts"), understood("µm"), understood("kg")
    ('V', 'um', None)
    """
    unit = unit.strip()
    if unit in CHANNEL_UNITS:
        return unit
    return None if unit in ("MV", "MA") else SPELLINGS.get(unit.lower())


def quantity_of_other(unit: str) -> str:
    """What a unit of `OTHER_UNITS` measures; "" for any other text."""
    found = (quantity for quantity, units in OTHER_UNITS.items() if unit.strip().lower() in units)
    return next(found, "")


def in_base_units(values: "ArrayLike", declared: str, stated: str) -> "tuple[NDArray[np.float64], str]":
    """Values of a channel in the unit used inside, and their quantity.

    Parameters
    ----------
    values : array_like
    declared : str
        Unit in the configuration, one of `CHANNEL_UNITS`; "" when not declared.
    stated : str
        Unit in the file; "" when the file states none.

    Returns
    -------
    values : ndarray
        In the unit of `BASE`.
    quantity : str
        A key of `BASE`.

    Raises
    ------
    FreerockError
        No unit at all, one that is not known, or a declaration that contradicts the file.
    """
    import numpy as np

    read, where = understood(stated), "lasers: units"
    if declared and declared not in CHANNEL_UNITS:
        raise FreerockError(where, f"{declared!r} is unknown", f"use one of {', '.join(CHANNEL_UNITS)}")
    if declared and (quantity_of_other(stated) or (read and CHANNEL_UNITS[declared] != CHANNEL_UNITS[read])):
        what = f"{declared!r} is declared and the file states {stated!r}"
        raise FreerockError(where, what, "correct the one that is wrong, or name the channel that is meant")
    if not (declared or read):
        what = f"the channel's unit {stated!r} is not known" if stated else "the channel states no unit"
        remedy = "name another channel, or " * bool(stated)
        remedy += f"declare it as units of the laser: {', '.join(CHANNEL_UNITS)}"
        raise FreerockError(where, what, remedy)
    quantity, factor = CHANNEL_UNITS[declared or str(read)]
    return np.asarray(values, float) * factor, quantity
