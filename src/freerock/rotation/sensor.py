"""The sensor: where its beam meets the block, what its output means, and the time that it takes."""

import csv
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.config.lasers import LaserKeys, LaserSection
from freerock.config.mistakes import refuse, validate
from freerock.errors import FreerockError, of_kind
from freerock.rotation.flags import Limits
from freerock.units import CHANNEL_UNITS, in_base_units, understood


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
        with open(path, encoding="utf-8-sig") as file:
            head, *rows = [row for row in csv.reader(file) if any(map(str.strip, row))] or [[]]
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise FreerockError(path, f"cannot be read ({why})", "put the calibration table there") from None
    units = [CHANNEL_UNITS.get(str(understood(cell)), ("", 1.0)) for cell in head]
    kinds = [quantity for quantity, _ in units]
    if len(kinds) != 2 or kinds[0] not in ("voltage", "current") or kinds[1] != "displacement":
        what = f"the first line is {','.join(head)!r}"
        raise FreerockError(path, what, "write the units of the two columns there, as V,mm")
    try:
        table = np.array([(float(output), float(distance)) for output, distance in rows])
    except ValueError as error:
        raise FreerockError(path, str(error), "write two numbers with a decimal point per line") from None
    steps = np.diff(table, axis=0).T if len(table) > 1 else np.zeros((2, 1))
    if not (np.isfinite(steps).all() and all(np.all(way > 0) or np.all(way < 0) for way in steps)):
        remedy = "give two lines or more, in order of the output"
        raise FreerockError(path, "the columns don't rise or fall throughout", remedy)
    output, distance = (table[np.argsort(table[:, 0])] * [size for _, size in units]).T.tolist()
    return Calibration(kinds[0], tuple(output), tuple(distance))


@dataclass(frozen=True)
class Laser(LaserKeys):
    """A displacement sensor, such as a triangulation laser, and where its beam meets the block.

    Parameters
    ----------
    beam : str
        "horizontal" (meets a side face) or "vertical" (meets the top from above); None only where the channel
        holds the rotation itself.
    position_m : float
        Height Y of a horizontal beam above the base plane, or distance X of a vertical beam to the right of
        the block's centre line at rest [m].
    range_m : float
        Measuring range between the outputs at its start and at its end [m].
    face : str
        "left" or "right": face met by a horizontal beam.
    sign : int
        +1 when the output grows with the distance from the sensor (a rotation: clockwise), -1 when it falls.
    release_side : str
        "positive" (clockwise) or "negative": side of the first swing after every rest; used only where the
        reading has no sign, for a vertical beam between the corners.
    response_ms : float
        Time over which the sensor averages [ms]; 0 where it takes none.
    units : str
        Unit of the channel, one of `units.CHANNEL_UNITS`; "" as the file states it.
    sensitivity_per_mm : float
        Output per millimetre [V/mm or mA/mm], in place of `range_m`; the output at the start of the range is
        its offset.
    calibration : Calibration
        Table of output and distance, in place of `range_m`.
    volts_at_start, volts_at_end, milliamps_at_start, milliamps_at_end : float
        Output at the start and at the end of the measuring range [V, mA].
    valid_low_v, valid_high_v, valid_low_ma, valid_high_ma : float
        Limits of valid output [V, mA].
    error_level_v, error_tolerance_v, error_level_ma, error_tolerance_ma : float
        Output that means "no target" and its tolerance [V, mA].

    Raises
    ------
    FreerockError
        A value that no sensor has.
    """

    beam: str | None = None
    position_m: float | None = None
    range_m: float | None = None
    units: str = ""
    sensitivity_per_mm: float | None = None
    calibration: Calibration | None = None

    def __post_init__(self) -> None:
        mistakes = list[FreerockError]()
        given = vars(self) | {"calibration": self.calibration and "given"}
        validate(LaserSection, given, lambda loc: ".".join(("laser", *map(str, loc))), mistakes)
        refuse(mistakes)

    def moved(self, **fields: Any) -> "Laser":
        """The same with other fields, as a fit moves them: these are not checked."""
        other = copy(self)
        vars(other).update(fields)
        return other

    @property
    def position(self) -> float:
        """`position_m`, 0 where the channel holds the rotation itself [m]."""
        return self.position_m or 0.0

    def limits(self, quantity: str) -> Limits | None:
        """Valid output and error level of a quantity; None where it has none."""
        suffix = {"voltage": "v", "current": "ma"}.get(quantity)
        names = ("valid_low", "valid_high", "error_level", "error_tolerance")
        return Limits(*(getattr(self, f"{name}_{suffix}") for name in names)) if suffix else None

    def metres_per(self, quantity: str = "voltage") -> float:
        """Distance from the sensor per volt or milliampere, with its sign [m/V or m/mA], without a table.

        Raises
        ------
        FreerockError
            Neither a range nor a sensitivity.
        """
        if self.sensitivity_per_mm is not None:
            return self.sign * 1e-3 / self.sensitivity_per_mm
        if self.range_m is None:
            raise FreerockError("laser", f"a {quantity} has no scale", SCALE_IT)
        name = "volts" if quantity == "voltage" else "milliamps"
        span: float = getattr(self, f"{name}_at_end") - getattr(self, f"{name}_at_start")
        return self.sign * self.range_m / span


