"""The sensor: where its beam meets the block, and what its output means."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.config.laser_defaults import LaserKeys
from freerock.errors import FreerockError
from freerock.rotation.calibration import Calibration, read_calibration
from freerock.rotation.flags import Limits
from freerock.rotation.sensor_response import KINDS
from freerock.units import CHANNEL_UNITS


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
        Time over which the sensor averages, or time constant of its low pass [ms]; 0 where it takes none.
    response : str
        "average" (the mean over the time before) or "low_pass" (of the first order).
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
        for fault in self._faults():
            raise FreerockError(*fault)

    def _faults(self) -> Iterator[tuple[str, str, str]]:
        """Yield where a value is that no sensor has, what is wrong with it, and the remedy."""
        for key, choices in _CHOICES.items():
            if getattr(self, key) not in choices:
                known = ", ".join(str(choice) for choice in choices if choice not in ("", None))
                yield f"laser.{key}", f"{getattr(self, key)!r} is unknown", f"use one of {known}"
        if not self.response_ms >= 0:
            yield "laser.response_ms", f"{self.response_ms:g} ms", "give the time as a positive number, or 0"
        if self.is_rotation:
            return
        if not self.beam or self.position_m is None:
            yield "laser.beam", "no beam or no position_m", "say where the beam meets the block"
        if self.beam == "horizontal" and not self.position > 0:
            yield "laser.position_m", f"height {self.position_m} m", "give a height above 0"
        if self.range_m is not None and not self.range_m > 0:
            yield "laser.range_m", f"range {self.range_m} m", "give a range above 0"
        if self.sensitivity_per_mm is not None and not self.sensitivity_per_mm > 0:
            yield "laser.sensitivity_per_mm", f"{self.sensitivity_per_mm:g}", "give a value above 0"
        for name in ("volts", "milliamps"):
            if not getattr(self, f"{name}_at_end") > getattr(self, f"{name}_at_start"):
                remedy = "give the output at both ends; use sign: -1 to invert"
                yield f"laser.{name}_at_end", f"not above {name}_at_start", remedy
        ways = [way for way in SCALES if getattr(self, way) is not None]
        if len(ways) > 1:
            yield "laser", f"scaled twice, by {' and '.join(ways)}", "keep one"

    @property
    def position(self) -> float:
        """`position_m`, 0 where the channel holds the rotation itself [m]."""
        return self.position_m or 0.0

    @property
    def is_rotation(self) -> bool:
        """Whether the channel is declared to hold the rotation itself."""
        return self.units in CHANNEL_UNITS and CHANNEL_UNITS[self.units][0] == "rotation"

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
            remedy = f"give one of {', '.join(SCALES)}, or its units as m or deg"
            raise FreerockError("laser", f"a {quantity} has no scale", remedy)
        name = "volts" if quantity == "voltage" else "milliamps"
        span: float = getattr(self, f"{name}_at_end") - getattr(self, f"{name}_at_start")
        return self.sign * self.range_m / span


def laser_of(section: Mapping[str, Any], raw: str | Path) -> Laser:
    """The laser of a section of the configuration, with its calibration table in the raw folder, if any."""
    table = section["calibration"] and read_calibration(Path(raw, section["calibration"]))
    return Laser(**{**section, "calibration": table})


SEVERAL_LEVELS = 0.2  # V: so much apart, and samples are not of one level with its noise
SCALES = ("range_m", "sensitivity_per_mm", "calibration")
_CHOICES = {
    "beam": (None, "horizontal", "vertical"),
    "face": ("left", "right"),
    "sign": (1, -1),
    "release_side": ("positive", "negative"),
    "response": KINDS,
    "units": ("", *CHANNEL_UNITS),
}


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
