"""Predicted standard errors: against fits, their scatter, and the figures known."""

import math

import numpy as np
import pandas as pd
import pytest
from planned import campaign
from scipy.stats import chi2

from freerock.config.fit_settings import FitSettings
from freerock.config.keys_of_plan import SensorSection
from freerock.config.mistakes import ConfigError
from freerock.errors import FreerockError
from freerock.figures.plan_pages import draw
from freerock.figures.style import save
from freerock.identification.fit import fit_run
from freerock.models.simulate import Solver, simulate_theta
from freerock.planning.cramer_rao import standard_errors
from freerock.planning.plan import CASE_COLUMNS, COLUMNS, Choices, Setup, plan, sigma_theta_of
from freerock.planning.plan_campaign import plan_campaign
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.calibration import Calibration
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.runs.noise_spectrum import white_noise
from freerock.tables.plan_text import plan_text
from freerock.virtual_lab.palermo import CONFIGURATIONS

CONFIG1, CONFIG2, CONFIG3 = (CONFIGURATIONS[f"config{n}"][0] for n in (1, 2, 3))
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
TEN = math.radians(10)
SIGMA = math.radians(0.01)
TIME = np.arange(30, 4000) / 1000
KNOWN = white_noise(SIGMA, 1000.0)  # as the prediction takes it


def fitted(model, block, parameters, theta0, seed, time_s=TIME, noise=None, **options):
    theta, _ = simulate_theta(model, block, parameters, time_s, theta0=theta0, solver=Solver(1e-10))
    noisy = theta + np.random.default_rng(seed).normal(0, SIGMA, time_s.size)
    motion = Motion(time_s, noisy, SIGMA, theta0, 1e-3, 3e-3, noise=noise)
    return fit_run(model, block, motion, FitSettings(**options))


@pytest.mark.parametrize(
    "model, block, parameters, angle",
    [
        ("housner", CONFIG2, {"r": 0.9}, 10),
        ("winkler", CONFIG3, {"k": 6.77e6, "c": 2.17e4}, 20),
        ("hunt_crossley", CONFIG1, {"k": 2.86e6, "lambda": 8.16e7}, 6),
        ("hunt_crossley", CONFIG2, MARBLE, 10),
    ],
)
def test_prediction_is_what_a_fit_reports(model, block, parameters, angle):
    predicted = standard_errors(model, block, parameters, TIME, math.radians(angle), SIGMA)
    fit = fitted(model, block, parameters, math.radians(angle), seed=1, noise=KNOWN)
    assert fit.success, fit.message
    assert dict(zip(fit.parameters, fit.stderr, strict=True)) == pytest.approx(predicted, rel=0.01)


def test_prediction_is_the_scatter_of_fits():
    """Squared deviations of 40 fits over the predicted variance, within 99.9 % of their distribution.

    The fits see no rest: each takes the noise from its residual, in the mean as large as predicted.
    """
    runs, time_s = 40, TIME[:2000:2]
    truth = {**MARBLE, "theta0": TEN, "t0": 0.0}
    predicted = standard_errors("hunt_crossley", CONFIG2, MARBLE, time_s, TEN, SIGMA)
    fits = [fitted("hunt_crossley", CONFIG2, MARBLE, TEN, seed, time_s) for seed in range(runs)]
    low, high = chi2.ppf([0.0005, 0.9995], runs)
    for i, name in enumerate(fits[0].parameters):
        deviations = np.array([fit.value[i] - truth[name] for fit in fits]) / predicted[name]
        assert low < deviations @ deviations < high, name
        assert abs(deviations.mean()) < 3.3 / math.sqrt(runs), name
        assert np.mean([fit.stderr[i] for fit in fits]) == pytest.approx(predicted[name], rel=0.1), name


def test_known_bound():
    """0.014 % of k and 0.021 % of λ at 0.01°, 2 kHz, 8 s (docs/how-to/plan.md)."""
    time_s = np.arange(16000) / 2000
    found = standard_errors("hunt_crossley", CONFIG2, MARBLE, time_s, TEN, SIGMA)
    assert 100 * found["k"] / MARBLE["k"] == pytest.approx(0.014, abs=5e-4)
    assert 100 * found["lambda"] / MARBLE["lambda"] == pytest.approx(0.021, abs=5e-4)


def test_errors_grow_with_the_noise_with_fewer_samples_and_with_what_is_free():
    def errors(time_s=TIME, sigma=SIGMA, **options):
        return standard_errors("hunt_crossley", CONFIG2, MARBLE, time_s, TEN, sigma, **options)

    base = errors()
    assert errors(sigma=3 * SIGMA) == pytest.approx({name: 3 * value for name, value in base.items()})
    assert errors(TIME[::4]) == pytest.approx({name: 2 * value for name, value in base.items()}, rel=0.01)
    held = errors(free=())
    assert set(held) == {"k", "lambda"}
    assert all(held[name] < base[name] for name in held)


