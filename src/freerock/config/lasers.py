"""Where a beam meets the block and what its output means: the keys of `lasers`."""

import math
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import ValidationInfo, field_validator

from freerock.config.input_uncertainties import LaserUncertainty, stated_only_with
from freerock.config.values import (
    Direction,
    Invalid,
    NotNegative,
    Number,
    Place,
    Positive,
    Section,
    Unit,
    check_inside,
    key,
)
from freerock.units import CHANNEL_UNITS


@dataclass(frozen=True, kw_only=True)
class LaserKeys:
    """The keys of a laser that have defaults; `rotation.sensor.Laser` describes them."""

    face: str = "left"
    sign: int = 1
    release_side: str = "positive"
    response_ms: float = 0.0
    volts_at_start: float = 0.0
    volts_at_end: float = 10.0
    valid_low_v: float = -0.1
    valid_high_v: float = 10.1
    error_level_v: float = 10.2
    error_tolerance_v: float = 0.01
    milliamps_at_start: float = 4.0
    milliamps_at_end: float = 20.0
    valid_low_ma: float = 3.84
    valid_high_ma: float = 20.16
    error_level_ma: float = 3.75
    error_tolerance_ma: float = 0.01


LASER = LaserKeys()


class LaserSection(Section):
    """A displacement sensor: where its beam meets the block, and its output."""

    units: Unit = key("the unit of output, displacement or rotation; by default as the file states it", "")
    beam: Literal["horizontal", "vertical"] | None = key(
        "horizontal (meets a side face) or vertical (meets the top); compulsory unless units are those of a "
        "rotation",
        None,
        validate_default=True,
    )
    position_m: Place | None = key(
        "the height of a horizontal beam, or distance of a vertical beam right of centre, in metres; "
        "compulsory with beam",
        None,
        validate_default=True,
    )
    range_m: Positive | None = key("the measuring range in metres", None)
    sensitivity_per_mm: Positive | None = key("the output per mm in V or mA, in place of range_m", None)
    calibration: str | None = key(
        "a CSV file in the raw folder, with output and distance headed as V,mm; in place of range_m", None
    )
    face: Literal["left", "right"] = key("the face met by a horizontal beam", LASER.face)
    sign: Direction = key("1 if the output grows with the distance, -1 if it falls", LASER.sign)
    release_side: Literal["positive", "negative"] = key(
        "the sign of the first swing after a rest; needed for a vertical beam between corners",
        LASER.release_side,
    )
    response_ms: Number = key(
        "the averaging time of the sensor in milliseconds; of a low pass, 318 over its bandwidth in Hz",
        LASER.response_ms,
        ge=0,
        le=100,
    )
    volts_at_start: Number = key("the volts at the start of the measuring range", LASER.volts_at_start)
    volts_at_end: Number = key("the volts at its end", LASER.volts_at_end, validate_default=True)
    valid_low_v: Number = key("the lowest valid output in volts", LASER.valid_low_v)
    valid_high_v: Number = key("the highest valid output in volts", LASER.valid_high_v)
    error_level_v: Number = key("the output in volts if the beam meets no target", LASER.error_level_v)
    error_tolerance_v: NotNegative = key("the tolerance of that level in volts", LASER.error_tolerance_v)
    milliamps_at_start: Number = key("as volts_at_start, in milliamperes", LASER.milliamps_at_start)
    milliamps_at_end: Number = key("as volts_at_end", LASER.milliamps_at_end, validate_default=True)
    valid_low_ma: Number = key("the lowest valid output in milliamperes", LASER.valid_low_ma)
    valid_high_ma: Number = key("the highest valid output in milliamperes", LASER.valid_high_ma)
    error_level_ma: Number = key("the milliamperes if the beam meets no target", LASER.error_level_ma)
    error_tolerance_ma: NotNegative = key("the tolerance of that level", LASER.error_tolerance_ma)
    uncertainty: LaserUncertainty = key("the standard uncertainties of its keys", LaserUncertainty())

    _of_what_is_given = stated_only_with("position_m", "remove it: the channel is the rotation")

    @field_validator("beam", "position_m")
    @classmethod
    def _beam_is_placed(cls, value: Any, info: ValidationInfo) -> Any:
        height = value if info.field_name == "position_m" and info.data.get("beam") == "horizontal" else None
        if height is not None and height <= 0:
            raise Invalid(f"{height:g} is not above the base", "give the height of the beam in metres")
        if "units" not in info.data:  # refused: whether there is a beam is not known
            return value
        units = info.data["units"]
        is_rotation = bool(units) and CHANNEL_UNITS[units][0] == "rotation"
        if is_rotation and value is not None:
            raise Invalid(f"a channel in {units} is the rotation itself", "remove it, or correct units")
        if value is None and not is_rotation:
            given = str(cls.model_fields[str(info.field_name)].description).partition(";")[0]
            remedy = f"give {given}, or declare units: deg where the channel is the rotation"
            raise Invalid("is missing", remedy)
        return value

    @field_validator("calibration", "sensitivity_per_mm")
    @classmethod
    def _scaled_once(cls, value: Any, info: ValidationInfo) -> Any:
        if info.field_name == "calibration":
            value = check_inside(value) if value else None
        given = [way for way in ("range_m", "sensitivity_per_mm") if info.data.get(way) is not None]
        if value is not None and given:
            raise Invalid(f"{given[0]} scales the output already", "keep one of the two")
        return value

    @field_validator("volts_at_end", "milliamps_at_end")
    @classmethod
    def _rising(cls, end: Any, info: ValidationInfo) -> Any:
        start = str(info.field_name).replace("end", "start")
        if end <= info.data.get(start, -math.inf):
            raise Invalid(f"{end:g} is not above {start}", "swap the two and set sign: -1")
        return end
