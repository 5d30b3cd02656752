"""Standard uncertainties (k = 1) of the laboratory's inputs, stated or by default.

The defaults are type B evaluations (JCGM 100:2008, 4.3.7) of plain instruments: a rule with 1 mm divisions,
1 mm/√12; a centre of mass found with it over an edge; a moment of inertia to 0.5 %, as some grams glued on
change it; gravity by latitude and altitude, from which it differs by some 50 mGal; a beam whose height is
read to ±1 mm, 1 mm/√3; a mass to 0.1 %; a triangulation sensor whose scale is linear to ±0.18 % of its
range, over √3; a quartz that is right to ±100 ppm, over √3. The effect of a sensor's response grows with
the square of its time; its mean over all times up to 5 ms is that of 5 ms/√3.
"""

from typing import Any

from freerock.config.values import NotNegative, Number, Section, key

RULE = "a rule, 1 mm/√12"
DEFAULTS = {
    **dict.fromkeys(["height_m", "width_m", "contact_width_m", "com_height_m", "com_offset_m"], 3e-4),
    "mass_fraction": 1e-3,
    "inertia_fraction": 5e-3,
    "gravity_m_s2": 5e-4,
    "position_m": 6e-4,
    "scale_fraction": 1e-3,
    "sampling_rate_fraction": 6e-5,
    "response_ms": 2.9,
    "response_fraction": 0.1,
}


def response_u_ms(response_ms: float) -> float:
    """Default uncertainty of a sensor's response [ms], of one that is given or of 0."""
    return DEFAULTS["response_fraction"] * response_ms or DEFAULTS["response_ms"]


def _known(of: str, name: str, instrument: str, lt: float | None = None) -> Any:
    """A field with an uncertainty of something, its default and the instrument that this is of."""
    text = f"the uncertainty of {of}; by default {DEFAULTS[name]:g} ({instrument})"
    return key(text, None, ge=0, lt=lt)


class BlockUncertainty(Section):
    """Standard uncertainties (k = 1) of a block."""

    height_m: Number | None = _known("its height in metres", "height_m", RULE)
    width_m: Number | None = _known("its width in metres", "width_m", RULE)
    contact_width_m: Number | None = _known("its contact width in metres, if stated", "contact_width_m", RULE)
    mass_kg: NotNegative | None = key(
        "the uncertainty of its mass in kilograms; by default "
        f"{100 * DEFAULTS['mass_fraction']:g} % of it (10 g of some kilograms)",
        None,
    )
    com_height_m: Number | None = _known("the height of its centre of mass in metres", "com_height_m", RULE)
    com_offset_m: NotNegative | None = key(
        "the uncertainty of its com_offset_m in metres; by default "
        f"{DEFAULTS['com_offset_m']:g} ({RULE}) if com_offset_m is stated",
        None,
    )
    inertia_kg_m2: NotNegative | None = key(
        "the uncertainty of its moment of inertia in kg m²; by default "
        f"{100 * DEFAULTS['inertia_fraction']:g} % of it (some grams glued on)",
        None,
    )
    gravity_m_s2: NotNegative | None = key(
        "the uncertainty of gravity_m_s2 in m/s²; by default "
        f"{DEFAULTS['gravity_m_s2']:g} (from latitude and altitude) if gravity_m_s2 is stated",
        None,
    )


class LaserUncertainty(Section):
    """Standard uncertainties (k = 1) of a sensor, common to all records that name it."""

    position_m: Number | None = _known(
        "the position of the beam in metres", "position_m", "read to ±1 mm, over √3"
    )
    scale_fraction: Number | None = _known(
        "its scale, as a share", "scale_fraction", "linear to ±0.18 % of the range, over √3", lt=1
    )
    sampling_rate_fraction: Number | None = _known(
        "the sampling rate, as a share", "sampling_rate_fraction", "a quartz of ±100 ppm, over √3", lt=1
    )
    response_ms: Number | None = key(
        "the uncertainty of its response_ms; by default "
        f"{DEFAULTS['response_ms']:g} (up to 5 ms, over √3), or "
        f"{100 * DEFAULTS['response_fraction']:g} % of a stated one",
        None,
        ge=0,
        le=100,
    )
