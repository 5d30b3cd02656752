"""A record in one call gives what the workflow gives."""

from dataclasses import replace
from pathlib import Path

import lmfit
import numpy as np
import pytest

import freerock

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
FILE = ROOT / "raw/palermo_virtual/config2_marble.tdms"
BLOCK = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
LASER = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)


@pytest.fixture(scope="module")
def record():
    return freerock.load(FILE, BLOCK, LASER)


def test_a_run_is_fitted_with_its_noise_and_its_view(record):
    fit = record.runs[1].fit("hunt_crossley")
    assert fit.evidence.agrees and 0.9 < fit.evidence.residual_over_noise < 1.1
    assert fit.parameters == ("k", "lambda", "theta0", "t0")
    assert 0.005 < fit.scatter.of_record.sigma_r < 0.02


def test_a_wrong_law_has_an_honest_uncertainty_where_a_swing_just_lifts_the_block(record):
    """Within the step of c an impact begins to count: c would be known to 1e-7."""
    fit = freerock.fit_run("winkler", BLOCK, replace(record.runs[0].motion, laboratory=None))
    assert not fit.evidence.agrees
    assert dict(zip(fit.parameters, fit.u_total / fit.value, strict=True))["c"] > 0.01


def test_lmfit_goes_on_with_a_fit_whose_impacts_scatter(record):
    fit = record.runs[0].fit("hunt_crossley")
    assert fit.result.redchi == pytest.approx(1, abs=0.15)
    (_, low), _, (_, high) = lmfit.conf_interval(fit.minimizer, fit.result, ["k"], sigmas=[1])["k"]
    assert (high - low) / 2 == pytest.approx(fit.u_total[0], rel=0.1)


def test_where_a_number_is_held_off_its_end_the_others_start_beside_their_end(record, monkeypatch):
    fit, starts = record.runs[0].fit("hunt_crossley"), []
    monkeypatch.setattr(lmfit.Minimizer, "leastsq", lambda _, params, **options: starts.append(params))
    held = fit.params.copy()
    held["k"].set(value=held["k"].value + 0.3 * fit.u_total[0], vary=False)
    fit.minimizer.leastsq(held)
    left = np.sum(fit.minimizer.userfcn(starts[0]) ** 2) - fit.result.chisqr
    assert 0 < left < 2  # 0.09 but for curvature; with δ instead of the rates 1e5


def test_slow_noise_counts_once_in_the_statistics():
    block, laser = replace(BLOCK, height_m=0.42, mass_kg=8.67), replace(LASER, position_m=0.22)
    file = FILE.with_name("config1_aerstop.tdms")
    result = freerock.load(file, block, laser).runs[0].fit("hunt_crossley").result
    assert result.redchi == pytest.approx(1, abs=0.15) and result.ndata < 0.3 * len(result.residual)
    assert result.nfree == result.ndata - result.nvarys
    assert result.redchi == pytest.approx(np.sum(result.residual**2) / result.nfree)
    assert result.bic - result.aic == pytest.approx((np.log(result.ndata) - 2) * result.nvarys)


def test_a_law_that_is_wrong_has_no_interval_without_its_error(record):
    fit = record.runs[0].fit("housner")
    with pytest.raises(freerock.FreerockError, match=r"does not agree with the noise.*use u_total"):
        fit.conf_interval()


def test_a_rigid_block_with_exact_inputs_takes_no_restitution_that_its_impacts_undo(record):
    fit = freerock.fit_run("housner", BLOCK, replace(record.runs[0].motion, laboratory=None))
    assert fit.values["r"] == pytest.approx(0.96, abs=0.02) and fit.epsilon_theta < 0.1


def test_uncertainties_are_defaults_where_none_is_given():
    record = freerock.load(FILE, BLOCK, LASER, uncertainty={"mass_kg": 0.0, "height_m": 1e-3})
    told = {each.name: (each.u, each.stated) for each in record.runs[0].motion.laboratory.inputs}
    assert told["mass_kg"] == (0.0, True) and told["height_m"] == (1e-3, True)
    assert told["position_m"] == (6e-4, False)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"channel": "laser_2"}, "no channel 'laser_2'; its channels are laser"),
        ({"uncertainty": {"mass": 0.1}}, "unknown key 'mass'; use height_m"),
        (
            {"uncertainty": {"mass_kg": -0.1}},
            "mass_kg: -0.1 is no positive number; give it in kg",
        ),
    ],
)
def test_what_is_not_known_is_refused_in_a_line(given, message):
    with pytest.raises(freerock.FreerockError, match=message) as caught:
        freerock.load(FILE, BLOCK, LASER, **given)
    assert "\n" not in str(caught.value)


def test_block_and_laser_are_told_apart_and_no_usable_run_has_no_fit(record):
    with pytest.raises(freerock.FreerockError, match="block: Laser is no Block"):
        freerock.load(FILE, LASER, BLOCK)
    with pytest.raises(freerock.FreerockError, match="laser: dict is no Laser"):
        freerock.load(FILE, BLOCK, {"beam": "horizontal"})
    assert freerock.view_of(LASER, BLOCK) == freerock.view_of([LASER], BLOCK)
    assert freerock.fit_record("housner", BLOCK, {}) == {}
    with pytest.raises(freerock.FreerockError, match="'c' did not vary; use k, lambda"):
        record.runs[0].fit("hunt_crossley").conf_interval("c")


def test_results_are_opened_by_name(tmp_path):
    with pytest.raises(freerock.FreerockError, match="holds no tables and no records; run snakemake"):
        freerock.open_results(tmp_path)
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables/parameters.csv").write_text("test,run,value\n001,1,0.93\n")
    results = freerock.open_results(tmp_path)
    assert [*results.tables] == ["parameters"] and "choice" not in results.tables and not results.fits
    assert results.tables["parameters"].test.tolist() == ["001"]
    with pytest.raises(freerock.FreerockError, match="holds no 'choice'; it holds parameters"):
        results.tables["choice"]