@pytest.mark.parametrize("face", ["left", "right"])
def test_noise_of_the_sensor_becomes_noise_of_the_rotation(face):
    laser = Laser("horizontal", 0.2, 0.1, face=face)
    around = displacement_from_rotation(TEN + np.array([-1e-6, 1e-6]), CONFIG2, laser)
    metres_per_rad = abs(np.diff(around)[0]) / 2e-6
    expected = 0.002 * 0.1 / 10 / metres_per_rad
    assert sigma_theta_of(SensorSection(noise_v=0.002), TEN, CONFIG2, laser) == (pytest.approx(expected), "")
    assert sigma_theta_of(SensorSection(noise_m=2e-5), TEN, CONFIG2, laser)[0] == pytest.approx(expected)
    assert sigma_theta_of(SensorSection(noise_deg=0.01), TEN, CONFIG2, laser)[0] == pytest.approx(SIGMA)
    halved = sigma_theta_of(SensorSection(noise_v=0.002, range_m=0.05), TEN, CONFIG2, laser)
    assert halved == (pytest.approx(expected / 2), "the target moves 69 mm, the range is 50 mm")
    assert sigma_theta_of(SensorSection(noise_v=0.002), TEN, CONFIG2, Laser("horizontal", 0.28, 0.1))[1] == (
        "the beam leaves the block"
    )


def test_noise_in_volts_needs_a_range():
    tabled = Laser("horizontal", 0.2, calibration=Calibration("voltage", (0, 10), (0, 0.1)))
    with pytest.raises(FreerockError) as caught:
        sigma_theta_of(SensorSection(noise_v=0.002), TEN, CONFIG2, tabled)
    assert str(caught.value) == (
        "plan.sensors: noise_v has no scale, as the laser has no range_m; "
        "give range_m or noise_m to the sensor"
    )
    scaled = sigma_theta_of(SensorSection(noise_v=0.002, range_m=0.1), TEN, CONFIG2, tabled)
    assert scaled == sigma_theta_of(SensorSection(noise_v=0.002), TEN, CONFIG2, Laser("horizontal", 0.2, 0.1))


def table(expected, angles=(10,), **options):
    setup = Setup(
        ("b", "f", "l"), Laboratory(CONFIG2, {"l": Laser("horizontal", 0.2, 0.1)}), expected, angles
    )
    return plan([setup, setup], Choices({"s": SensorSection(noise_v=0.002)}, **options))


def test_plan_has_a_row_per_case_and_parameter():
    frame = table(
        {"housner": {"r": 0.958}, "hunt_crossley": MARBLE},
        angles=(5, 10),
        sampling_rates_hz=(500, 1000),
        durations_s=(2, 4),
    )
    assert list(frame.columns) == COLUMNS
    assert len(frame) == 2 * 2 * 2 * 3
    assert not frame.duplicated([*CASE_COLUMNS, "parameter"]).any()
    assert (frame["note"] == "").all()
    case = frame[(frame["release_angle_deg"] == 10) & (frame["sampling_rate_hz"] == 1000)]
    case = case[(case["duration_s"] == 4) & (case["model"] == "hunt_crossley")].set_index("parameter")
    sigma = math.radians(case["sigma_theta_deg"].iloc[0])
    alone = standard_errors("hunt_crossley", CONFIG2, MARBLE, np.arange(30, 4001) / 1000, TEN, sigma)
    assert case["stderr"].to_dict() == pytest.approx({name: alone[name] for name in MARBLE})
    free = ("theta0", "t0", "tilt")
    time_s = np.arange(30, 4001) / 1000
    tilt = standard_errors("hunt_crossley", CONFIG2, MARBLE, time_s, TEN, sigma, free=free)["tilt"]
    assert case["tilt_stderr_deg"].to_numpy() == pytest.approx(math.degrees(tilt))
    fit = fitted("hunt_crossley", CONFIG2, MARBLE, TEN, 1, time_s, free=free)
    known = dict(zip(fit.parameters, fit.stderr, strict=True))["tilt"]
    assert known * sigma / SIGMA == pytest.approx(tilt, rel=0.05)
    low, high = frame["tilt_stderr_deg"].min(), frame["tilt_stderr_deg"].max()
    told = f"a base off level is told to ±{low:.1g} … {high:.1g}° by a fit that must find it"
    assert plan_text(frame).splitlines()[-1] == told


