"""What a plan says of one run: against fits of it, their scatter, and refits in other laboratories."""

import math

import numpy as np
import pytest
from planned import campaign
from scipy.stats import chi2

from freerock.columns import columns_of
from freerock.config.campaign_file import SensorSection
from freerock.config.fit_settings import FitSettings
from freerock.config.mistakes import ConfigError
from freerock.errors import FreerockError
from freerock.identification.fit import fit_run
from freerock.identification.paper_fit import paper_fit
from freerock.models.simulate import Solver, simulate_fitted
from freerock.noise.spectrum import white_noise
from freerock.planning.bound import ExpectedRun, information_bound
from freerock.planning.plan import CASE_COLUMNS, plan, sigma_theta_of
from freerock.rotation.beam import displacement_from_rotation
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Calibration, Laser
from freerock.runs.motion import Motion
from freerock.tables.plan_text import plan_text
from freerock.virtual_lab.palermo import CONFIGURATIONS

CONFIG1, CONFIG2, CONFIG3 = (CONFIGURATIONS[f"config{n}"][0] for n in (1, 2, 3))
MARBLE = {"k": 6.88e6, "lambda": 1.30e8}
TEN = math.radians(10)
SIGMA = math.radians(0.01)
TIME = np.arange(30, 4000) / 1000
KNOWN = white_noise(SIGMA, 1000.0)  # as the prediction takes it
ANGLES = {"laser": Laser(units="rad")}  # the rotation is what is measured


def fitted(model, block, parameters, theta0, seed, time_s=TIME, noise=None, laboratory=None, **options):
    theta = simulate_fitted(model, block, {**parameters, "theta0": theta0}, time_s, solver=Solver(1e-10))
    noisy = theta + np.random.default_rng(seed).normal(0, SIGMA, time_s.size)
    motion = Motion(time_s, noisy, SIGMA, theta0, 1e-3, 3e-3, noise=noise, laboratory=laboratory)
    return fit_run(model, block, motion, FitSettings(**options))


def planned(model, block, parameters, theta0, time_s=TIME, inputs=(), free=("theta0", "t0")):
    """Standard uncertainties of the fitted numbers, and the covariance that they are of."""
    values = {**parameters, "theta0": theta0}
    run = ExpectedRun(model, values, Laboratory(block, ANGLES, inputs), free)
    found = information_bound(*run.derivatives(time_s), SIGMA)
    return dict(zip(run.names, np.sqrt(np.diag(found)), strict=False)), found


@pytest.mark.parametrize(
    "model, block, parameters, angle, free",
    [
        ("housner", CONFIG2, {"r": 0.9}, 10, ("theta0", "t0")),
        ("winkler", CONFIG3, {"k": 6.77e6, "c": 2.17e4}, 20, ("theta0", "t0")),
        ("hunt_crossley", CONFIG1, {"k": 2.86e6, "lambda": 8.16e7}, 6, ("theta0", "t0")),
        ("hunt_crossley", CONFIG2, MARBLE, 10, ("width", "theta0", "t0")),
    ],
)
def test_the_bound_is_what_a_fit_reports(model, block, parameters, angle, free):
    predicted, _ = planned(model, block, parameters, math.radians(angle), free=free)
    fit = fitted(model, block, parameters, math.radians(angle), seed=1, noise=KNOWN, free=free)
    assert fit.success, fit.message
    for name, stderr in zip(fit.values, fit.uncertainty.stderr, strict=True):
        assert 0.995 * predicted[name] < stderr < 1.08 * predicted[name], name


@pytest.mark.slow
def test_the_bound_is_the_scatter_of_fits():
    """Squared deviations of 40 fits over the predicted variance, within 99.9 % of their distribution."""
    runs, time_s = 40, TIME[:2000:2]
    truth = {**MARBLE, "theta0": TEN, "t0": 0.0}
    predicted, _ = planned("hunt_crossley", CONFIG2, MARBLE, TEN, time_s)
    fits = [fitted("hunt_crossley", CONFIG2, MARBLE, TEN, seed, time_s) for seed in range(runs)]
    low, high = chi2.ppf([0.0005, 0.9995], runs)
    for name in fits[0].values:
        deviations = np.array([fit.values[name] - truth[name] for fit in fits]) / predicted[name]
        assert low < deviations @ deviations < high, name


