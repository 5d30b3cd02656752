"""The keys of `uncertainty`: standard uncertainties (k = 1) of the laboratory's inputs, and their defaults.

The defaults are type B evaluations (JCGM 100:2008, 4.3.7) of plain instruments: a rule with 1 mm divisions,
1 mm/√12; a centre of mass found with it over an edge; a moment of inertia to 0.5 %, as some grams glued on
change it; gravity by latitude and altitude, from which it differs by some 50 mGal; a beam whose height is
read to ±1 mm, 1 mm/√3; a mass to 0.1 %; a triangulation sensor whose scale is linear to ±0.18 % of its
range, over √3; a quartz that is right to ±100 ppm, over √3. The effect of a sensor's response grows with
the square of its time; its mean over all times up to 5 ms is that of 5 ms/√3.
"""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationInfo, field_validator

from freerock.config.values import Invalid, Number, Section, key
from freerock.models.block import Block

LENGTH_M = 3e-4
RULE = f"{LENGTH_M:g} (a rule, 1 mm/√12)"
DEFAULTS = {
    **dict.fromkeys(["height_m", "width_m", "contact_width_m", "com_height_m", "com_offset_m"], LENGTH_M),
    "mass_fraction": 1e-3,
    "inertia_fraction": 5e-3,
    "gravity_m_s2": 5e-4,
    "position_m": 6e-4,
    "scale_fraction": 1e-3,
    "sampling_rate_fraction": 6e-5,
    "response_ms": 2.9,
    "response_fraction": 0.1,
}


def _known(of: str, by_default: str, **bounds: float) -> Any:
    """A field with an uncertainty of something, and its default in words."""
    return key(f"the uncertainty of {of}; by default {by_default}", None, ge=0, **bounds)


def stated_only_with(name: str, remedy: str) -> Any:
    """Validator of `uncertainty`: that of a key is stated only where the key is given."""

    def check(uncertainty: Any, info: ValidationInfo) -> Any:
        if getattr(uncertainty, name) is not None and info.data.get(name) is None:
            raise Invalid(f"states the uncertainty of a {name} that is not given", remedy)
        return uncertainty

    return field_validator("uncertainty")(check)


class BlockUncertainty(Section):
    """Standard uncertainties (k = 1) of a block."""

    height_m: Number | None = _known("its height in metres", RULE)
    width_m: Number | None = _known("its width in metres", RULE)
    contact_width_m: Number | None = _known("its contact width in metres, if stated", RULE)
    mass_kg: Number | None = _known("its mass in kilograms", "0.1 % of it (10 g of some kilograms)")
    com_height_m: Number | None = _known("the height of its centre of mass in metres", RULE)
    com_offset_m: Number | None = _known("its com_offset_m in metres", f"{RULE} if com_offset_m is stated")
    inertia_kg_m2: Number | None = _known(
        "its moment of inertia in kg m²", "0.5 % of it (some grams glued on)"
    )
    gravity_m_s2: Number | None = _known(
        "gravity_m_s2 in m/s²", "0.0005 (from latitude and altitude) if gravity_m_s2 is stated"
    )


class LaserUncertainty(Section):
    """Standard uncertainties (k = 1) of a sensor, common to all records that name it."""

    position_m: Number | None = _known(
        "the position of the beam in metres", "0.0006 (read to ±1 mm, over √3)"
    )
    scale_fraction: Number | None = _known(
        "its scale, as a share", "0.001 (linear to ±0.18 % of the range, over √3)", lt=1
    )
    sampling_rate_fraction: Number | None = _known(
        "the sampling rate, as a share", "6e-05 (a quartz of ±100 ppm, over √3)", lt=1
    )
    response_ms: Number | None = _known(
        "its response_ms", "2.9 (up to 5 ms, over √3), or 10 % of a stated one", le=100
    )


def inputs_of(
    block: tuple[str, Block], lasers: Mapping[str, Any], stated: Mapping[str, Mapping[str, float | None]]
) -> list[dict[str, Any]]:
    """What a record's numbers rest on, as `freerock.rotation.laboratory.Input` takes it: stated or default.

    Parameters
    ----------
    block : (str, Block)
        Its name and the block.
    lasers : mapping of str to LaserSection or Laser
        By name; the clock and the response are the first one's.
    stated : mapping of str to mapping of str to float or None
        Uncertainties of the keys of `uncertainty`, by the name of block or laser.
    """
    owner, shape = block
    response_ms = next(iter(lasers.values())).response_ms
    default = DEFAULTS | {"mass_kg": DEFAULTS["mass_fraction"] * shape.mass_kg}
    default |= {"inertia_kg_m2": DEFAULTS["inertia_fraction"] * shape.inertia_cm}
    default |= {"response_ms": DEFAULTS["response_fraction"] * response_ms or DEFAULTS["response_ms"]}
    assumed = "com_height_m", "inertia_kg_m2"  # those of a uniform block
    known = [
        (owner, name)
        for name in BlockUncertainty.model_fields
        if stated[owner].get(name) is not None or name in assumed or getattr(shape, name) is not None
    ]
    for i, (laser, each) in enumerate(lasers.items()):
        without = {"position_m"} if each.beam is None else set()
        without |= {"sampling_rate_fraction", "response_ms"} if i else set()
        known += [(laser, name) for name in LaserUncertainty.model_fields if name not in without]
    told = [(who, name, stated[who].get(name)) for who, name in known]
    return [
        {"owner": who, "name": name, "stated": u is not None, "u": default[name] if u is None else u}
        for who, name, u in told
    ]
