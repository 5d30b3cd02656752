"""Configuration: YAML and CSV files in, checked campaigns out.

Every problem of every file is told at once, one line each: file and line, key, what is wrong, what to do.
The fields of a section are the keyword arguments of the step it configures.
"""

import csv
import difflib
import io
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, get_args, get_origin

import yaml
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.laws import DEBONDING, LAWS, MODELS, Law
from freerock.units import CHANNEL_UNITS

NAME = r"^[A-Za-z0-9_]+$"
FILL_IN = "FILL_IN"  # what `freerock new-campaign` writes where only the user knows
OPTIONS = ("campaigns", "studies")  # of snakemake --config
RESERVED = {  # folders of results that are no campaign's
    "studies": "the results of the studies",
    "inspect": "the pictures of `freerock inspect`",
    "simulate": "the results of `freerock simulate`",
}
SCHEMA_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
OVERRIDE = re.compile(r"(\d+)@(\d+(?:\.\d*)?):(\d+(?:\.\d*)?)")


Key = tuple[str, ...]  # where a value stands: the keys and list positions on the way to it
Lines = dict[Key, int]  # line of each key of a YAML file


class ConfigError(FreerockError):
    """All problems of the configuration; str() has one line for each.

    Parameters
    ----------
    problems : sequence of FreerockError
        At least one; where, what and remedy are those of the first.
    """

    def __init__(self, problems: Sequence[FreerockError]) -> None:
        self.problems = tuple(problems)
        first = self.problems[0]
        super().__init__(first.where, first.what, first.remedy)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.problems,)

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


class Fault(ValueError):
    """What a validator found, with its remedy."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.what, self.remedy = what, remedy


def _not_a_switch(value: Any) -> Any:
    if isinstance(value, bool):  # pydantic would read true as 1
        raise Fault(f"{str(value).lower()} is not a number", "give a number")
    return value


Number = Annotated[float, BeforeValidator(_not_a_switch)]
Whole = Annotated[int, BeforeValidator(_not_a_switch)]
Unit = Literal["", "V", "mV", "kV", "mA", "A", "m", "cm", "mm", "um", "rad", "mrad", "deg"]
Name = Annotated[str, StringConstraints(pattern=NAME)]
if TYPE_CHECKING:  # words known only at run time
    Model: TypeAlias = str
    Debonding: TypeAlias = str
else:
    Model = Literal[tuple(LAWS)]
    Debonding = Literal[DEBONDING]


class Section(BaseModel):
    """A group of keys: unknown keys are refused, nothing changes after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, str_strip_whitespace=True)


class BlockSection(Section):
    """A rigid rectangular block."""

    height_m: Number = Field(gt=0, le=100, description="the full height 2h in metres")
    width_m: Number = Field(gt=0, le=100, description="the full width 2b in the plane of rocking in metres")
    mass_kg: Number = Field(gt=0, le=1e6, description="the mass in kilograms")
    contact_width_m: Number | None = Field(
        None,
        gt=0,
        le=100,
        description="the distance of the corners it rocks about in metres, where they are worn or rounded; "
        "left out, the full width",
    )
    release_angle_deg: Number | None = Field(
        None, gt=0, lt=90, description="the nominal release angle in degrees, as printed in table 1"
    )
    label: str = Field("", description="the name printed in tables and figures; left out, the key")

    @property
    def block(self) -> Block:
        """The block as the models take it."""
        return Block(self.height_m, self.width_m, self.mass_kg, self.contact_width_m)

    @field_validator("contact_width_m")
    @classmethod
    def _within(cls, width: Any, info: ValidationInfo) -> Any:
        if width is not None and width > info.data.get("width_m", math.inf):
            raise Fault(f"{width:g} is more than the full width", "correct one of the two")
        return width

    @field_validator("release_angle_deg")
    @classmethod
    def _below_critical(cls, angle: Any, info: ValidationInfo) -> Any:
        if angle is not None and {"height_m", "width_m"} <= info.data.keys():
            shape = info.data["height_m"], info.data["width_m"], 1.0, info.data.get("contact_width_m")
            critical = math.degrees(Block(*shape).theta_cr)
            if angle >= critical:
                raise Fault(
                    f"released at {angle:g}° the block overturns, its critical angle is {critical:.3f}°",
                    "correct the release angle, the height or the width",
                )
        return angle


class FoundationSection(Section):
    """What the blocks stand on."""

    label: str = Field("", description="the name printed in tables and figures; left out, the key")


