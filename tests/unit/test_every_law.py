"""Every law and every parameter of a law has its entry in each table and figure that lists them."""

from freerock.figures import parts, pulls
from freerock.models.laws import LAWS, PARAMETERS
from freerock.tables.candidates import MEDIANS

OF_LAWS = {name for law in LAWS.values() for name in law.parameters}


def test_a_law_has_known_parameters():
    assert set(PARAMETERS) >= OF_LAWS


def test_every_parameter_has_a_median_a_marker_and_a_hatch():
    for listed in (MEDIANS.values(), parts.LOOKS, pulls.HATCHES):
        assert set(listed) >= OF_LAWS
