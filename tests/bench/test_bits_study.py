"""The study of converters of few bits."""

import numpy as np
import pandas as pd
import pytest

from freerock.figures.style import save
from freerock_bench import bits
from freerock_bench.figures.bits import draw


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


def test_the_figure_has_a_line_per_noise_over_the_step(tmp_path):
    """Of shares that are made up: their places are the steps, their heights the shares."""
    rows = [
        {"bits": n, "sigma_mv": sigma, "record": i, "scene": "a", "level": "ok" if i or n > 8 else "fail"}
        | {"sigma_ratio": 1.0 if i else 1.2, "noise": True, "inside": True}
        for n in (8, 12, 16)
        for sigma in (1.0, 5.0)
        for i in (0, 1)
    ]
    figure, data = draw(pd.DataFrame(rows).reindex(columns=bits.COLUMNS))
    ok, sigma, k = figure.axes
    assert [len(ax.lines) for ax in (ok, sigma)] == [2, 2] and len(k.lines) == 3
    np.testing.assert_allclose(ok.lines[0].get_xdata(), 21.0 / 2 ** np.array([8, 12, 16]) / 1e-3)
    np.testing.assert_allclose(ok.lines[0].get_ydata(), [50, 100, 100])
    np.testing.assert_allclose(sigma.lines[1].get_ydata(), [100, 50, 50])
    save(figure, data, tmp_path / "bits")
    assert len(pd.read_csv(tmp_path / "bits.csv")) == 6
