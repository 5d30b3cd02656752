"""The keys of `plan`, with their defaults."""

from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from freerock import bounds
from freerock.config.values import (
    Candidate,
    Invalid,
    Name,
    Number,
    OneOrMore,
    Positive,
    Section,
    Whole,
    check_names,
    check_parameters,
    key,
)
from freerock.models.laws import CANDIDATES, MODELS


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
    """Tests for which `freerock plan` predicts standard errors and rivals."""

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
    model_error: Number = key(
        "ε_θ of the right law, as a fraction; nearer rivals cannot be rejected", 0.0, ge=0, lt=1
    )
    n_runs: Annotated[tuple[Annotated[Whole, Field(gt=0)], ...], OneOrMore] = key(
        "the numbers of runs of each block, one or more", (1, 2, 3, 5, 10, 20)
    )
    spread_fraction: dict[Name, dict[str, Annotated[Number, Field(ge=0, lt=1)]]] = key(
        "foundation: parameter: spread between runs over their mean, as tau/mean in tables/populations.csv; "
        "by default 0",
        {},
    )

    @field_validator("durations_s")
    @classmethod
    def _in_memory(cls, durations: Any, info: ValidationInfo) -> Any:
        n = max(durations, default=0) * max(info.data.get("sampling_rates_hz", (0,)))
        if n > bounds.RUN_SAMPLES:
            raise Invalid(f"{n:.3g} samples are too many", f"plan for {bounds.RUN_SAMPLES} at most")
        return durations

    @field_validator("expected")
    @classmethod
    def _complete(cls, expected: Any) -> Any:
        for foundation, models in expected.items():
            for model, parameters in models.items():
                check_parameters(model, parameters, f" on {foundation}", CANDIDATES[model].width)
        return expected

    @field_validator("spread_fraction")
    @classmethod
    def _of_parameters(cls, spread: Any) -> Any:
        every = {name for parameters in MODELS.values() for name in parameters}
        for parameters in spread.values():
            check_names(parameters, sorted(every), "a parameter of a law")
        return spread