class LaserSection(Section):
    """A displacement sensor: where its beam meets the block, and its output."""

    units: Unit = Field(
        "",
        description="the unit of the channel: V, mV, kV, mA, A (of the sensor's output), m, cm, mm, um (of "
        "the displacement), rad, mrad, deg (of the rotation itself); left out, as the file states it",
    )
    beam: Literal["horizontal", "vertical"] | None = Field(
        None,
        validate_default=True,
        description="horizontal (meets a side face) or vertical (meets the top); compulsory unless units "
        "are those of a rotation",
    )
    position_m: Number | None = Field(
        None,
        validate_default=True,
        description="the height of a horizontal beam above the base, or the distance of a vertical beam "
        "to the right of the centre line, in metres; compulsory with a beam",
    )
    range_m: Number | None = Field(None, gt=0, description="the measuring range in metres")
    sensitivity_per_mm: Number | None = Field(
        None, gt=0, description="the output per millimetre in V or mA, in place of range_m"
    )
    calibration: str | None = Field(
        None,
        description="a CSV file in the raw folder with columns of output and distance, headed by their units "
        "as V,mm; in place of range_m",
    )
    face: Literal["left", "right"] = Field("left", description="the face met by a horizontal beam")
    sign: Literal[1, -1] = Field(1, description="1 when the volts grow with the distance, -1 when they fall")
    release_side: Literal["positive", "negative"] = Field(
        "positive",
        description="positive (clockwise) or negative: the side of the first swing after a rest, "
        "for a vertical beam between the corners, which can't tell",
    )
    volts_at_start: Number = Field(0.0, description="the volts at the start of the measuring range")
    volts_at_end: Number = Field(
        10.0, validate_default=True, description="the volts at the end of the measuring range"
    )
    valid_low_v: Number = Field(-0.1, description="the lowest valid output in volts")
    valid_high_v: Number = Field(10.1, description="the highest valid output in volts")
    error_level_v: Number = Field(10.2, description="the output in volts that means no target")
    error_tolerance_v: Number = Field(0.01, ge=0, description="the tolerance of the error level in volts")
    milliamps_at_start: Number = Field(
        4.0, description="the milliamperes at the start of the measuring range"
    )
    milliamps_at_end: Number = Field(
        20.0, validate_default=True, description="the milliamperes at the end of the measuring range"
    )
    valid_low_ma: Number = Field(3.84, description="the lowest valid output in milliamperes")
    valid_high_ma: Number = Field(20.16, description="the highest valid output in milliamperes")
    error_level_ma: Number = Field(3.75, description="the output in milliamperes that means no target")
    error_tolerance_ma: Number = Field(
        0.01, ge=0, description="the tolerance of the error level in milliamperes"
    )

    @field_validator("beam", "position_m")
    @classmethod
    def _beam_is_placed(cls, value: Any, info: ValidationInfo) -> Any:
        units = info.data.get("units", "")
        is_rotation = bool(units) and CHANNEL_UNITS[units][0] == "rotation"
        if is_rotation and value is not None:
            raise Fault(f"a channel in {units} is the rotation itself", "remove it, or correct units")
        if value is None and not is_rotation:
            given = str(cls.model_fields[str(info.field_name)].description).partition(";")[0]
            raise Fault(
                "is missing", f"give {given}, or declare units: deg where the channel is the rotation"
            )
        return value

    @field_validator("calibration")
    @classmethod
    def _table_is_inside(cls, calibration: Any) -> Any:
        return _inside(calibration) if calibration else None

    @field_validator("calibration", "sensitivity_per_mm")
    @classmethod
    def _scaled_once(cls, value: Any, info: ValidationInfo) -> Any:
        given = [way for way in ("range_m", "sensitivity_per_mm") if info.data.get(way) is not None]
        if value is not None and given:
            raise Fault(f"{given[0]} scales the output already", "keep one of the two")
        return value

    @field_validator("position_m")
    @classmethod
    def _above_the_base(cls, position: Any, info: ValidationInfo) -> Any:
        if position is not None and info.data.get("beam") == "horizontal" and position <= 0:
            raise Fault(f"{position:g} is not above the base", "give the height of the beam in metres")
        return position

    @field_validator("volts_at_end", "milliamps_at_end")
    @classmethod
    def _rising(cls, end: Any, info: ValidationInfo) -> Any:
        start = str(info.field_name).replace("end", "start")
        if end <= info.data.get(start, -math.inf):
            raise Fault(f"{end:g} is not above {start}", "swap the two and set sign: -1")
        return end


class RotationSection(Section):
    """Volts to θ(t)."""

    mains_hz: Number | None = Field(
        50.0, gt=0, description="the mains frequency in hertz, whose hum is taken out; empty to leave it in"
    )
    window_s: Number = Field(
        0.25, gt=0, description="the window in which a still signal is sought, in seconds"
    )
    max_disagreement_deg: Number = Field(
        0.5, gt=0, description="how much two lasers may differ without a warning, in degrees"
    )


class RunsSection(Section):
    """θ(t) to free-rocking runs."""

    window_s: Number = Field(
        0.25, gt=0, description="the window in which a still block is sought, in seconds"
    )
    held_s: Number = Field(
        1.0, gt=0, description="how long before the release the held angle is read, in seconds"
    )
    finger_s: Number = Field(
        0.03, ge=0, description="the time the finger takes to leave, in seconds; its samples are not fitted"
    )
    min_impacts: Whole = Field(3, ge=0, description="the fewest impacts of a run that is not a fail")
    max_flagged_fraction: Number = Field(
        0.02, ge=0, le=1, description="the largest share of invalid samples of a run that is not a fail"
    )
    max_push_fraction: Number = Field(
        0.02, ge=0, description="the largest push at the release without a warning, as a share of θ0"
    )
    max_hold_drift_deg: Number = Field(
        0.05, ge=0, description="the largest creep of the held angle without a warning, in degrees"
    )
    max_rest_shift_deg: Number = Field(
        0.05, ge=0, description="the largest shift of the rest position without a warning, in degrees"
    )
    max_growth_fraction: Number = Field(
        0.05,
        ge=0,
        description="how much higher than the one before a swing may be, as a share, before it is a fail",
    )


class ImpactsSection(Section):
    """A run to its impacts and restitution coefficients."""

    min_amplitude_sigmas: Number = Field(
        10.0, gt=0, description="the lowest peak that counts, as a multiple of σ_θ"
    )
    min_uplift_ratio: Number = Field(
        2.0, ge=1, description="the lowest peak that counts, as a multiple of the uplift amplitude"
    )
    min_samples: Whole = Field(12, ge=3, description="the fewest samples of a swing that counts")


