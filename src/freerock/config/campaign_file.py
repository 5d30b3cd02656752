"""The keys of a campaign's YAML file, with those of `published` and `plan`."""

import math
from typing import Annotated, Any, Literal, Self

from pydantic import ValidationInfo, field_validator, model_validator

from freerock.config import values
from freerock.config.blocks import BlockSection, FoundationSection
from freerock.config.fit_settings import FitsSection
from freerock.config.lasers import LaserSection
from freerock.config.processing import ProcessingSection
from freerock.config.values import (
    Candidate,
    Folder,
    Invalid,
    Model,
    Name,
    Number,
    OneOrMore,
    Positive,
    Section,
    Text,
    check_names,
    check_parameters,
    key,
)
from freerock.models.laws import CANDIDATES, MODELS


class PublishedSection(Section):
    """Values of a publication, printed beside the identified ones."""

    doi: str = key("the DOI of the publication, as 10.…/…", pattern=r"^10\.\d{4,9}/\S+$", max_length=200)
    values: dict[Name, dict[Name, dict[Model, dict[str, Number]]]] = key(
        "block: foundation: model: parameter: value, in SI units; epsilon_theta as a fraction counts as a "
        "parameter"
    )

    @field_validator("values")
    @classmethod
    def _known_parameters(cls, values: Any) -> Any:
        for foundations in values.values():
            for models in foundations.values():
                for model, parameters in models.items():
                    check_names(parameters, (*MODELS[model], "epsilon_theta"), f"a parameter of {model}")
        return values


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


class CampaignFile(Section):
    """A test campaign: config/campaigns/<name>.yaml."""

    title: Text = key("the title of the campaign", min_length=1)
    origin: Literal["simulated", "measured"] = key(
        "simulated or measured, as shown in every dataset, table and figure"
    )
    summary: Text = key("what was tested, how and why, in a sentence or two", "")
    institution: Text = key("the laboratory", "")
    creator: Text = key("who made the records", "")
    license: Text = key("the licence of the records", "")
    references: Text = key("publications, as doi:10.…/…", "")
    raw: Folder = key("the folder of the record files; by default raw/<name of the campaign>", "")
    blocks: dict[Name, BlockSection] = key("one or more blocks, each by its name", min_length=1)
    foundations: dict[Name, FoundationSection] = key(
        "one or more foundations, each by its name", min_length=1
    )
    lasers: dict[Name, LaserSection] = key("one or more sensors, each by its name", min_length=1)
    processing: ProcessingSection = key("the steps from volts to impacts", ProcessingSection())
    fits: FitsSection = key("the identification of the models", FitsSection())
    published: PublishedSection | None = key(
        "values of a publication, printed beside the identified ones", None
    )
    plan: PlanSection | None = key("tests for which `freerock plan` predicts standard errors", None)

    @field_validator("blocks", "foundations")
    @classmethod
    def _labelled(cls, sections: Any, info: ValidationInfo) -> Any:
        first: dict[str, str] = {}  # name of each label
        for name, section in sections.items():
            if info.field_name == "foundations" and name in info.data.get("blocks", ()):
                raise Invalid(f"{name!r} is the name of a block already", "rename one of the two")
            other = first.setdefault(section.label or name, name)
            if other != name:
                what = f"{other!r} and {name!r} are both printed as {section.label or name!r}"
                raise Invalid(what, "give each its own label")
        return {name: s if s.label else s.model_copy(update={"label": name}) for name, s in sections.items()}

    @field_validator("published")
    @classmethod
    def _published_is_configured(cls, published: Any, info: ValidationInfo) -> Any:
        if published is None:
            return published
        for block, foundations in published.values.items():
            values.check_names([block], info.data.get("blocks", (block,)), "a block of this campaign")
            known = info.data.get("foundations", foundations)
            values.check_names(foundations, known, "a foundation of this campaign")
        return published

    @field_validator("plan")
    @classmethod
    def _plan_is_configured(cls, plan: Any, info: ValidationInfo) -> Any:
        if plan is None or not {"blocks", "foundations"} <= info.data.keys():
            return plan
        blocks, foundations = info.data["blocks"], info.data["foundations"]
        values.check_names(plan.expected, foundations, "a foundation of this campaign")
        for name in foundations:
            if name not in plan.expected:
                raise Invalid(f"no parameters are expected of foundation {name!r}", "add it to plan.expected")
        for name, angles in plan.release_angles_deg.items():
            values.check_names([name], blocks, "a block of this campaign")
            critical = math.degrees(blocks[name].block.theta_cr)
            if max(angles, default=0) >= critical:
                what = f"released at {max(angles):g}° {name} overturns, its critical angle is {critical:.3f}°"
                raise Invalid(what, "plan for smaller angles")
        for name, block in blocks.items():
            if not (plan.release_angles_deg.get(name) or block.release_angle_deg):
                raise Invalid(f"block {name!r} has no release angle", "add it to plan.release_angles_deg")
        return plan
