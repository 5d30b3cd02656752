"""A record in one call gives what the steps of the workflow give."""

from pathlib import Path

import numpy as np
import pytest

import freerock

FILE = Path(__file__).parents[2] / "raw/palermo_virtual/config2_marble.tdms"
BLOCK = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
LASER = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)


@pytest.fixture(scope="module")
def record():
    return freerock.load(FILE, BLOCK, LASER)


def test_the_rotation_and_the_runs_are_those_of_the_steps(record):
    read = freerock.read_record(FILE)["laser"]
    data = freerock.find_rotation(read["time"].values, read.values, LASER, BLOCK, read.units)
    np.testing.assert_array_equal(record.theta, data["theta"])
    names = ("time", "theta", "sigma_theta", "flags")
    found = freerock.find_runs(*(data[name].values for name in names), BLOCK)
    assert [run.found.release_s for run in record.runs] == pytest.approx([run.release_s for run in found])


def test_a_run_is_fitted_with_its_noise_and_its_view(record):
    fit = record.runs[1].fit("hunt_crossley")
    assert fit.evidence.agrees and 0.9 < fit.evidence.residual_over_noise < 1.1
    assert fit.parameters == ("k", "lambda", "theta0", "t0")
    assert 0.005 < fit.scatter.of_record.sigma_r < 0.02


def test_a_wrong_law_has_an_honest_uncertainty_where_a_swing_just_lifts_the_block(record):
    """Within the step of c an impact begins to count: c would be known to 1e-7."""
    fit = record.runs[0].fit("winkler")
    assert not fit.evidence.agrees
    assert dict(zip(fit.parameters, fit.u_total / fit.value, strict=True))["c"] > 0.01


def test_a_channel_that_is_not_there_is_refused():
    with pytest.raises(freerock.FreerockError, match="name one of laser"):
        freerock.load(FILE, BLOCK, LASER, "laser_2")
