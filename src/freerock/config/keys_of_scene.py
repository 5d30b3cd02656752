"""The keys of a scene to simulate, with their defaults, and the reading of its file."""

from pathlib import Path
from typing import Literal, Self

from pydantic import ValidationInfo, field_validator, model_validator

from freerock import bounds
from freerock.config.keys_of_blocks import BlockSection
from freerock.config.keys_of_lasers import LaserSection
from freerock.config.mistakes import refuse, validate
from freerock.config.values import (
    Debonding,
    Invalid,
    Kinematics,
    Model,
    Number,
    Positive,
    Section,
    Whole,
    check_parameters,
    key,
)
from freerock.config.yaml_lines import place, read_yaml

GROUND_COLUMNS = ("time_s", "x_m_s2", "z_m_s2")


class PulseSection(Section):
    """An analytic pulse of the ground."""

    shape: Literal["sine", "half_sine", "cosine"] = key("sine, half_sine or cosine", "sine")
    period_s: Positive = key("its period in seconds")
    x_m_s2: Number = key("the amplitude of the horizontal acceleration in m/s²", 0.0)
    z_m_s2: Number = key("the amplitude of the vertical acceleration, upward, in m/s²", 0.0)
    start_s: Number = key("when it starts in seconds", 0.0)
    cycles: Positive | None = key("its length in periods; by default as for its shape", None)


class GroundSection(Section):
    """The motion of the ground: a pulse, or the samples of a file."""

    pulse: PulseSection | None = key("an analytic pulse", None)
    file: str = key(
        f"a CSV file beside the scene with columns {', '.join(GROUND_COLUMNS)} (the last optional)",
        "",
        validate_default=True,
    )

    @field_validator("file")
    @classmethod
    def _one_of_the_two(cls, file: str, info: ValidationInfo) -> str:
        if file and info.data.get("pulse"):
            raise Invalid("has both a pulse and a file", "keep one of the two")
        if not file and info.data.get("pulse", ...) is None:
            raise Invalid("has neither a pulse nor a file", "give one of the two")
        return file


class VirtualLaser(LaserSection):
    """The laser of the record, and its noise."""

    noise_v: Positive = key("the standard deviation of its noise in volts", 0.002)
    seed: Whole = key("the seed of the noise, and of release angles and times", 0, ge=0)
    releases: Whole = key("the number of releases on the record", 3, ge=1, le=1000)

    @model_validator(mode="after")
    def _volts_and_a_range(self) -> Self:
        if self.units not in ("", "V") or not (self.range_m or self.sensitivity_per_mm):
            raise Invalid("the virtual laser has volts and a range", "give range_m, leave units out")
        return self


class Scene(Section):
    """What `freerock simulate` simulates."""

    block: BlockSection = key("the block")
    models: dict[Model, dict[str, Positive]] = key("model: parameter: value, in SI units", min_length=1)
    release_angle_deg: Number = key("the release angle in degrees, or 0", 0.0)
    duration_s: Positive = key("the simulated time in seconds", 10.0)
    sampling_rate_hz: Positive = key("samples per second", 1000.0)
    debonding: Debonding = key("as in a campaign's fits", "geometric")
    kinematics: Kinematics = key(
        "guided (the base centre is held, as in the paper) or pivoting (about the lower corner)", "guided"
    )
    ground: GroundSection | None = key("the motion of the ground; by default none", None)
    laser: VirtualLaser | None = key(
        "the laser of a record; by default θ(t) itself is written", None, validate_default=False
    )

    @field_validator("sampling_rate_hz")
    @classmethod
    def _in_memory(cls, rate: float, info: ValidationInfo) -> float:
        n = rate * info.data.get("duration_s", 0.0)
        if n > bounds.RUN_SAMPLES:
            raise Invalid(f"{n:.3g} samples are too many", f"simulate {bounds.RUN_SAMPLES} at most")
        return rate

    @field_validator("models")
    @classmethod
    def _complete(cls, models: dict[Model, dict[str, float]]) -> dict[Model, dict[str, float]]:
        for model, parameters in models.items():
            check_parameters(model, parameters)
        return models

    @field_validator("laser")
    @classmethod
    def _a_record_is_of_one_release(
        cls, laser: VirtualLaser | None, info: ValidationInfo
    ) -> VirtualLaser | None:
        if laser is None:
            return laser
        if len(info.data.get("models", ())) > 1:
            raise Invalid("a record needs exactly one model", "keep one of the models")
        if info.data.get("ground"):
            raise Invalid("a record cannot have a ground motion", "remove ground, or laser")
        if not info.data.get("release_angle_deg"):
            raise Invalid("no block is released", "give release_angle_deg")
        return laser


def load_scene(path: str | Path) -> Scene:
    """Read and check a scene.

    Raises
    ------
    freerock.config.mistakes.ConfigError
        All problems of the file.
    """
    path = Path(path)
    data, lines, problems = read_yaml(path)
    scene: Scene = validate(Scene, data, lambda loc: place(path, lines, loc), problems)
    refuse(problems)
    return scene