class ProcessingSection(Section):
    """The steps from volts to impacts."""

    rotation: RotationSection = Field(RotationSection(), description="volts to θ(t)")
    runs: RunsSection = Field(RunsSection(), description="θ(t) to free-rocking runs")
    impacts: ImpactsSection = Field(ImpactsSection(), description="runs to impacts and restitution")


class _EachOnce(Section):
    """What is fitted besides the parameters of each model, within what was measured of it."""

    @field_validator("*")
    @classmethod
    def _each_once(cls, names: Any) -> Any:
        for name in names:
            if names.count(name) > 1:
                raise Fault(f"{name} is given twice", "keep one")
        return names


def _free_field(law: Law) -> tuple[Any, Any]:
    """Type and default of the key that says what is freed of one law."""
    text = ", ".join(law.nuisances).replace("impact", "impact (of single runs: needs pooled: false)")
    names: Any = Literal.__getitem__(law.nuisances)  # type checkers want words written out
    return tuple[names, ...], Field(law.free, description=f"{text} or none")


_FREE_FIELDS: dict[str, Any] = {model: _free_field(law) for model, law in LAWS.items()}
FreeSection = create_model("FreeSection", __base__=_EachOnce, __doc__=_EachOnce.__doc__, **_FREE_FIELDS)


class FitsSection(Section):
    """Identification of the models."""

    models: tuple[Model, ...] = Field(
        tuple(model for model, law in LAWS.items() if law.by_default),
        min_length=1,
        description="the models to fit: "
        + ", ".join(f"{model} ({law.note})" if law.note else model for model, law in LAWS.items()),
    )
    free: FreeSection = Field(FreeSection(), description="what else is freed, model by model")
    paper_mode: bool = Field(
        False, description="true to free the parameters of the models only, as Spanos et al. 2017 did"
    )
    debonding: Debonding = Field(
        "geometric",
        description="geometric (contact wherever the base is below the ground) "
        "or tensionless (and the foundation pushes)",
    )
    integrator_error: Number = Field(
        0.2,
        gt=0,
        le=1,
        description="the largest shift of a parameter by the integrator's error, as a share of its standard "
        "error",
    )
    profile: bool = Field(
        False, description="true for intervals of the profile likelihood, some seconds a fit, else false"
    )
    pooled: bool = Field(
        True,
        validate_default=True,
        description="true to fit all runs of a record jointly as well, else false",
    )

    @field_validator("pooled")
    @classmethod
    def _each_impact_is_of_one_run(cls, pooled: Any, info: ValidationInfo) -> Any:
        free = info.data.get("free")
        if pooled and free and any("r_per_impact" in names for _, names in free):
            raise Fault("a joint fit has no restitution per impact", "set it false, or free no r_per_impact")
        return pooled

    @property
    def freed(self) -> dict[str, tuple[str, ...]]:
        """What else is freed, model by model."""
        return {model: () if self.paper_mode else free for model, free in self.free}


Positive = Annotated[Number, Field(gt=0)]


class SensorSection(Section):
    """A sensor to plan with: its white noise in volts, metres or degrees, and its range."""

    noise_v: Number | None = Field(None, gt=0, description="the standard deviation of its noise in volts")
    noise_m: Number | None = Field(None, gt=0, description="the standard deviation of its noise in metres")
    noise_deg: Number | None = Field(
        None, gt=0, description="the standard deviation of the noise of θ itself in degrees"
    )
    range_m: Number | None = Field(
        None, gt=0, description="its measuring range in metres; left out, that of the record's laser"
    )

    @model_validator(mode="after")
    def _one_noise(self) -> Self:
        given = [name for name in ("noise_v", "noise_m", "noise_deg") if getattr(self, name) is not None]
        if len(given) != 1:
            raise Fault(f"has {' and '.join(given) or 'no noise'}", "give one of noise_v, noise_m, noise_deg")
        return self


class PlanSection(Section):
    """What `freerock plan` predicts standard errors for, before any test."""

    expected: dict[Name, dict[Model, dict[str, Positive]]] = Field(
        min_length=1, description="foundation: model: parameter: the value expected, in SI units"
    )
    sensors: dict[Name, SensorSection] = Field(
        min_length=1, description="one or more sensors, each by its name"
    )
    sampling_rates_hz: tuple[Positive, ...] = Field(
        (2000.0,), description="the sampling rates in hertz, one or more"
    )
    durations_s: tuple[Positive, ...] = Field(
        (8.0,), description="how long a run is measured, in seconds, one or more"
    )
    release_angles_deg: dict[Name, tuple[Positive, ...]] = Field(
        {}, description="block: list of release angles in degrees; left out, release_angle_deg of the block"
    )

    @field_validator("sampling_rates_hz", "durations_s")
    @classmethod
    def _one_or_more(cls, values: Any) -> Any:
        if not values:
            raise Fault("is empty", "give one or more numbers, or leave it out")
        return values

    @field_validator("expected")
    @classmethod
    def _complete(cls, expected: Any) -> Any:
        for foundation, models in expected.items():
            for model, parameters in models.items():
                check_parameters(model, parameters, f" on {foundation}")
        return expected


