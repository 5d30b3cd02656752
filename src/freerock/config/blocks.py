"""What blocks and foundations are: the keys of `blocks` and `foundations`."""

import math
from typing import Any

from pydantic import ValidationInfo, field_validator

from freerock.config.input_uncertainties import BlockUncertainty, stated_only_with
from freerock.config.values import Invalid, Label, Length, Number, Place, Positive, Section, key
from freerock.models.block import GRAVITY, IMPOSSIBLE, Block, density_if_square


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
    def shape(self) -> dict[str, Any]:
        """What `Block` takes, as plain values."""
        return self.model_dump(exclude={"label", "release_angle_deg", "uncertainty"})

    @property
    def block(self) -> Block:
        """The block as the models take it."""
        return Block(**self.shape)

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
            critical = math.degrees(Block(**info.data).theta_cr)  # what stands above is its shape
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
