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
    lines = bits.markdown(frame).splitlines()
    assert [line.split(" | ")[1] for line in lines[2:]] == ["24", "10", "12"]


def test_the_table_counts_shares():
    """Of numbers that are made up."""
    rows = [
        {"bits": n, "sigma_mv": sigma, "record": i, "scene": "a", "level": "ok" if i or n > 8 else "fail"}
        | {"sigma_ratio": 1.0 if i else 1.2, "noise": True, "inside": bool(i)}
        for n in (8, 16)
        for sigma in (1.0, 5.0)
        for i in (0, 1)
    ]
    lines = bits.markdown(pd.DataFrame(rows).reindex(columns=bits.COLUMNS)).splitlines()
    assert lines[2] == "| 1 | 8 | 82 | 2 | 50 % | 50 % | 100 % | 100 % | 100 % |"
    assert lines[5] == "| 5 | 16 | 0.064 | 2 | 100 % | 0 % | 50 % | 100 % | 50 % |"