class PublishedSection(Section):
    """Values of a publication, printed beside the identified ones."""

    doi: str = Field(pattern=r"^10\.\d{4,9}/\S+$", description="the DOI of the publication, as 10.…/…")
    values: dict[Name, dict[Name, dict[Model, dict[str, Number]]]] = Field(
        description="block: foundation: model: parameter: value, "
        "in SI units; epsilon_theta as a fraction counts as a parameter"
    )

    @field_validator("values")
    @classmethod
    def _known_parameters(cls, values: Any) -> Any:
        for foundations in values.values():
            for models in foundations.values():
                for model, parameters in models.items():
                    for name in parameters:
                        _known(name, (*MODELS[model], "epsilon_theta"), f"a parameter of {model}")
        return values


class CampaignFile(Section):
    """A test campaign: config/campaigns/<name>.yaml."""

    title: str = Field(min_length=1, description="the title of the campaign")
    origin: Literal["simulated", "measured"] = Field(
        description="simulated or measured, as shown in every dataset, table and figure"
    )
    summary: str = Field("", description="what was tested, how and why, in a sentence or two")
    institution: str = Field("", description="the laboratory")
    creator: str = Field("", description="who made the records")
    license: str = Field("", description="the licence of the records")
    references: str = Field("", description="publications, as doi:10.…/…")
    raw: str = Field("", description="the folder of the record files; left out, raw/<name of the campaign>")
    truth: str = Field("", description="the file of true values in the raw folder, of a simulated campaign")
    blocks: dict[Name, BlockSection] = Field(min_length=1, description="one or more blocks, each by its name")
    foundations: dict[Name, FoundationSection] = Field(
        min_length=1, description="one or more foundations, each by its name"
    )
    lasers: dict[Name, LaserSection] = Field(
        min_length=1, description="one or more sensors, each by its name"
    )
    records_per_job: int = Field(
        4, ge=1, description="records that a job takes on; with hundreds of records 25 saves start-up time"
    )
    figures_for: tuple[Literal["single_column", "slide"], ...] = Field(
        (), description="what else figures are drawn for, beside the double column of a paper"
    )
    processing: ProcessingSection = Field(ProcessingSection(), description="the steps from volts to impacts")
    fits: FitsSection = Field(FitsSection(), description="the identification of the models")
    published: PublishedSection | None = Field(
        None, description="values of a publication, printed beside the identified ones"
    )
    plan: PlanSection | None = Field(
        None, description="what `freerock plan` predicts standard errors for, before any test"
    )

    @field_validator("blocks", "foundations")
    @classmethod
    def _labelled(cls, sections: Any, info: ValidationInfo) -> Any:
        first: dict[str, str] = {}  # name of each label
        for name, section in sections.items():
            if info.field_name == "foundations" and name in info.data.get("blocks", ()):
                raise Fault(f"{name!r} is the name of a block already", "rename one of the two")
            other = first.setdefault(section.label or name, name)
            if other != name:
                what = f"{other!r} and {name!r} are both printed as {section.label or name!r}"
                raise Fault(what, "give each its own label")
        return {name: s if s.label else s.model_copy(update={"label": name}) for name, s in sections.items()}

    @field_validator("truth")
    @classmethod
    def _truth_is_simulated(cls, truth: Any, info: ValidationInfo) -> Any:
        if truth and info.data.get("origin") == "measured":
            raise Fault("a measured campaign has no known truth", "remove the key or set origin: simulated")
        return _inside(truth) if truth else truth

    @field_validator("published")
    @classmethod
    def _published_is_configured(cls, published: Any, info: ValidationInfo) -> Any:
        for block, foundations in published.values.items() if published else ():
            _known(block, info.data.get("blocks", (block,)), "a block of this campaign")
            for name in foundations:
                _known(name, info.data.get("foundations", (name,)), "a foundation of this campaign")
        return published

    @field_validator("plan")
    @classmethod
    def _plan_is_configured(cls, plan: Any, info: ValidationInfo) -> Any:
        if plan is None or not {"blocks", "foundations"} <= info.data.keys():
            return plan
        blocks, foundations = info.data["blocks"], info.data["foundations"]
        for name in plan.expected:
            _known(name, foundations, "a foundation of this campaign")
        for name in foundations:
            if name not in plan.expected:
                raise Fault(f"nothing is expected of foundation {name!r}", "add it to plan.expected")
        for name, angles in plan.release_angles_deg.items():
            _known(name, blocks, "a block of this campaign")
            critical = math.degrees(blocks[name].block.theta_cr)
            if max(angles, default=0) >= critical:
                what = f"released at {max(angles):g}° {name} overturns, its critical angle is {critical:.3f}°"
                raise Fault(what, "plan for smaller angles")
        for name, block in blocks.items():
            if not (plan.release_angles_deg.get(name) or block.release_angle_deg):
                raise Fault(f"block {name!r} has no release angle", "add it to plan.release_angles_deg")
        return plan