def test_known_bound():
    """0.014 % of k and 0.021 % of λ at 0.01°, 2 kHz, 8 s (computed with another program)."""
    found, _ = planned("hunt_crossley", CONFIG2, MARBLE, TEN, np.arange(16000) / 2000)
    assert 100 * found["k"] / MARBLE["k"] == pytest.approx(0.014, abs=5e-4)
    assert 100 * found["lambda"] / MARBLE["lambda"] == pytest.approx(0.021, abs=5e-4)


def test_what_the_samples_do_not_tell_has_no_number():
    before_the_impact = TIME[TIME < 0.2]
    assert math.isnan(planned("housner", CONFIG2, {"r": 0.9}, TEN, before_the_impact)[0]["r"])
    assert math.isnan(planned("housner", CONFIG2, {"r": 0.9}, TEN, TIME[:3])[0]["r"])


INPUTS = tuple(Input("b", name, 3e-4, True) for name in ("width_m", "height_m"))
INPUTS += (Input("laser", "scale_fraction", 1e-3, True), Input("laser", "sampling_rate_fraction", 6e-5, True))


@pytest.mark.parametrize(
    ("model", "values"),
    [("hunt_crossley", {"k": 2.86e6, "lambda": 8.16e7}), ("winkler", {"k": 4e6, "c": 2e4})],
)
def test_the_total_is_what_fits_with_uncertain_inputs_scatter_by(model, values):
    """Linear fits with priors, of runs whose inputs are drawn."""
    run = ExpectedRun(model, {**values, "theta0": TEN}, Laboratory(CONFIG2, ANGLES, INPUTS), ("theta0", "t0"))
    by_numbers, by_inputs = run.derivatives(TIME)
    draw, many = np.random.default_rng(3), 4000
    rows = np.vstack([np.hstack([by_numbers, by_inputs]) / SIGMA, np.eye(len(INPUTS), 4 + len(INPUTS), 4)])
    weights = np.linalg.pinv(rows / (scale := np.linalg.norm(rows, axis=0)))[:2] / scale[:2, None]
    off = draw.standard_normal((len(INPUTS), many))
    seen = by_inputs / SIGMA @ off + draw.standard_normal((len(TIME), many))
    found = np.sqrt(np.diag(information_bound(by_numbers, by_inputs, SIGMA)))[:2]
    np.testing.assert_allclose((weights[:, : len(TIME)] @ seen).std(axis=1), found, rtol=0.05)


@pytest.mark.parametrize("name", ["width_m", "scale_fraction", "sampling_rate_fraction"])
def test_derivatives_by_inputs_are_those_of_a_laboratory_that_is_wrong_by_them(name):
    """A fit of a run whose input is off: the numbers move as the linear model has it."""
    values, u = {"k": 2.86e6, "lambda": 8.16e7}, {"width_m": 3e-5, "scale_fraction": 1e-4}.get(name, 6e-5)
    source = Input("b" if name == "width_m" else "laser", name, u, True)
    laboratory = Laboratory(CONFIG2, ANGLES, (source,))
    run = ExpectedRun("hunt_crossley", {**values, "theta0": TEN}, laboratory, ("theta0", "t0"))
    by_numbers, by_input = run.derivatives(TIME)
    scale = np.linalg.norm(by_numbers, axis=0)
    shift = np.linalg.lstsq(by_numbers / scale, by_input[:, 0], rcond=None)[0] / scale
    true = laboratory.moved({source: 1.0})
    theta = simulate_fitted(
        "hunt_crossley", true.block, {**values, "theta0": TEN}, TIME * true.clock, solver=Solver(1e-10)
    )
    motion = Motion(TIME, true.reread(theta, laboratory), 1e-6, TEN, 1e-3, 3e-3)
    fit = paper_fit("hunt_crossley", CONFIG2, motion)  # neither inputs nor impacts move
    moved = {n: v - values[n] for n, v in fit.values.items() if n in values}
    assert moved["k"] == pytest.approx(shift[0], rel=0.1)
    assert moved["lambda"] == pytest.approx(shift[1], rel=0.1)


def test_the_input_that_matters_most_is_the_one_without_which_u_is_least(tmp_path):
    row = one_case(tmp_path).set_index("parameter").loc["k"]
    assert row["u_total"] > row["stderr"] > 0
    exact = {
        name: one_case(tmp_path, name).set_index("parameter").loc["k", "u_total"]
        for name in ("width_m", "height_m", "mass_kg", "inertia_kg_m2")
    }
    first = row["first_input"]
    assert first == min(exact, key=exact.get) and row["first_owner"] == "config2"
    assert row["first_share"] == pytest.approx(1 - (exact[first] / row["u_total"]) ** 2, abs=1e-6)


