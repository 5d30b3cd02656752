"""The least-squares problem: samples, fitted numbers, derivatives."""

import math

import numpy as np
import pytest

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.problem import Samples
from freerock.identification.settings import check
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES
from freerock.models.simulate import Solver, simulate_theta
from freerock.runs.motion import Motion

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
TIME = np.arange(0, 2, 2e-3)
TRUTH = {
    "housner": [0.93],
    "winkler": [4.5e6, 4.05e4],
    "hunt_crossley": [6.88e6, 1.30e8],
    "general": [6e6, 1e4, 6e7],
}


def motion(model="hunt_crossley", fit_start_s=0.0, theta0=0.17):
    law = dict(zip({"housner": ["r"]}.get(model, ["k", "lambda"]), TRUTH[model], strict=True))
    theta, _ = simulate_theta(model, BLOCK, law, TIME, theta0=theta0)
    return Motion(TIME, theta, 1e-4, theta0, 2e-5, 2e-3, fit_start_s)


def problem(model="hunt_crossley", n_runs=1, **settings):
    return posed(model, [BLOCK] * n_runs, [motion()] * n_runs, FitSettings(**settings))


@pytest.mark.parametrize("model", TRUTH)
def test_fitted_numbers_are_the_parameters_in_another_unit(model):
    posed_for = problem(model, free=("width", "theta0", "t0"))
    x = posed_for.start(posed_for.fitted(TRUTH[model]))
    expected = [*TRUTH[model], 0.07, 0.17, 0.0]
    np.testing.assert_allclose(posed_for.physical(x), expected, rtol=1e-14)
    step = 1e-6 * np.eye(len(x))
    quotients = [(posed_for.physical(x + d) - posed_for.physical(x - d)) / 2e-6 for d in step]
    np.testing.assert_allclose(posed_for.gradient(x), np.transpose(quotients), rtol=1e-6, atol=1e-12)
    low, high = np.transpose(posed_for.bounds())
    assert np.all((low < x) & (x < high))
    assert not posed_for.at_bound(x).any()


def test_central_steps_make_no_edges_of_a_radius_below_zero():
    """Of a stiff bed and a small angle such edges bear nothing: a division by no length."""
    small = motion(theta0=9e-4)
    posed_for = posed("hunt_crossley", [BLOCK], [small], FitSettings(free=("edge_radius", "theta0", "t0")))
    values = {"k": 5e10, "lambda": 1e11, "edge_radius": 0.0, "theta0": 9e-4, "t0": 0.0}
    x, samples = posed_for.start_at(values), posed_for.samples()
    at = posed_for.names.index("edge_radius")
    x[at] = 0.0
    both = posed_for.jacobian(x, samples, central=True), posed_for.jacobian(x, samples)
    assert np.isfinite(both[0]).all()
    assert np.array_equal(both[0][:, at], both[1][:, at])
    assert not np.array_equal(both[0][:, 0], both[1][:, 0])


def test_runs_share_the_law_and_keep_their_own_release():
    joint = problem(n_runs=2, free=("theta0", "t0", "width"))
    assert joint.names == ("k", "lambda", "width", "theta0_1", "t0_1", "theta0_2", "t0_2")
    assert joint.alone().names == ("k", "lambda", "width", "theta0", "t0")
    x = joint.start(joint.fitted(TRUTH["hunt_crossley"]))
    x[joint.names.index("t0_2")] = 1e-3
    first, second = np.split(joint.curve(x, joint.samples()), 2)
    assert np.abs(first - motion().theta).max() < 1e-4
    assert np.abs(second - first).max() > 1e-3


def test_derivatives_are_those_of_the_curve():
    own = problem()
    x = own.start(own.fitted(TRUTH["hunt_crossley"]))
    samples = own.samples()
    jacobian = own.jacobian(x, samples, central=True)
    for j, step in enumerate((1e-4, 1e-4, 1e-5, 1e-5)):
        aside = step * np.eye(4)[j]
        quotient = own.curve(x + aside, samples, 1e-11) - own.curve(x - aside, samples, 1e-11)
        error = np.std(jacobian[:, j] - quotient / (2 * step))
        assert error < 0.01 * np.std(jacobian[:, j]), own.names[j]


