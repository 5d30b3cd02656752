"""What a channel holds: its quantity and unit, and the calibration of a sensor as a table."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.errors import FreerockError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

BASE = {"voltage": "V", "current": "mA", "displacement": "m", "rotation": "rad"}  # units used inside
UNITS = {  # what may be declared: its quantity, and its size in the unit used inside
    "V": ("voltage", 1.0),
    "mV": ("voltage", 1e-3),
    "kV": ("voltage", 1e3),
    "mA": ("current", 1.0),
    "A": ("current", 1e3),
    "m": ("displacement", 1.0),
    "cm": ("displacement", 1e-2),
    "mm": ("displacement", 1e-3),
    "um": ("displacement", 1e-6),
    "rad": ("rotation", 1.0),
    "mrad": ("rotation", 1e-3),
    "deg": ("rotation", math.pi / 180),
}
SPELLINGS = {  # what files write besides, in lower case
    "volt": "V",
    "volts": "V",
    "millivolt": "mV",
    "millivolts": "mV",
    "milliampere": "mA",
    "ampere": "A",
    "amperes": "A",
    "amps": "A",
    "kilovolt": "kV",
    "kilovolts": "kV",
    "metre": "m",
    "meter": "m",
    "centimetre": "cm",
    "centimeter": "cm",
    "centimeters": "cm",
    "millimetre": "mm",
    "millimeter": "mm",
    "millimeters": "mm",
    "µm": "um",
    "μm": "um",
    "radian": "rad",
    "radians": "rad",
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
}
SPELLINGS |= {unit.lower(): unit for unit in UNITS if unit.lower() not in ("mv", "ma")} | {"v": "V"}


@dataclass(frozen=True)
class Calibration:
    """A sensor's output and the distance it means, both increasing or one of them falling.

    Parameters
    ----------
    quantity : str
        "voltage" or "current".
    output : tuple of float
        Increasing [V or mA].
    distance_m : tuple of float
        Strictly monotonic [m].
    """

    quantity: str
    output: tuple[float, ...]
    distance_m: tuple[float, ...]


def understood(unit: str) -> str | None:
    """The name in `UNITS` of a unit as a file may write it; None for any other text.

    The case counts between m and M (milli, mega) only where a word would not settle it: "mV" and "mA" are
    taken as written, "MV" is refused.

    Examples
    --------
    >>> understood("Volts"), understood("µm"), understood("kg")
    ('V', 'um', None)
    """
    unit = unit.strip()
    return unit if unit in UNITS else SPELLINGS.get(unit.lower()) if unit not in ("MV", "MA") else None


def in_base_units(values: "ArrayLike", declared: str, stated: str) -> "tuple[NDArray[np.float64], str]":
    """Values of a channel in the unit used inside, and their quantity.

    Parameters
    ----------
    values : array_like
    declared : str
        Unit in the configuration, one of `UNITS`; "" when not declared.
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
    if declared and declared not in UNITS:
        raise FreerockError(where, f"{declared!r} is unknown", f"use one of {', '.join(UNITS)}")
    if declared and read and UNITS[declared] != UNITS[read]:
        what = f"{declared!r} is declared and the file states {stated!r}"
        raise FreerockError(where, what, "correct the one that is wrong, or name the channel that is meant")
    if not (declared or read):
        told = f"the channel's unit {stated!r} is not known" if stated else "the channel states no unit"
        raise FreerockError(where, told, f"declare it as units of the laser: {', '.join(UNITS)}")
    quantity, factor = UNITS[declared or str(read)]
    values = np.asarray(values, float)
    return (values if factor == 1 else values * factor), quantity


def read_calibration(path: str | Path) -> Calibration:
    """Read a calibration table: a CSV file whose first line holds the two units, as "V,mm".

    Raises
    ------
    FreerockError
        No such table, other units, fewer than two lines, or a column that is not monotonic.
    """
    import numpy as np

    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        told = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise FreerockError(path, f"cannot be read ({told})", "put the calibration table there") from None
    lines = csv.reader(text.splitlines())
    rows = [(lines.line_num, row) for row in lines if any(cell.strip() for cell in row)]
    head = rows.pop(0)[1] if rows else []
    units = [understood(cell) for cell in head]
    kinds = [UNITS[unit][0] if unit else None for unit in units]
    if len(kinds) != 2 or kinds[0] not in ("voltage", "current") or kinds[1] != "displacement":
        what = f"the first line is {','.join(head)!r}"
        raise FreerockError(path, what, "write the units of the two columns there, as V,mm")
    for number, row in rows:
        if len(row) != 2:
            what = f"line {number} holds {len(row)} value{'s' if len(row) > 1 else ''}"
            raise FreerockError(path, what, "write two numbers with a decimal point per line")
    try:
        table = np.array([[float(cell) for cell in row] for _, row in rows])
    except ValueError as error:
        raise FreerockError(path, str(error), "write two numbers with a decimal point per line") from None
    whole = table.ndim == 2 and table.shape[1] == 2 and np.isfinite(table).all()
    steps = np.diff(table, axis=0) if whole else np.empty((0, 2))
    if len(steps) < 1 or not all(np.all(way > 0) or np.all(way < 0) for way in steps.T):
        raise FreerockError(
            path,
            "the columns don't rise or fall throughout",
            "give two lines or more, in order of the output",
        )
    output, distance = (column * UNITS[str(unit)][1] for column, unit in zip(table.T, units, strict=True))
    order = np.argsort(output)
    return Calibration(kinds[0], tuple(output[order].tolist()), tuple(distance[order].tolist()))
