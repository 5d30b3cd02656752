"""The keys of `foundations`, with their defaults."""

from freerock.config.values import Label, Number, Section, key


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
