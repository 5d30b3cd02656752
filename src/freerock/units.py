"""Quantity and unit of a channel."""

import math
from typing import TYPE_CHECKING

from freerock.errors import FreerockError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

BASE = {"voltage": "V", "current": "mA", "displacement": "m", "rotation": "rad"}  # units used inside
CHANNEL_UNITS = {  # what may be declared: its quantity, and its size in the unit used inside
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
SPELLED = {  # what files write besides, in lower case
    "V": ("volt", "volts"),
    "mV": ("millivolt", "millivolts"),
    "kV": ("kilovolt", "kilovolts"),
    "mA": ("milliampere",),
    "A": ("ampere", "amperes", "amps"),
    "m": ("metre", "meter"),
    "cm": ("centimetre", "centimeter", "centimeters"),
    "mm": ("millimetre", "millimeter", "millimeters"),
    "um": ("µm", "μm"),
    "rad": ("radian", "radians"),
    "deg": ("°", "degree", "degrees"),
}
SPELLINGS = {text: unit for unit, texts in SPELLED.items() for text in texts}
# What else files give, in lower case: no sensor of displacement or rotation gives it, or no unit above is it.
OTHER_UNITS = {
    "temperature": ("°c", "degc", "deg c", "celsius", "°f", "degf", "k", "kelvin"),
    "force": ("n", "mn", "kn", "dan", "kgf", "lbf", "nm"),
    "mass": ("kg",),
    "stress": ("pa", "hpa", "kpa", "mpa", "bar", "mbar", "psi", "n/mm²", "n/mm2"),
    "acceleration": ("g", "mg", "m/s²", "m/s2", "m/s^2", "mm/s²", "mm/s2", "mm/s^2"),
    "rate": ("m/s", "mm/s", "rad/s", "deg/s", "°/s", "1/s", "hz", "khz", "rpm"),
    "time": ("s", "ms", "us", "µs", "μs", "min", "h"),
    "strain": ("strain", "µm/m", "μm/m", "um/m", "µε", "με"),
    "share": ("%", "% rh", "%rh"),
    "length": ("in", "inch", "ft"),
}
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
        remedy = f"declare it as units of the laser: {', '.join(CHANNEL_UNITS)}"
        if stated:
            remedy = f"name another channel, or {remedy}"
        raise FreerockError(where, what, remedy)
    quantity, factor = CHANNEL_UNITS[declared or str(read)]
    return np.asarray(values, float) * factor, quantity
