"""The calibration of a sensor as a table, read from a CSV file."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from freerock.errors import FreerockError
from freerock.files import regular
from freerock.units import CHANNEL_UNITS, understood


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


def read_calibration(path: str | Path) -> Calibration:
    """Read a calibration table: a CSV file whose first line holds the two units, as "V,mm".

    Raises
    ------
    FreerockError
        No such table, other units, fewer than two lines, or a column that is not monotonic.
    """
    try:
        with open(path, encoding="utf-8-sig", opener=regular) as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise FreerockError(path, f"cannot be read ({why})", "put the calibration table there") from None
    lines = csv.reader(text.splitlines())
    rows = [(lines.line_num, row) for row in lines if any(cell.strip() for cell in row)]
    head = rows.pop(0)[1] if rows else []
    units = [understood(cell) for cell in head]
    kinds = [CHANNEL_UNITS[unit][0] if unit else None for unit in units]
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
        remedy = "give two lines or more, in order of the output"
        raise FreerockError(path, "the columns don't rise or fall throughout", remedy)
    output, distance = (
        column * CHANNEL_UNITS[str(unit)][1] for column, unit in zip(table.T, units, strict=True)
    )
    order = np.argsort(output)
    return Calibration(kinds[0], tuple(output[order].tolist()), tuple(distance[order].tolist()))