def laser_of(section: Mapping[str, Any], raw: str | Path) -> Laser:
    """The laser of a section of the configuration, with its calibration table in the raw folder, if any."""
    table = section["calibration"] and read_calibration(Path(raw, section["calibration"]))
    return Laser(**{**section, "calibration": table})


SEVERAL_LEVELS = 0.2  # V: so much apart, and samples are not of one level with its noise
SCALES = ("range_m", "sensitivity_per_mm", "calibration")
SCALE_IT = f"give one of {', '.join(SCALES)} to the laser, or name another"


def looks_like_current(volts: Floats, laser: Laser) -> bool:
    """Whether samples said to be volts are milliamperes, which are within other limits.

    More than one in a hundred is beyond the volts of the sensor, none beyond its milliamperes, and those
    beyond the volts are more than one level, which a sensor may have that sees no target.
    """
    beyond = volts[volts > laser.valid_high_v]
    beyond = beyond[np.abs(beyond - laser.error_level_v) > laser.error_tolerance_v]
    if beyond.size <= 0.01 * volts.size:
        return False
    low, high = float(np.nanmin(volts)), float(np.nanmax(volts))
    within = laser.valid_low_ma <= low and high <= laser.valid_high_ma
    return within and float(np.ptp(beyond)) > SEVERAL_LEVELS


def recorded_of(values: ArrayLike, laser: Laser | LaserSection, stated: str) -> tuple[Floats, str]:
    """Values of a laser's channel in the unit used inside, and their quantity; `stated` is the file's unit.

    Raises
    ------
    FreerockError
        As of `in_base_units`; an output that the laser does not scale, or a scale and another quantity.
    """
    recorded, quantity = in_base_units(values, laser.units, stated)
    scale = next((name for name in SCALES if getattr(laser, name) is not None), "")
    of_output = quantity in ("voltage", "current")
    if of_output and not scale:
        raise FreerockError("laser", f"a {quantity} has no scale", SCALE_IT)
    if scale and not (of_output or laser.units):
        what = f"{scale} scales volts or milliamperes, and the file states {stated!r}"
        remedy = f"correct that unit, or name a laser without {scale}"
        raise FreerockError("lasers: units", what, remedy)
    return recorded, quantity


def distance_from_output(
    output: ArrayLike, laser: Laser, quantity: str = "voltage"
) -> tuple[Floats, Floats | float]:
    """Distance of the target from the start of the measuring range, and its slope.

    Parameters
    ----------
    output : array_like
        Output of the sensor [V or mA]; a displacement [m] or rotation [rad] is taken as it is.
    laser : Laser
    quantity : str
        Key of `quantity.BASE`.

    Returns
    -------
    distance : ndarray
        [m], or the rotation [rad]; counted against `laser.sign` where that is -1. NaN beyond a calibration
        table.
    slope : ndarray or float
        Its change per unit of output, never negative [m/V, m/mA or 1].

    Raises
    ------
    FreerockError
        A sensor without a scale, or a table of another quantity.
    """
    output = np.asarray(output, float)
    if quantity in ("displacement", "rotation"):
        return output, 1.0
    if laser.calibration is None:
        slope = abs(laser.metres_per(quantity))
        start = laser.volts_at_start if quantity == "voltage" else laser.milliamps_at_start
        return (output - start) * slope, slope
    table = laser.calibration
    if table.quantity != quantity:
        what = f"the calibration table is of a {table.quantity}, the channel of a {quantity}"
        raise FreerockError("laser.calibration", what, "give the table of this sensor")
    at, distance = np.array(table.output), np.array(table.distance_m)
    piece = np.clip(np.searchsorted(at, output) - 1, 0, at.size - 2)
    slopes = np.abs(np.diff(distance) / np.diff(at))[piece]
    return np.interp(output, at, distance, left=np.nan, right=np.nan), slopes


def lasers_of(given: Laser | Sequence[Laser]) -> tuple[Laser, ...]:
    """One laser or several; raises where it is anything else."""
    lasers = given if isinstance(given, Sequence) else [given]
    for each in lasers:
        of_kind("laser", each, Laser, "give freerock.Laser(...), or two of them")
    return tuple(lasers)