def one_case(tmp_path, exact=None):
    """Hunt–Crossley on marble, one block and sensor, with an input of the block exact."""

    def change(keys):
        keys["plan"]["expected"] = {name: {"hunt_crossley": MARBLE} for name in keys["foundations"]}
        keys["plan"]["sensors"] = {"s": {"noise_v": 0.002}}
        if exact:
            keys["blocks"]["config2"].setdefault("uncertainty", {})[exact] = 0.0

    frame = plan(campaign(tmp_path, change))
    return frame[(frame["block"] == "config2") & (frame["foundation"] == "marble")]


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


def test_a_record_of_rotations_is_planned_by_the_noise_of_the_rotation():
    rotation = Laser(units="deg")
    assert sigma_theta_of(SensorSection(noise_deg=0.01), TEN, CONFIG2, rotation) == (pytest.approx(SIGMA), "")
    with pytest.raises(FreerockError, match="the records hold the rotation itself; give noise_deg"):
        sigma_theta_of(SensorSection(noise_v=0.002), TEN, CONFIG2, rotation)


def test_plan_of_a_campaign_and_its_text(tmp_path):
    lab = campaign(tmp_path)
    frame = plan(lab)
    assert list(frame.columns) == columns_of("plan") and len(frame) == 3 * 2 * 2 * 5
    assert not frame.duplicated([*CASE_COLUMNS, "parameter"]).any()
    nominal = {name: block.release_angle_deg for name, block in lab.blocks.items()}
    assert (frame["release_angle_deg"] == frame["block"].map(nominal)).all()
    text = plan_text(frame, {"config1": "Slender"}).splitlines()
    line = next(line for line in text if "Hunt–Crossley k" in line and "Slender" in line)
    k = frame[(frame["block"] == "config1") & (frame["foundation"] == "marble") & (frame["parameter"] == "k")]
    best = k[k["model"] == "hunt_crossley"].sort_values("u_total").iloc[0]
    for error in (best["stderr"], best["u_total"]):
        assert f" {100 * error / best['value']:.2g} " in line
    assert text[-1] == "config3 on aerstop from 20°: the target moves 68 mm, the range is 50 mm"


def test_what_cannot_be_had_is_said(tmp_path):
    def expect(values, duration):
        def change(keys):
            keys["plan"] |= {"expected": {name: values for name in keys["foundations"]}}
            keys["plan"] |= {"durations_s": [duration]}

        frame = plan(campaign(tmp_path, change))
        assert frame[["stderr", "u_total"]].isna().all(axis=None)
        return plan_text(frame).splitlines()

    soft = expect({"hunt_crossley": {"k": 1e4, "lambda": 1e5}}, 2)
    assert "config1 on marble from 6°: hunt_crossley released at 6°: overturned" in soft
    short = expect({"housner": {"r": 0.958}}, 0.2)
    assert "config1 on marble from 6°: not determined by such a run" in short


def test_each_laser_of_a_record_with_two_is_planned_alone(tmp_path):
    lab = campaign(tmp_path)
    both = lab.records[0].model_copy(update={"laser": "at_220mm; at_200mm"})
    assert {*plan(lab.model_copy(update={"records": (both,)}))["laser"]} == {"at_220mm", "at_200mm"}


def test_a_freed_width_is_that_of_the_worn_block(tmp_path):
    def change(keys):
        worn = {"housner_width": {"r": 0.95, "width_fraction": 0.9}}
        keys["plan"]["expected"] = {name: worn for name in keys["foundations"]}

    frame = plan(campaign(tmp_path, change))
    values = frame[frame["block"] == "config2"].drop_duplicates("parameter").set_index("parameter")["value"]
    assert values.to_dict() == pytest.approx({"r": 0.95, "width": 0.9 * CONFIG2.width_m})


def test_a_campaign_without_a_plan_is_refused(tmp_path):
    with pytest.raises(FreerockError, match=r"^campaign lab: plan: is missing; write what is expected"):
        plan(campaign(tmp_path, lambda keys: keys.pop("plan")))


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
