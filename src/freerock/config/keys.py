"""The groups of keys of a campaign's YAML file, except sensors; `campaign.py` defines the whole file.

The fields of a section are the settings of the step it configures; `defaults.py` has those of `processing`.
"""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, create_model, field_validator, model_validator

from freerock import bounds
from freerock.config.default_uncertainties import BlockUncertainty, stated_only_with
from freerock.config.defaults import (
    FIT_SETTINGS,
    IMPACT_LIMITS,
    ROTATION_OPTIONS,
    RUN_LIMITS,
    ImpactLimits,
    RotationOptions,
    RunLimits,
)
from freerock.config.values import (
    Candidate,
    Debonding,
    Folder,
    Invalid,
    Kinematics,
    Label,
    Length,
    Model,
    Name,
    Number,
    Once,
    OneOrMore,
    Place,
    Positive,
    Section,
    Whole,
    check_name,
    key,
)
from freerock.models.block import GRAVITY, Block
from freerock.models.given import Given, faults
from freerock.models.laws import CANDIDATES, KINEMATICS, LAWS, MODELS, Law


def check_parameters(model: str, parameters: Mapping[str, float], on: str = "", width: bool = False) -> None:
    """Refuse parameters that are not exactly those of a model; `on` names the foundation in the message.

    With `width`, width_fraction is among them.
    """
    names = (*MODELS[model], *(["width_fraction"] if width else []))
    for name in parameters:
        check_name(name, names, f"a parameter of {model}")
    for name in names:
        if name not in parameters:
            raise Invalid(f"{model}{on} has no {name}", f"give {name} or leave {model} out")
    if parameters.get("r", 0) > 1:
        raise Invalid(f"r = {parameters['r']:g}{on} is above 1", "give r up to 1")


IMPOSSIBLE = 0.01, 1e7  # `density_if_square` of a block [kg/m³], beyond which a unit is wrong


def density_if_square(height_m: float, width_m: float, mass_kg: float) -> float:
    """Density of a block, were it as deep as it is high [kg/m³]."""
    return mass_kg / (height_m**2 * width_m)


class BlockSection(Section):
    """A rigid rectangular block."""

    height_m: Length = key("the full height 2h in metres")
    width_m: Length = key("the full width 2b in the plane of rocking in metres")
    mass_kg: Number = key("the mass in kilograms", gt=0, le=1e6)
    contact_width_m: Length | None = key(
        "the distance between the corners about which it rocks, in metres; by default the full width", None
    )
    com_height_m: Length | None = key(
        "the height of its centre of mass over the base in metres; by default half the height", None
    )
    com_offset_m: Place | None = key(
        "the distance of its centre of mass right of the middle, in metres; by default 0", None
    )
    inertia_kg_m2: Positive | None = key(
        "the moment of inertia about its centre of mass in kg m²; by default as for a uniform rectangle", None
    )
    gravity_m_s2: Positive | None = key(
        f"the acceleration of gravity where it rocks in m/s²; by default {GRAVITY:g}", None
    )
    release_angle_deg: Number | None = key(
        "the nominal release angle in degrees, as printed in table 1", None, gt=0, lt=90
    )
    label: Label = key("the name printed in tables and figures; by default the key", "")
    uncertainty: BlockUncertainty = key("the standard uncertainties of its keys", BlockUncertainty())

    @property
    def block(self) -> Block:
        """The block as the models take it."""
        shape: dict[str, Any] = {each.name: getattr(self, each.name, None) for each in fields(Block)}
        return Block(**shape)

    @field_validator("mass_kg")
    @classmethod
    def _dense(cls, mass: Any, info: ValidationInfo) -> Any:
        if {"height_m", "width_m"} <= info.data.keys():
            density = density_if_square(info.data["height_m"], info.data["width_m"], mass)
            if not IMPOSSIBLE[0] < density < IMPOSSIBLE[1]:
                raise Invalid(
                    f"as deep as it is high, the block would have {density:.3g} kg/m³",
                    "give height_m and width_m in metres, mass_kg in kilograms",
                )
        return mass

    @field_validator("contact_width_m")
    @classmethod
    def _within(cls, width: Any, info: ValidationInfo) -> Any:
        if width is not None and width > info.data.get("width_m", math.inf):
            raise Invalid(f"{width:g} is more than the full width", "correct one of the two")
        return width

    @field_validator("com_offset_m")
    @classmethod
    def _over_the_middle_third(cls, offset: Any, info: ValidationInfo) -> Any:
        width = info.data.get("contact_width_m") or info.data.get("width_m", math.inf)
        if offset is not None and abs(offset) >= width / 6:
            raise Invalid(f"{offset:g} is not within a sixth of the width", "correct one of the two")
        return offset

    _of_what_is_given = stated_only_with("contact_width_m", "give contact_width_m beside, or remove it")

    @field_validator("release_angle_deg")
    @classmethod
    def _below_critical(cls, angle: Any, info: ValidationInfo) -> Any:
        if angle is not None and {"height_m", "width_m", "mass_kg"} <= info.data.keys():
            shape: dict[str, Any] = {each.name: info.data.get(each.name) for each in fields(Block)}
            critical = math.degrees(Block(**shape).theta_cr)
            if angle >= critical:
                raise Invalid(
                    f"released at {angle:g}° the block overturns, its critical angle is {critical:.3f}°",
                    "correct the release angle, the height or the width",
                )
        return angle


class FoundationSection(Section):
    """What the blocks stand on."""

    label: Label = key("the name printed in tables and figures; by default the key", "")
    levelled_deg: Number | None = key(
        "the largest tilt of its base in the plane of rocking, in degrees; without it, tilt adds nothing to "
        "`u_total`, and `freerock check` reports a doubt for measured records",
        None,
        ge=0,
        le=10,
    )