def test_plan_of_a_campaign_its_text_and_figure(tmp_path):
    lab = campaign(tmp_path)
    frame, rivals = plan_campaign(lab)[:2]
    assert set(rivals["model"]) == {"winkler", "hunt_crossley"}
    assert len(frame) == 3 * 2 * 2 * 5
    nominal = {name: block.release_angle_deg for name, block in lab.blocks.items()}
    assert (frame["release_angle_deg"] == frame["block"].map(nominal)).all()
    text = plan_text(frame, {"config1": "Slender"})
    assert text.startswith("Standard errors by noise alone in %, inputs exact, 2 s, 500 Hz\n")
    assert "Slender" in text and "config1" not in text
    cells = {line.split()[0]: line.split() for line in text.splitlines() if line.startswith("Slender")}
    first = frame[(frame["block"] == "config1") & (frame["parameter"] == "r")].iloc[0]
    assert f"{100 * first['stderr'] / first['value']:.2g}" in cells["Slender"]
    assert text.splitlines()[-1] == "config3 on aerstop from 20°: the target moves 68 mm, the range is 50 mm"
    pages, data = draw(frame)
    save(pages, data, tmp_path / "plan")
    assert len(pages) == 2
    assert len(pages[0].axes) == 2 * 5
    assert len(pd.read_csv(tmp_path / "plan.csv")) == len(frame)


def test_a_campaign_without_a_plan_is_refused(tmp_path):
    with pytest.raises(FreerockError, match=r"^campaign lab: plan: is missing; write what is expected"):
        plan_campaign(campaign(tmp_path, lambda keys: keys.pop("plan")))


MISTAKES = {
    "foundation without expectation": (
        lambda keys: keys["plan"]["expected"].pop("aerstop"),
        "plan: no parameters are expected of foundation 'aerstop'; add it to plan.expected",
    ),
    "unknown foundation": (
        lambda keys: keys["plan"]["expected"].update(marbel={"housner": {"r": 0.9}}),
        "plan: 'marbel' is not a foundation of this campaign; did you mean 'marble'?",
    ),
    "missing parameter": (
        lambda keys: keys["plan"]["expected"]["marble"]["winkler"].pop("c"),
        "plan.expected: winkler on marble has no c; give c or leave winkler out",
    ),
    "parameter of another model": (
        lambda keys: keys["plan"]["expected"]["marble"]["housner"].update(k=1e6),
        "plan.expected: 'k' is not a parameter of housner; use one of r",
    ),
    "no width": (
        lambda keys: keys["plan"]["expected"]["marble"].update(housner_width={"r": 0.95}),
        "plan.expected: housner_width on marble has no width_fraction; "
        "give width_fraction or leave housner_width out",
    ),
    "restitution above 1": (
        lambda keys: keys["plan"]["expected"]["marble"]["housner"].update(r=1.2),
        "plan.expected: r = 1.2 on marble is above 1; give r up to 1",
    ),
    "no noise": (
        lambda keys: keys["plan"]["sensors"].update(near={"range_m": 0.05}),
        "plan.sensors.near: has no noise; give one of noise_v, noise_m, noise_deg",
    ),
    "two noises": (
        lambda keys: keys["plan"]["sensors"].update(near={"noise_v": 0.002, "noise_m": 1e-5}),
        "plan.sensors.near: has noise_v and noise_m; give one of noise_v, noise_m, noise_deg",
    ),
    "beyond the critical angle": (
        lambda keys: keys["plan"].update(release_angles_deg={"config1": [6, 10]}),
        "plan: released at 10° config1 overturns, its critical angle is 9.462°; plan for smaller angles",
    ),
    "no release angle": (
        lambda keys: keys["blocks"]["config1"].pop("release_angle_deg"),
        "plan: block 'config1' has no release angle; add it to plan.release_angles_deg",
    ),
    "negative rate": (
        lambda keys: keys["plan"].update(sampling_rates_hz=[-500]),
        "plan.sampling_rates_hz.0: -500 is not greater than 0; give the sampling rates in hertz, one or more",
    ),
    "no duration": (
        lambda keys: keys["plan"].update(durations_s=[]),
        "plan.durations_s: is empty; give the durations of a run in seconds, one or more",
    ),
}


@pytest.mark.parametrize("change, line", MISTAKES.values(), ids=MISTAKES)
def test_mistakes_in_the_section_are_told_in_one_line(change, line, tmp_path):
    with pytest.raises(ConfigError) as caught:
        campaign(tmp_path, change)
    (message,) = str(caught.value).splitlines()
    assert message.partition(": ")[2] == line