@pytest.mark.parametrize("settings", [{}, {"parameters": {"general": {"k": {"max": 1e8}}}}], ids=str)
def test_a_damping_near_zero_moves_the_curve_by_as_much_per_unit(settings):
    """Of rounded edges the integrator errs most: it would hide steps that are a share of the damping."""
    own = posed("general", [BLOCK], [motion()], FitSettings(free=("edge_radius", "theta0", "t0"), **settings))
    columns = []
    for damping in (1e-2, 1e-3, 3e-5):  # of λ/k [s/m]
        x = own.start_at({"k": 6e6, "c": 1e4, "lambda": damping * 6e6, "edge_radius": 3.8e-3})
        columns.append(own.jacobian(x, own.samples(), central=True)[:, 2] / damping)
    for column in columns[1:]:
        assert np.std(column - columns[0]) < 0.1 * np.std(columns[0])


def test_the_runs_of_a_record_share_the_tilt_of_their_base():
    joint = problem(n_runs=2, free=("theta0", "t0", "tilt", "width"))
    assert joint.names[:4] == ("k", "lambda", "width", "tilt")
    x = joint.start(joint.fitted(TRUTH["hunt_crossley"]))
    assert abs(x[3]) < 1e-3  # as the swings on a level base have it
    x[3] = 2e-3
    first, second = np.split(joint.curve(x, joint.samples(), 1e-11), 2)
    values = {"k": 6.88e6, "lambda": 1.30e8, "tilt": 2e-3}
    tilted, _ = simulate_theta("hunt_crossley", BLOCK, values, TIME, theta0=0.17, solver=Solver(1e-11))
    np.testing.assert_allclose(first, tilted, atol=1e-9)
    assert np.array_equal(first, second)
    own = problem(free=("tilt",))
    x = own.start_at(values)
    samples = own.samples()
    column = own.jacobian(x, samples, central=True)[:, 2]
    step = np.array([0.0, 0.0, 1e-5])
    quotient = (own.curve(x + step, samples, 1e-11) - own.curve(x - step, samples, 1e-11)) / 2e-5
    assert np.std(column - quotient) < 0.01 * np.std(column)


def test_samples_start_when_the_finger_has_left_and_are_thinned():
    late = posed("hunt_crossley", [BLOCK], [motion(fit_start_s=0.5)], FitSettings())
    assert late.samples().time_s[0] == pytest.approx(0.5)
    assert late.samples(horizon_s=1.0).time_s[-1] == pytest.approx(1.0)
    assert late.samples(most=100).lengths[0] < 110


def test_averaging_keeps_the_noise_of_a_sample_and_mixes_no_runs():
    noise = np.random.default_rng(1).standard_normal(4000)
    samples = Samples(np.arange(4000.0), noise, (1999, 2001), m=10)
    means = samples.averaged(noise)
    assert len(means) == 199 + 200
    assert np.std(means) == pytest.approx(1, abs=0.15)
    assert means[199] == pytest.approx(math.sqrt(10) * noise[1999:2009].mean())


@pytest.mark.parametrize(
    ("model", "settings", "message"),
    [
        (
            "housner_width",
            {},
            "fits.free.housner: one width for several blocks; use housner",
        ),
        (
            "winkler_pivoting_width",
            {},
            "fits.free.winkler: one width for several blocks; use winkler_pivoting",
        ),
        (
            "winkler_pivoting",
            {"free": ("width",)},
            "fits.free.winkler: one width for several blocks; remove width",
        ),
        (
            "general_pivoting",
            {"debonding": "tensionless"},
            "fits.debonding: the tensionless rule is not available for c and lambda together; "
            "use geometric or remove general from fits.models",
        ),
        (
            "winkler_sliding",
            {},
            f"fits.models: unknown model 'winkler_sliding'; use one of {', '.join(CANDIDATES)}",
        ),
    ],
)
def test_what_a_candidate_cannot_be_fitted_to_is_told_in_the_words_of_the_configuration(
    model, settings, message
):
    other = Block(height_m=0.42, width_m=0.07, mass_kg=8.67)
    with pytest.raises(FreerockError) as error:
        check(model, [BLOCK, other], FitSettings(**settings))
    assert str(error.value) == message
