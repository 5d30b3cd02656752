import base64

import numpy as np
import pytest
from fabricated import fits, record

from freerock.report.charts import BINS, MISSING, packed, run_curves


def test_curves_of_a_run_hold_its_highest_and_lowest_angle():
    tree = record()
    run = fits(tree)["run_1"]
    curves = run_curves(tree, 1, run)
    whole = np.frombuffer(base64.b64decode(curves["theta"]["measured"]["data"]), "<i2").astype(float)
    theta = np.where(whole == MISSING, np.nan, whole) * curves["theta"]["measured"]["scale"]
    measured = np.degrees(run["theta"].values)
    assert len(theta) <= 2 * BINS
    assert np.nanmax(theta) == pytest.approx(np.nanmax(measured), abs=1e-3)
    assert np.nanmin(theta) == pytest.approx(np.nanmin(measured), abs=1e-3)
    assert (
        list(curves["theta"]) == list(curves["rate"]) == ["measured", "housner", "winkler", "hunt_crossley"]
    )
    assert [len(each) for each in curves["impacts"].values()] == [4] * 4
    assert curves["impacts"]["measured"][0][:2] == pytest.approx([0.3, 0.94])


def test_packing_keeps_gaps_and_five_digits():
    values = np.array([1.0, np.nan, -20.0, 0.001])
    got = packed(values)
    whole = np.frombuffer(base64.b64decode(got["data"]), "<i2")
    assert whole[1] == MISSING
    np.testing.assert_allclose(whole[[0, 2, 3]] * got["scale"], values[[0, 2, 3]], atol=20 / 32000)
    assert packed(np.zeros(2))["scale"] == 1.0
