"""The study of converters of few bits."""

import pandas as pd
import pytest

from freerock_bench import bits


@pytest.fixture(scope="module")
def frame():
    cases = [(24, 1.0, 1), (12, 2.0, 1), (10, 2.0, 1)]
    return pd.DataFrame([row for case in cases for row in bits.rows_of(case)], columns=bits.COLUMNS)


def test_a_step_of_ten_sigma_leaves_a_clean_run_ok(frame):
    """σ counts the error of rounding; k stays within four standard errors of the truth."""
    assert list(frame["level"]) == ["ok"] * 3
    assert (frame["sigma_ratio"] - 1).abs().max() < 2 * bits.ALIKE
    assert (frame["error"] / frame["stderr"]).abs().max() < 4


def test_the_table_has_a_row_per_noise_and_converter(frame):
    data = bits.told(frame)
    assert list(data["bits"]) == [24, 10, 12] and list(data["ok"]) == [100.0] * 3
    assert len(bits.markdown(frame).splitlines()) == 2 + 3
