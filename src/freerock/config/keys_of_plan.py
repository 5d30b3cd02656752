"""The keys of `plan`, with their defaults."""

from typing import Annotated, Any, Self

from pydantic import field_validator, model_validator

from freerock.config.values import (
    Candidate,
    Invalid,
    Name,
    OneOrMore,
    Positive,
    Section,
    check_parameters,
    key,
)
from freerock.models.laws import CANDIDATES


class SensorSection(Section):
    """A planned sensor: its white noise in volts, metres or degrees, and its range."""

    noise_v: Positive | None = key("the standard deviation of its noise in volts", None)
    noise_m: Positive | None = key("the standard deviation of its noise in metres", None)
    noise_deg: Positive | None = key("the standard deviation of the noise of θ itself in degrees", None)
    range_m: Positive | None = key(
        "its measuring range in metres; by default as for the record's laser", None
    )

    @model_validator(mode="after")
    def _one_noise(self) -> Self:
        given = [name for name in ("noise_v", "noise_m", "noise_deg") if getattr(self, name) is not None]
        if len(given) != 1:
            raise Invalid(
                f"has {' and '.join(given) or 'no noise'}", "give one of noise_v, noise_m, noise_deg"
            )
        return self


class PlanSection(Section):
    """Tests for which `freerock plan` predicts how well one run tells each parameter."""

    expected: dict[Name, dict[Candidate, dict[str, Positive]]] = key(
        "foundation: model: parameter: expected value (SI). Models …_width also need width_fraction, the "
        "contact width over the width of the block",
        min_length=1,
    )
    sensors: dict[Name, SensorSection] = key("one or more sensors, each by its name", min_length=1)
    sampling_rates_hz: Annotated[tuple[Positive, ...], OneOrMore] = key(
        "the sampling rates in hertz, one or more", (2000.0,)
    )
    durations_s: Annotated[tuple[Positive, ...], OneOrMore] = key(
        "the durations of a run in seconds, one or more", (8.0,)
    )
    release_angles_deg: dict[Name, tuple[Positive, ...]] = key(
        "block: list of release angles in degrees; by default release_angle_deg of the block", {}
    )

    @field_validator("expected")
    @classmethod
    def _complete(cls, expected: Any) -> Any:
        for foundation, models in expected.items():
            for model, parameters in models.items():
                check_parameters(model, parameters, f" on {foundation}", CANDIDATES[model].width)
        return expected
