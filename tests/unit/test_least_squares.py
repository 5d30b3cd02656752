"""Least squares from a start."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize

from freerock.config.fit_settings import FitSettings
from freerock.identification.least_squares import least_squares
from freerock.identification.problem import Problem
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.simulate import simulate_theta
from freerock.runs.motion import Motion

BLOCK = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
SIGMA = 1e-4


def problem(law):
    time_s = np.arange(0, 2, 2e-3)
    theta, _ = simulate_theta("hunt_crossley", BLOCK, {"k": 6.88e6, "lambda": 1.30e8}, time_s, theta0=0.17)
    noise = SIGMA * np.random.default_rng(1).standard_normal(time_s.size)
    motion = Motion(time_s, theta + noise, SIGMA, 0.17, SIGMA / 5, 5e-4)
    return posed(law, [BLOCK], [motion], FitSettings(free=("theta0", "t0")))


@pytest.mark.parametrize("ftol", [1e-3, 1e-7, 1e-13])
@pytest.mark.parametrize("law", ["winkler", "hunt_crossley"])
def test_it_ends_to_the_last_digit_where_scipy_does_with_derivatives_of_the_last_step(law, ftol, monkeypatch):
    """Also down to where the integrator's error leaves nothing to gain."""
    to_fit = problem(law)
    samples = to_fit.samples(m=8)
    start = to_fit.start(to_fit.fitted({"winkler": [5e6, 4e4], "hunt_crossley": [5e6, 1e8]}[law]))
    low, high = np.array(to_fit.bounds()).T
    inside = 1e-3 * (high - low)
    plain = optimize.least_squares(
        lambda x: to_fit.residual(x, samples),
        np.clip(start, low + inside, high - inside),
        lambda x: samples.averaged(to_fit.jacobian(x, samples)),
        (low, high),
        x_scale="jac",
        ftol=ftol,
        xtol=1e-9,
        gtol=None,
        max_nfev=60,
    )
    asked, jacobian = [], Problem.jacobian
    monkeypatch.setattr(
        Problem, "jacobian", lambda *given, **named: asked.append(1) or jacobian(*given, **named)
    )
    end = least_squares(to_fit, start, samples, ftol)
    np.testing.assert_array_equal(end.x, plain.x)
    assert end.evaluations == plain.nfev
    assert len(asked) == plain.njev - (plain.status in (2, 4))


def test_a_search_ends_where_nothing_depends_on_its_numbers():
    """At r = 0 the block rests before the first of these samples."""
    to_fit = replace(problem("housner"), r_low=0.0)
    samples = to_fit.samples()
    later = samples.time_s > 1.5
    samples = replace(
        samples, time_s=samples.time_s[later], theta=samples.theta[later], lengths=(int(later.sum()),)
    )
    end = least_squares(to_fit, np.array([0.0, 0.17, 0.0]), samples)
    np.testing.assert_allclose(end.x, [0.0, 0.17, 0.0], atol=2e-3)
    assert end.evaluations <= 2


def test_steps_below_what_a_float_tells_are_not_asked_for():
    to_fit = replace(problem("winkler"), stride=1e-8)
    samples = to_fit.samples(m=8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        end = least_squares(to_fit, to_fit.start(to_fit.fitted([5e6, 4e4])), samples)
    assert end.evaluations > 1
