"""The keys of a laser that have defaults, for Python too."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class LaserKeys:
    """The keys of a laser that have defaults; `rotation.sensor.Laser` describes them."""

    face: str = "left"
    sign: int = 1
    release_side: str = "positive"
    response_ms: float = 0.0
    response: str = "average"
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