class Record(Section):
    """A record: one line of config/campaigns/<name>.csv."""

    test: Name = Field(description="the name of the record: letters, digits and _")
    file: str = Field(min_length=1, description="the record file, inside the raw folder")
    channel: str = Field(
        "", description="the channel of the laser; empty when the file has only one; of two lasers, as a;b"
    )
    block: str = Field(description="the name of a block")
    foundation: str = Field(description="the name of a foundation")
    laser: str = Field(description="the name of a laser, or of the two on one record, as a;b")
    exclude: str = Field(
        "",
        pattern=r"^(record|\d+(;\d+)*)?$",
        description="nothing, record, or the numbers of the runs left out, as 2;3",
    )
    override: str = Field(
        "",
        description="nothing, or hand-set release and end in seconds, as 2@12.310:19.800; more after a ;",
    )
    reason: str = Field("", description="why a run is excluded or overridden")
    note: str = Field("", description="anything worth keeping")

    @field_validator("file")
    @classmethod
    def _file_is_inside(cls, file: Any) -> Any:
        return _inside(file)

    @field_validator("override")
    @classmethod
    def _release_before_end(cls, override: Any) -> Any:
        runs = []
        for item in filter(None, override.split(";")):
            match = OVERRIDE.fullmatch(item.strip())
            if not match:
                raise Fault(f"{item!r} is not run@release:end", "give run and seconds, as 2@12.310:19.800")
            if float(match[2]) >= float(match[3]):
                raise Fault(f"run {match[1]} ends before it is released", "give the release first")
            runs.append(int(match[1]))
        if len(set(runs)) < len(runs):
            raise Fault("a run is overridden twice", "give each run once")
        return override

    @field_validator("reason")
    @classmethod
    def _reason_given(cls, reason: Any, info: ValidationInfo) -> Any:
        if not reason and (info.data.get("exclude") or info.data.get("override")):
            raise Fault("a run is excluded or overridden without a reason", "say why")
        return reason

    @field_validator("laser")
    @classmethod
    def _a_channel_for_each(cls, laser: Any, info: ValidationInfo) -> Any:
        lasers = laser.split(";")
        channels = [name.strip() for name in info.data.get("channel", "").split(";")]
        remedy = "name a channel for each, as a;b in both columns"
        if len(lasers) > 2:
            raise Fault(f"{laser!r} are more than two lasers", "name one or two")
        if len(channels) != len(lasers):
            raise Fault(f"{len(lasers)} for {len(channels)} channels", remedy)
        if len(set(channels)) < len(channels):
            raise Fault(f"both are given channel {channels[0]!r}", remedy)
        return laser

    @property
    def lasers(self) -> tuple[str, ...]:
        """Name of the laser, or of the two."""
        return tuple(name.strip() for name in self.laser.split(";"))

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel of each laser, "" for the only one of the file."""
        return tuple(name.strip() for name in self.channel.split(";"))

    @property
    def excluded(self) -> bool:
        """Whether the whole record is left out."""
        return self.exclude == "record"

    @property
    def exclusions(self) -> tuple[tuple[int, str], ...]:
        """(run, reason) of each run left out."""
        runs = () if self.excluded else filter(None, self.exclude.split(";"))
        return tuple((int(run), self.reason) for run in runs)

    @property
    def overrides(self) -> tuple[tuple[int, float, float, str], ...]:
        """(run, release [s], end [s], reason) of each run set by hand."""
        return tuple(
            (int(run), float(release), float(end), self.reason)
            for run, release, end in OVERRIDE.findall(self.override)
        )


class Campaign(CampaignFile):
    """A campaign as loaded: its YAML file and the records of its CSV file."""

    name: Name = Field(description="the name of the campaign")
    records: tuple[Record, ...] = Field(description="the records")

    @property
    def batches(self) -> list[tuple[Record, ...]]:
        """The records job by job, in the order of the CSV file."""
        n = self.records_per_job
        return [self.records[start : start + n] for start in range(0, len(self.records), n)]

    def record(self, test: str) -> Record:
        """The record of a test."""
        return next(record for record in self.records if record.test == test)

    def file(self, test: str) -> str:
        """Path of the record file of a test."""
        return f"{self.raw}/{self.record(test).file}"


class ConfigFile(Section):
    """What is analysed: config/config.yaml."""

    campaigns: tuple[Name, ...] = Field(
        min_length=1, description="the campaigns to analyse, as a list of names in config/campaigns"
    )


class Config(Section):
    """The configuration as loaded: the campaigns by their names."""

    campaigns: dict[str, Campaign]


def load_config(
    path: str | Path = "config/config.yaml", campaigns: str | Sequence[str] | None = None
) -> Config:
    """Read and check config.yaml and the campaigns it names.

    Parameters
    ----------
    path : path
        The configuration file; campaigns lie in the folder `campaigns` beside it.
    campaigns : sequence of str, or str with commas, optional
        Names that replace those of the file, which then is not read.

    Returns
    -------
    Config

    Raises
    ------
    ConfigError
        All problems of all files.
    """
    problems: list[FreerockError] = []
    loaded: dict[str, Campaign] = {}
    for campaign_path in campaign_paths(path, campaigns, problems):
        source = read_campaign(campaign_path)
        problems += source.problems
        if source.campaign:
            loaded[campaign_path.stem] = source.campaign
    if problems:
        raise ConfigError(problems)
    return Config.model_construct(campaigns=loaded)


def load_campaign(path: str | Path) -> Campaign:
    """Read and check one campaign: its YAML file and the CSV file of the same name beside it.

    Raises
    ------
    ConfigError
        All problems of both files.
    """
    source = read_campaign(path)
    if source.campaign is None:
        raise ConfigError(source.problems)
    return source.campaign


def load_section(model: type[Section], path: str | Path) -> Any:
    """Read and check a YAML file that holds one section.

    Raises
    ------
    ConfigError
        All problems of the file.
    """
    data, lines, problems = _read_yaml(Path(path))
    section = _validate(model, data, lambda loc: _where(Path(path), lines, loc), problems)
    if problems:
        raise ConfigError(problems)
    return section


def json_schema(model: type[Section]) -> dict[str, Any]:
    """JSON schema of a YAML file that holds a section, for editors."""
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    schema: dict[str, Any] = _plain_schema(model.model_json_schema())
    return dialect | schema


def _plain_schema(schema: Any) -> Any:
    """A schema of pydantic's without its made-up titles, bounds under the names that JSON schema has."""
    if isinstance(schema, list):
        return [_plain_schema(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        SCHEMA_BOUNDS.get(key, key): _plain_schema(value)
        for key, value in schema.items()
        if not (key == "title" and isinstance(value, str))
    }


def campaign_paths(
    path: str | Path, campaigns: str | Sequence[str] | None, problems: list[FreerockError]
) -> list[Path]:
    """YAML files of the campaigns to analyse; arguments as of `load_config`, adds the problems it meets."""
    path = Path(path)
    if campaigns is None:
        data, lines, found = _read_yaml(path)
    else:
        names = campaigns if isinstance(campaigns, list | tuple) else str(campaigns).split(",")
        data, lines, found = {"campaigns": [*map(str, names)]}, {}, []
    file = _validate(ConfigFile, data, lambda loc: _where(path, lines, loc), found)
    problems += found
    where, paths = _where(path, lines, ("campaigns",)), []
    for name in dict.fromkeys(file.campaigns) if file else ():
        campaign_path = path.parent / "campaigns" / f"{name}.yaml"
        if name in RESERVED:
            problems.append(FreerockError(where, f"{name!r} names {RESERVED[name]}", "rename the campaign"))
        elif campaign_path.exists():
            paths.append(campaign_path)
        else:
            others = [p.stem for p in sorted(campaign_path.parent.glob("*.yaml"))]
            what = f"there is no campaign {name!r}: {campaign_path} is missing"
            remedy = _meant(name, others) or "write the file or correct the name"
            problems.append(FreerockError(where, what, remedy))
    return paths


def check_options(options: Iterable[str]) -> None:
    """Refuse misspelt keys of `snakemake --config`; others may be those of a workflow that uses this one.

    Raises
    ------
    FreerockError
        A key is close to one of `OPTIONS`.
    """
    for option in options:
        if option not in OPTIONS and _close(option, OPTIONS):
            raise FreerockError(f"--config: {option}", "unknown key", _meant(option, OPTIONS))


@dataclass(frozen=True)
class Source:
    """What the two files of a campaign hold, as far as they can be understood.

    Parameters
    ----------
    path : Path
        The YAML file.
    campaign : Campaign or None
        None where there are problems.
    lasers : dict of str to LaserSection
        Empty where the YAML file has problems.
    raw : str
        The folder of the record files.
    records : tuple of (int, Record)
        Each sound record with its line in the CSV file.
    lines : dict
        Line of each key of the YAML file.
    problems : tuple of FreerockError
    """

    path: Path
    campaign: Campaign | None
    lasers: dict[str, LaserSection]
    raw: str
    records: tuple[tuple[int, Record], ...]
    lines: Lines
    problems: tuple[FreerockError, ...]

    def where(self, *key: str) -> str:
        """file:line: key of the YAML file."""
        return _where(self.path, self.lines, key)


def read_campaign(path: str | Path) -> Source:
    """Read the YAML file of a campaign and the CSV file beside it; never raises for what they hold."""
    path = Path(path)
    data, lines, problems = _read_yaml(path)
    file = _validate(CampaignFile, data, lambda loc: _where(path, lines, loc), problems)
    if not re.fullmatch(NAME, path.stem):
        problems.append(FreerockError(str(path), "not a name", "name the file by letters, digits and _ only"))
    names = {column: (data or {}).get(f"{column}s") for column in ("block", "foundation", "laser")}
    records = _read_records(path.with_suffix(".csv"), names, path, problems)
    for line, record in records if file else ():
        for what, remedy in _laser_faults(record, file):
            problems.append(FreerockError(f"{path.with_suffix('.csv')}:{line}: laser", what, remedy))
    raw = str((data or {}).get("raw") or "").strip().rstrip("/") or f"raw/{path.stem}"
    campaign = None
    if file and not problems:
        fields = {**dict(file), "raw": raw, "name": path.stem}
        campaign = Campaign.model_construct(**fields, records=tuple(record for _, record in records))
    lasers = file.lasers if file else {}
    return Source(path, campaign, lasers, raw, tuple(records), lines, tuple(problems))


def _laser_faults(record: Record, file: CampaignFile) -> Iterator[tuple[str, str]]:
    """Why the lasers of a record can't watch it, and what to do."""
    known = [name for name in record.lasers if name in file.lasers]
    if len(known) == 2:
        yield from _pair_faults(*(file.lasers[name] for name in known))
    block = file.blocks.get(record.block)
    for name in known:
        at = file.lasers[name].position_m or 0.0
        if block and file.lasers[name].beam == "horizontal" and at > block.height_m:
            what = (
                f"position_m of {name} is {at:g}: above the block {record.block}, {block.height_m:g} m high"
            )
            yield what, "give the beam's height above the base in metres"


def _pair_faults(one: LaserSection, other: LaserSection) -> Iterator[tuple[str, str]]:
    if one.beam is None or (one.beam, one.face) != (other.beam, other.face):
        yield "the two beams differ in kind or in face", "use two of one kind, on one face"
    elif one.position_m == other.position_m:
        yield "the two beams are at one position_m", "give both positions"


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FreerockError(path, f"cannot be read ({error.strerror})", "write the file") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FreerockError(f"{path}:{line}", "is not UTF-8 text", "save the file as UTF-8") from None


def _read_yaml(path: Path) -> tuple[dict[str, Any] | None, Lines, list[FreerockError]]:
    """Keys and values (None when unreadable), the line of each key, and the problems met."""
    try:
        text = _read_text(path)
        loader = yaml.SafeLoader(text)
        root = loader.get_single_node()
        lines: Lines = {}
        problems: list[FreerockError] = []
        for loc, line in _locate_keys(root):
            if loc in lines:
                where, first = f"{path}:{line}: {'.'.join(loc)}", lines[loc]
                problems.append(FreerockError(where, f"is given twice, first on line {first}", "keep one"))
            lines[loc] = line
        data = loader.construct_document(root) if root else None
    except FreerockError as error:
        return None, {}, [error]
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"{path}:{mark.line + 1}" if mark else str(path)
        what = getattr(error, "problem", None) or getattr(error, "reason", None) or "is not YAML"
        return None, {}, [FreerockError(where, what, "correct the YAML; indent with spaces, not tabs")]
    except (ValueError, RecursionError) as error:
        what = str(error) if isinstance(error, ValueError) else "keys are nested without end"
        return None, {}, [FreerockError(path, what, "correct the YAML; put texts in quotes")]
    if not isinstance(data, dict):
        what = "is empty" if data is None else "is not a list of keys and values"
        return None, {}, [*problems, FreerockError(path, what, "write lines of the form key: value")]
    return data, lines, problems


def _locate_keys(node: yaml.Node | None, loc: Key = ()) -> Iterator[tuple[Key, int]]:
    """Location and line of every key and list item below a YAML node; keys become texts, even no and 1."""
    children: list[tuple[str, yaml.Node, yaml.Node]] = []
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if isinstance(key, yaml.ScalarNode) and not key.tag.endswith(":merge"):
                key.tag = "tag:yaml.org,2002:str"
                children.append((key.value, key, value))
    elif isinstance(node, yaml.SequenceNode):
        children = [(str(i), item, item) for i, item in enumerate(node.value)]
    for name, key, value in children:
        yield (*loc, name), key.start_mark.line + 1
        yield from _locate_keys(value, (*loc, name))


def _where(path: Path, lines: Lines, loc: Key) -> str:
    """file:line: key, by the line of the nearest key that is in the file."""
    near = next((loc[:n] for n in range(len(loc), 0, -1) if loc[:n] in lines), None)
    return f"{path}:{lines[near]}: {'.'.join(loc)}" if near else f"{path}: {'.'.join(loc)}"


def _in_line(line: str, loc: Key) -> str:
    """file:line: key, of a line of the CSV file."""
    return f"{line}: {'.'.join(loc)}"


def _read_table(path: Path) -> list[tuple[int, list[str]]]:
    """Line number and cells of each row of a CSV file; empty rows and rows that start with # are left out."""
    rows = csv.reader(io.StringIO(_read_text(path), newline=""), strict=True)
    try:
        table = [(rows.line_num, [cell.strip() for cell in row]) for row in rows]
    except csv.Error as error:
        raise FreerockError(f"{path}:{rows.line_num}", str(error), "check the quotes") from None
    table = [(line, row) for line, row in table if any(row) and not row[0].startswith("#")]
    if len(table) < 2:
        what, remedy = (
            "has no record",
            f"write the line {','.join(Record.model_fields)} and a line per record",
        )
        raise FreerockError(path, what, remedy)
    line, header = table[0]
    if len(header) == 1 and ";" in header[0]:
        raise FreerockError(f"{path}:{line}", "has no commas", "separate the columns by commas")
    return table


def _header_faults(header: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Column, what is wrong with it and what to do."""
    columns, meant = Record.model_fields, []
    for column in dict.fromkeys(header):
        if column not in columns:
            meant += _close(column, columns)
            yield column, "unknown column", _meant(column, columns) or f"use {', '.join(columns)}"
        elif header.count(column) > 1:
            yield column, "column given twice", "keep one"
    for column, field in columns.items():
        if field.is_required() and column not in (*header, *meant):
            yield column, "column is missing", f"add it: {field.description}"


def _read_records(
    path: Path, names: Mapping[str, Any], yaml_path: Path, problems: list[FreerockError]
) -> list[tuple[int, Record]]:
    """The records of a CSV file with their lines; `names` are the blocks, foundations, lasers of the YAML."""

    def fault(line: int, column: str, what: str, remedy: str) -> None:
        problems.append(FreerockError(f"{path}:{line}: {column}", what, remedy))

    try:
        (header_line, header), *rows = _read_table(path)
    except FreerockError as error:
        problems.append(error)
        return []
    faults = list(_header_faults(header))
    for column, what, remedy in faults:
        fault(header_line, column, what, remedy)
    if faults:
        return []

    records: list[tuple[int, Record]] = []
    first_lines: dict[str, int] = {}
    for line, row in rows:
        if len(row) != len(header):
            what = f"has {len(row)} cells, the first line has {len(header)}"
            problems.append(FreerockError(f"{path}:{line}", what, "put texts that hold a comma in quotes"))
            continue
        cells = dict(zip(header, row, strict=True))
        place = partial(_in_line, f"{path}:{line}")
        record = _validate(Record, cells, place, problems)
        records += [(line, record)] if record else []
        for column, known in names.items():
            for cell in cells[column].split(";") if column == "laser" else [cells[column]]:
                if isinstance(known, dict) and cell.strip() not in (*known, FILL_IN):
                    remedy = _meant(cell, known) or f"use one of {', '.join(map(str, known))}"
                    fault(line, column, f"{cell!r} is not a {column} of {yaml_path}", remedy)
        test = cells["test"]
        first = first_lines.setdefault(test.casefold(), line)
        if first != line:
            fault(line, "test", f"{test!r} is on line {first} already", "give each record its own name")
    return records


def _validate(
    model: type[Section],
    data: Mapping[str, Any] | None,
    where: Callable[[Key], str],
    problems: list[FreerockError],
) -> Any:
    """The section, or None and its problems added; `where` words a location."""
    if data is None:
        return None
    blanks = list(_blanks(data))
    for loc in blanks:
        field, _ = _walk(model, loc)
        give = f"give {field.description}" if field else "write the value there"
        problems.append(FreerockError(where(loc), "is still to be filled in", give))
    try:
        section = model.model_validate(data)
        return None if blanks else section
    except ValidationError as error:
        found = error.errors(include_url=False)
    located = [(tuple(str(part) for part in fault["loc"] if part != "[key]"), fault) for fault in found]
    faults = [(loc, fault) for loc, fault in located if loc not in blanks]
    meant = {
        (*loc[:-1], close)
        for loc, fault in faults
        if fault["type"] == "extra_forbidden"
        for close in _close(loc[-1], _keys(model, loc[:-1]))
    }
    for loc, fault in faults:
        if fault["type"] != "missing" or loc not in meant:
            problems.append(FreerockError(where(loc), *_explain(model, loc, fault)))
    return None


def _blanks(data: Any, loc: Key = ()) -> Iterator[Key]:
    """Where a value is still the one to be filled in."""
    if data == FILL_IN:
        yield loc
    elif isinstance(data, Mapping):
        for key, value in data.items():
            yield from _blanks(value, (*loc, str(key)))
    elif isinstance(data, list):
        for i, value in enumerate(data):
            yield from _blanks(value, (*loc, str(i)))


def _explain(model: type[Section], loc: Key, fault: ErrorDetails) -> tuple[str, str]:
    """What is wrong and what to do, for one of pydantic's errors."""
    kind, value, context = fault["type"], fault["input"], fault.get("ctx", {})
    if isinstance(context.get("error"), Fault):
        return context["error"].what, context["error"].remedy
    if kind == "extra_forbidden":
        keys = _keys(model, loc[:-1])
        return "unknown key", _meant(loc[-1], keys) or f"use one of {', '.join(keys)}"
    if context.get("pattern") == NAME and value:
        return f"{value!r} is not a name", "use letters, digits and _ only"
    field, _ = _walk(model, loc)
    give = f"give {field.description}" + (", in quotes" if kind == "string_type" else "")
    if kind == "missing":
        return "is missing", give
    if value in (None, "", {}, [], ()):
        return "is empty", give
    if isinstance(value, dict | list | tuple):
        return f"{'a group of keys' if isinstance(value, dict) else 'a list'} does not belong here", give
    if "pattern" in context:
        return f"{value!r} is not understood", give
    what = fault["msg"].replace("Input should be", "is not").replace("valid tuple", "list")
    what = re.sub(r"valid dictionary.*", "group of keys", what).partition(", unable")[0]
    if kind == "literal_error":
        give = _meant(value, re.findall(r"'(\w+)'", context["expected"])) or give
    return f"{value!r} {what}", give


def _walk(model: type[Section], loc: Key) -> tuple[Any, type[Section] | None]:
    """The field that holds a location, and the section whose keys stand below it."""
    field: Any = None
    section: type[Section] | None = model
    named = False
    for part in loc:
        if named or section is None:
            named = False
            continue
        if part not in section.model_fields:
            return field, section
        field = section.model_fields[part]
        section, named = section_in(field.annotation), get_origin(field.annotation) in (dict, tuple)
    return field, section


def section_in(annotation: Any) -> type[Section] | None:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return annotation
    return next(filter(None, map(section_in, get_args(annotation))), None)


def _keys(model: type[Section], loc: Key) -> tuple[str, ...]:
    section = _walk(model, loc)[1]
    return tuple(section.model_fields) if section else ()


def _close(word: object, words: Iterable[object]) -> list[str]:
    return difflib.get_close_matches(str(word), map(str, words), n=1)


def _meant(word: object, words: Iterable[object]) -> str:
    return "".join(f"did you mean {close!r}?" for close in _close(word, words))


def _known(name: str, names: Collection[str], kind: str) -> None:
    if name not in names:
        raise Fault(f"{name!r} is not {kind}", _meant(name, names) or f"use one of {', '.join(names)}")


def check_parameters(model: str, parameters: Mapping[str, float], on: str = "") -> None:
    """Refuse parameters that are not exactly those of a model; `on` names the foundation in the message."""
    for name in parameters:
        _known(name, MODELS[model], f"a parameter of {model}")
    for name in MODELS[model]:
        if name not in parameters:
            raise Fault(f"{model}{on} has no {name}", f"give {name} or leave {model} out")
    if parameters.get("r", 0) > 1:
        raise Fault(f"r = {parameters['r']:g}{on} is above 1", "give r up to 1")


def _inside(file: str) -> str:
    if file.startswith("/") or ".." in PurePosixPath(file).parts or re.search(r"[\\:\x00-\x1f]", file):
        raise Fault(f"{file!r} is not inside the raw folder", "give a path below it, with / between folders")
    if re.search("[{}]", file):
        raise Fault(f"{file!r} has braces, which Snakemake takes for wildcards", "rename the file")
    return file