class ProcessingSection(Section):
    """The steps from volts to impacts."""

    rotation: RotationOptions = key("volts to θ(t)", ROTATION_OPTIONS)
    runs: RunLimits = key("θ(t) to free-rocking runs", RUN_LIMITS)
    impacts: ImpactLimits = key("runs to impacts and restitution", IMPACT_LIMITS)


def _free_field(law: Law) -> tuple[Any, Any]:
    """Type and default of the key that says what is freed of one law."""
    names: Any = Literal.__getitem__(law.may_free)  # type checkers want words written out
    return Annotated[tuple[names, ...], Once], key(f"{', '.join(law.may_free)} or none", law.free)


_FREE_FIELDS: dict[str, Any] = {model: _free_field(law) for model, law in LAWS.items() if not law.bounces}
FreeSection = create_model(
    "FreeSection", __base__=Section, __doc__="Further free parameters of each model.", **_FREE_FIELDS
)


class GivenSection(Section):
    """Options of a parameter, in lmfit's words and SI units."""

    value: Number | None = key("its value if vary is false; otherwise an additional start value", None)
    min: Number | None = key("its lower bound", None)
    max: Number | None = key("its upper bound", None)
    vary: bool = key("false to fix it at its value", True)
    expr: str = key("an expression that ties it to other parameters of the law, as 18.9*k", "")


class FitsSection(Section):
    """Identification of the models."""

    models: tuple[Model, ...] = key(
        "the laws to fit: "
        + "; ".join(f"{model} ({law.note})" for model, law in LAWS.items())
        + ". Fitted only if the residuals of the others exceed the noise: "
        + ", ".join(model for model, law in LAWS.items() if law.cases)
        + ". Fitted to runs that bounced, listed or not: "
        + ", ".join(model for model, law in LAWS.items() if law.bounces),
        tuple(model for model, law in LAWS.items() if law.by_default),
        min_length=1,
    )
    kinematics: Annotated[tuple[Kinematics, ...], Once] = key(
        "the kinematics of rivals: guided (centre of the base held, as in the paper) or pivoting (about the "
        "lower corner)",
        KINEMATICS,
        min_length=1,
    )
    free: FreeSection = key("further free parameters, law by law", FreeSection())
    parameters: dict[Model, dict[str, GivenSection]] = key(
        "law: parameter: its bounds, its start, its fixed value, or its tie", {}
    )
    paper_mode: bool = key(
        "true to free only the parameters of the laws and fit no rivals, as in Spanos et al. 2017", False
    )
    debonding: Debonding = key(
        "geometric (contact wherever the base is below the ground) or tensionless (only where the foundation"
        " also pushes)",
        FIT_SETTINGS.debonding,
    )
    integrator_error: Number = key(
        "the largest shift of a parameter by the integrator's error, as a share of its standard error",
        FIT_SETTINGS.integrator_error,
        gt=0,
        le=1,
    )
    profile: bool = key(
        "true to take 95 % intervals from the profile likelihood: some seconds per fit", FIT_SETTINGS.profile
    )

    @field_validator("parameters")
    @classmethod
    def _sound(cls, parameters: Any) -> Any:
        for law, own in parameters.items():
            given = {name: Given(**section.model_dump()) for name, section in own.items()}
            for name, what, remedy in faults(law, given):
                raise Invalid(f"{law}.{name} {what}", remedy)
        return parameters

    @property
    def freed(self) -> dict[str, tuple[str, ...]]:
        """What else is freed, law by law."""
        return {model: () if self.paper_mode else free for model, free in self.free}

    @property
    def given(self) -> dict[str, dict[str, dict[str, Any]]]:
        """What is given of parameters before the fits, by law and parameter."""
        return {
            law: {name: section.model_dump(exclude_defaults=True) for name, section in own.items()}
            for law, own in self.parameters.items()
        }

    @property
    def rivals(self) -> tuple[str, ...]:
        """Kinematics that rivals of the paper's models may take; none where there are no rivals."""
        return () if self.paper_mode else self.kinematics


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


class GroundMotionsSection(Section):
    """Ground motions under which the identified law of each record is simulated."""

    folder: Folder = key("the folder of the accelerograms, as .at2 or tables", min_length=1)
    scales: Annotated[tuple[Positive, ...], OneOrMore] = key("factors on each motion, one or more", (1.0,))
    draws: Whole = key("sets of parameters for each motion, including the means", 20, ge=1, le=10_000)
    of: Literal["next", "mean"] = key(
        "the parameters that are drawn: of the next run, or the mean ones", "next"
    )
    motions_per_job: Whole = key("the largest number of motions per job", 10, ge=1)


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
        for name in {name for parameters in spread.values() for name in parameters}:
            check_name(name, sorted(every), "a parameter of a law")
        return spread


class PublishedSection(Section):
    """Values of a publication, printed beside the identified ones."""

    doi: str = key("the DOI of the publication, as 10.…/…", pattern=r"^10\.\d{4,9}/\S+$", max_length=200)
    values: dict[Name, dict[Name, dict[Model, dict[str, Number]]]] = key(
        "block: foundation: model: parameter: value, in SI units; epsilon_theta as a fraction counts as a "
        "parameter"
    )
    longest: dict[Name, Name] = key("block: the foundation on which it rocks longest in the publication", {})

    @field_validator("values")
    @classmethod
    def _known_parameters(cls, values: Any) -> Any:
        for foundations in values.values():
            for models in foundations.values():
                for model, parameters in models.items():
                    for name in parameters:
                        check_name(name, (*MODELS[model], "epsilon_theta"), f"a parameter of {model}")
        return values
