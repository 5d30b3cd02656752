import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from freerock.tables.number_text import quantity


@pytest.mark.parametrize(
    ("value", "stderr", "text"),
    [
        (0.957, 0.0012, "0.9570 ± 0.0012"),
        (6.88e6, 1.2e4, "(6.880 ± 0.012)·10⁶"),
        (6.88e6, math.nan, "6.88·10⁶"),
        (1.30e8, math.nan, "1.30·10⁸"),
        (0.958, math.nan, "0.958"),
        (-0.01234, 0.00098, "−0.01234 ± 0.00098"),
        (10.05, 0.0996, "10.05 ± 0.10"),
        (9.9996, math.nan, "10.0"),
        (4.2e-6, 1e-7, "(4.20 ± 0.10)·10⁻⁶"),
        (0.0, math.nan, "0.00"),
        (3.0, 40.0, "3 ± 40"),
        (7526.0, 2782.0, "(7.5 ± 2.8)·10³"),
        (7526.0, 82.4, "7526 ± 82"),
        (512.0, 140.0, "(5.1 ± 1.4)·10²"),
        (512.0, 95.0, "512 ± 95"),
        (512.0, 99.6, "(5.1 ± 1.0)·10²"),
        (40.0, 300.0, "40 ± 300"),
        (-8e-6, 4.035e-3, "0.0000 ± 0.0040"),
        (2.1e-5, 4.035e-2, "0.000 ± 0.040"),
        (math.nan, 0.1, "–"),
        (5.0, 0.0, "5.00"),
    ],
)
def test_quantity(value, stderr, text):
    assert quantity(value, stderr) == text


@given(st.floats(1e-12, 1e12), st.floats(1e-6, 0.5))
def test_quantity_is_off_by_less_than_a_tenth_of_its_uncertainty(value, relative):
    text = quantity(value, value * relative)
    body, _, power = text.partition("·10")
    digits = power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or "0"
    printed, error = (float(part) * 10.0 ** int(digits) for part in body.strip("()").split(" ± "))
    assert abs(printed - value) <= 0.06 * value * relative
    assert error == pytest.approx(value * relative, rel=0.06)
