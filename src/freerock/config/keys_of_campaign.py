"""The keys of a campaign's YAML file outside its groups, with their defaults.

The keys of each group, as `fits`, are in the module of its name, as `keys_of_fits`.
"""

import math
from typing import Annotated, Any, Literal

from pydantic import ValidationInfo, field_validator

from freerock.config import values
from freerock.config.figure_names import FIGURES, Figure
from freerock.config.keys_of_blocks import BlockSection
from freerock.config.keys_of_fits import FitsSection
from freerock.config.keys_of_foundations import FoundationSection
from freerock.config.keys_of_lasers import LaserSection
from freerock.config.keys_of_plan import PlanSection
from freerock.config.keys_of_processing import ProcessingSection
from freerock.config.keys_of_published import PublishedSection
from freerock.config.values import Folder, Invalid, Name, Once, Section, Text, key


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
    truth: str = key("the file of true values in the raw folder, of a simulated campaign", "")
    blocks: dict[Name, BlockSection] = key("one or more blocks, each by its name", min_length=1)
    foundations: dict[Name, FoundationSection] = key(
        "one or more foundations, each by its name", min_length=1
    )
    lasers: dict[Name, LaserSection] = key("one or more sensors, each by its name", min_length=1)
    figures: Annotated[tuple[Figure, ...], Once] = key(
        "the figures of the report; any other is drawn if it is the target of snakemake", FIGURES
    )
    processing: ProcessingSection = key("the steps from volts to impacts", ProcessingSection())
    fits: FitsSection = key("the identification of the models", FitsSection())
    published: PublishedSection | None = key(
        "values of a publication, printed beside the identified ones", None
    )
    plan: PlanSection | None = key("tests for which `freerock plan` predicts standard errors", None)

    @field_validator("figures")
    @classmethod
    def _in_order(cls, names: Any) -> Any:
        return tuple(sorted(names, key=FIGURES.index))

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

    @field_validator("truth")
    @classmethod
    def _truth_is_simulated(cls, truth: Any, info: ValidationInfo) -> Any:
        if truth and info.data.get("origin") == "measured":
            raise Invalid("a measured campaign has no known truth", "remove the key or set origin: simulated")
        return values.check_inside(truth) if truth else truth

    @field_validator("published")
    @classmethod
    def _published_is_configured(cls, published: Any, info: ValidationInfo) -> Any:
        if published is None:
            return published
        longest = ((block, [foundation]) for block, foundation in published.longest.items())
        for block, foundations in (*published.values.items(), *longest):
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
