"""Restitution of each impact from true mechanical energies."""

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import fabricated
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import t

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import fit_record
from freerock.identification.model_discrepancy import Part, model_discrepancy
from freerock.jobs import make_fits
from freerock.models.block import GRAVITY
from freerock.models.contact import Foundation, State, accelerations, energy, static_depth
from freerock.models.published import TABLE_2
from freerock.models.simulate import simulate
from freerock.populations.impact_energy import _shifted, block_peaks, impact_energy
from freerock.populations.sensitivity import contributions
from freerock.products.runs import runs_in
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.u_total import Contributions
from freerock.rotation.view import view_of
from freerock.runs.impacts import find_impacts
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.virtual_run import Truth, virtual_motion

BLOCK, THETA0, _ = CONFIGURATIONS["config2"]
SIGMA = math.radians(0.01)
RATE_HZ = 2000.0


def by_another_engine(law, span_s=1.2, air_nms2=0.0):
    """θ(t), its impacts and the energies at its tops, by SciPy's DOP853 with the plain law of forces.

    Air, where there is some, is a moment against turning by the square of the rate.
    """
    return _by_another_engine(tuple(law.items()), span_s, air_nms2)


@cache
def _by_another_engine(law, span_s, air_nms2):
    foundation = Foundation.of(dict(law))

    def rates(_, state):
        drag = -air_nms2 * state[3] * abs(state[3])
        z_acceleration, acceleration = accelerations(BLOCK, foundation, State(*state), hand=drag)
        return [state[1], z_acceleration, state[3], acceleration]

    def passes(_, state):
        return state[2]

    def turns(_, state):
        return state[3]

    start = [static_depth(BLOCK, foundation, THETA0), 0.0, THETA0, 0.0]
    time_s = np.arange(0, span_s, 1 / RATE_HZ)
    options = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-12, "t_eval": time_s, "max_step": 2e-3}
    found = solve_ivp(rates, (0.0, span_s), start, events=(passes, turns), **options)
    impacts, states = found.t_events[0], found.y_events[1]
    instants = found.t_events[1]
    tops = [energy(BLOCK, foundation, *start)]
    for first, last in pairwise(impacts):
        (i,) = np.flatnonzero((instants > first) & (instants < last))
        tops.append(energy(BLOCK, foundation, *states[i]))
    return time_s, found.y[2], impacts, np.sqrt(np.array(tops[1:]) / tops[:-1])


@pytest.mark.parametrize("foundation", TABLE_2)
def test_a_motion_of_another_engine(foundation):
    """Its own energies within three standard errors, where a rigid block's are more than twenty off."""
    law = TABLE_2[foundation]["hunt_crossley"]
    time_s, theta, impacts, exact = by_another_engine(law)
    noise = SIGMA * np.random.default_rng(2).standard_normal(len(theta))
    run = Motion(time_s, theta + noise, SIGMA, THETA0, SIGMA / 30, 2e-4)
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    found = impact_energy(fit, BLOCK, impacts[: len(exact)])
    assert found.time_s == pytest.approx(impacts[: len(exact)], abs=2e-4)
    assert np.all(np.abs(found.restitution - exact) < 3 * found.stderr + 1e-6)
    rigid = find_impacts(time_s, theta, 0.0, BLOCK, theta0=THETA0).restitution[: len(exact)]
    assert np.all(rigid > found.restitution + 20 * found.stderr)


def test_a_law_that_lacks_something_is_as_uncertain_of_energies_as_its_parts_make_it():
    """A block in air, which takes from its energy: the law's is off by more than its noise, and says so."""
    law = TABLE_2["marble"]["hunt_crossley"]
    air = 0.01 * BLOCK.mass_kg * GRAVITY * BLOCK.b
    time_s, theta, impacts, exact = by_another_engine(law, 2.5, air)
    noise = SIGMA * np.random.default_rng(2).standard_normal(len(theta))
    run = Motion(time_s, theta + noise, SIGMA, THETA0, SIGMA / 30, 2e-4)
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    assert fit.diagnostics["noise"] == 0.0
    found = impact_energy(fit, BLOCK, impacts[: len(exact)])
    off = np.abs(found.restitution - exact)
    assert np.mean(off < 1.96 * found.stderr) < 0.5
    assert np.all(off < 1.96 * found.u_total)
    explained = replace(fit, discrepancy=np.zeros(len(fit.value)))
    without = impact_energy(explained, BLOCK, impacts[: len(exact)])
    np.testing.assert_array_equal(without.u_total[1:], without.stderr[1:])
    assert without.u_total[0] > without.stderr[0]  # by what a finger may have taken of the held block's
    np.testing.assert_array_equal(without.stderr, found.stderr)


def test_what_the_parts_say_of_energies_is_what_the_law_has_with_their_numbers():
    """Six parts that know the numbers alike: the root mean square of their energies, times Student's t."""
    law = TABLE_2["aerstop"]["hunt_crossley"]
    run = virtual_motion(Truth("hunt_crossley", BLOCK, law, THETA0, SIGMA), np.random.default_rng(1))
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    impacts = find_impacts(fit.time, fit.theta_model, 0.0, BLOCK, theta0=fit.values["theta0"]).time_s[:4]
    generator = np.random.default_rng(3)
    values = [fit.value * (1 + 1e-3 * generator.standard_normal(len(fit.value))) for _ in range(6)]
    parts = tuple(Part(i, i + 1.0, value, fit.stderr, fit.covariance) for i, value in enumerate(values))
    of_parts = model_discrepancy(fit.value, parts)
    found = impact_energy(replace(fit, parts=parts, discrepancy=of_parts), BLOCK, impacts)
    ends = [impact_energy(replace(fit, value=value), BLOCK, impacts).restitution for value in values]
    rms = np.sqrt(np.mean((np.array(ends) - found.restitution) ** 2, axis=0))
    expected = rms * t.ppf(0.975, 5) / 1.959964
    of_law = np.sqrt(found.u_total**2 - found.stderr**2)
    np.testing.assert_allclose(of_law, expected, rtol=0.02)
    # numbers that have a part of it alone, as beside an alternative, give as much to the energies
    less = impact_energy(replace(fit, parts=parts, discrepancy=0.3 * of_parts), BLOCK, impacts)
    np.testing.assert_allclose(np.sqrt(less.u_total**2 - less.stderr**2)[1:], 0.3 * of_law[1:], rtol=1e-6)


def test_no_bias_and_honest_errors_over_runs():
    block, theta0, _ = CONFIGURATIONS["config3"]
    truth = Truth("winkler", block, TABLE_2["marble"]["winkler"], theta0, SIGMA)
    scores = []
    for seed in range(30):
        run = virtual_motion(truth, np.random.default_rng(seed), still_s=(1.5, 1.5))
        fit = fit_record("winkler", block, [run], start=list(truth.parameters.values()))
        first = find_impacts(fit.time, fit.theta_model, 0.0, block, theta0=fit.values["theta0"]).time_s[:2]
        found = impact_energy(fit, block, first)
        values = np.array([*truth.parameters.values(), theta0, 0.0])
        exact = impact_energy(replace(fit, value=values), block, first)
        scores.append((found.restitution - exact.restitution) / found.stderr)
    assert abs(np.mean(scores)) < 4 / math.sqrt(30)
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.3


def test_what_the_width_is_off_moves_it_as_a_fit_with_another_width_would():
    law = TABLE_2["marble"]["hunt_crossley"]
    run = virtual_motion(Truth("hunt_crossley", BLOCK, law, THETA0, SIGMA), np.random.default_rng(1))
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    off = 5e-5
    laboratory = Laboratory(BLOCK, {"l": Laser(units="rad")}, (Input("block", "width_m", off, True),))
    known = contributions(fit, run, laboratory, FitSettings())
    impacts = find_impacts(fit.time, fit.theta_model, 0.0, BLOCK, theta0=fit.values["theta0"]).time_s[:4]
    found = impact_energy(replace(fit, contributions=known), BLOCK, impacts, laboratory=laboratory)
    of_width = np.sqrt(found.u_total**2 - found.stderr**2)
    wider = replace(BLOCK, width_m=BLOCK.width_m + off)
    other = impact_energy(fit_record("hunt_crossley", wider, [run], start=list(law.values())), wider, impacts)
    assert of_width == pytest.approx(np.abs(other.restitution - found.restitution), rel=0.2, abs=2e-6)


def test_a_number_that_the_motion_hardly_determines_stays_one():
    """Damping of nearly nothing, which an input's uncertainty moves by far more than itself."""
    law = TABLE_2["marble"]["hunt_crossley"]
    run = virtual_motion(Truth("hunt_crossley", BLOCK, law, THETA0, SIGMA), np.random.default_rng(1))
    fit = fit_record("general", BLOCK, [run], start=[law["k"], 1.0, law["lambda"]])
    inputs = (Input("block", "width_m", 5e-5, True),)
    laboratory = Laboratory(BLOCK, {"l": Laser(units="rad")}, inputs)
    shift = [-100 * value if name in ("k", "c") else 0.0 for name, value in fit.values.items()]
    far = replace(fit, contributions=Contributions.held(inputs, np.reshape(shift, (-1, 1))))
    impacts = find_impacts(fit.time, fit.theta_model, 0.0, BLOCK, theta0=fit.values["theta0"]).time_s[:4]
    found = impact_energy(far, BLOCK, impacts, laboratory=laboratory)
    assert np.all(found.u_total[np.isfinite(found.u_total)] > found.stderr[np.isfinite(found.u_total)])


def test_a_rigid_block_has_its_energies_from_its_heights():
    run = virtual_motion(Truth("housner", BLOCK, {"r": 0.95}, THETA0, SIGMA), np.random.default_rng(1))
    fit = fit_record("housner", BLOCK, [run], start=[0.95])
    with pytest.raises(ValueError, match="by energy is that from its peaks"):
        impact_energy(fit, BLOCK, [0.3])


def test_a_release_that_is_held_as_in_the_paper_has_energies():
    """No theta0 among the fitted numbers: the measured one counts."""
    time_s, theta, impacts, restitution = by_another_engine(TABLE_2["marble"]["hunt_crossley"])
    motion = Motion(time_s, theta, SIGMA, THETA0)
    fit = fit_record("hunt_crossley", BLOCK, [motion], FitSettings(free=()))
    assert fit.parameters == ("k", "lambda")
    found = impact_energy(fit, BLOCK, impacts)
    n = len(restitution)
    np.testing.assert_allclose(found.restitution[:n], restitution, atol=1e-3)
    assert np.all(np.isfinite(found.stderr[:n]))


def under_a_beam(position_m=0.2, sigma=0.0):
    """Laboratory, true motion of a block whose corner sinks, fit of what a beam shows, and its impacts."""
    law = TABLE_2["aerstop"]["hunt_crossley"]
    laser = replace(CONFIGURATIONS["config2"][2], position_m=position_m)
    time_s, view = np.arange(0, 1.2, 1 / RATE_HZ), view_of([laser], BLOCK)
    motion = simulate("hunt_crossley", BLOCK, law, time_s, theta0=THETA0)
    seen = view.seen(motion.theta[None], motion.z_cb[None], BLOCK, Foundation.of(law))
    noise, known = sigma * np.random.default_rng(4).standard_normal(len(seen)), sigma or SIGMA
    run = Motion(time_s, seen + noise, known, float(seen[0]), known / 30, 2e-4, view=view)
    fit = fit_record("hunt_crossley", BLOCK, [run], start=list(law.values()))
    at = {"theta0": run.theta0, "theta0_stderr": sigma / 30}
    impacts = find_impacts(time_s, run.theta, sigma, BLOCK, **at)
    return Laboratory(BLOCK, {"laser": laser}), motion, fit, impacts


@pytest.mark.parametrize("position_m", [0.2, 0.1])
def test_peaks_of_the_block_itself(position_m):
    """What a beam shows of a block whose corner sinks, turned back: r within its error, as r seen is not."""
    laboratory, motion, fit, impacts = under_a_beam(position_m, SIGMA / 10)
    found = block_peaks(fit, impacts, 0.0, laboratory)
    true = find_impacts(motion.time, motion.theta, 0.0, BLOCK, theta0=THETA0)
    assert found.peak_before[0] == pytest.approx(THETA0, abs=3e-6)
    for i in range(2):
        off = abs(found.restitution[i] - true.restitution[i])
        assert off < 3 * found.u_total[i]
        assert abs(impacts.restitution[i] - true.restitution[i]) > 3 * off
        assert found.peak_after[i] == pytest.approx(true.peak_after_rad[i], abs=5e-5)


def test_an_impact_left_out_by_hand_has_no_peaks_of_the_block_itself():
    laboratory, _, fit, impacts = under_a_beam()
    whole = block_peaks(fit, impacts, 0.0, laboratory)
    gone = replace(impacts, time_s=np.array([impacts.time_s[0], math.nan]))
    found = block_peaks(fit, gone, 0.0, laboratory)
    assert found.restitution[0] == pytest.approx(whole.restitution[0], abs=1e-9)
    assert math.isnan(found.restitution[1])


def test_inputs_reach_the_restitution_of_the_block_itself():
    """A beam 1 mm higher: by as much as reading the record anew with that beam."""
    plain, _, fit, impacts = under_a_beam()
    source = Input("laser", "position_m", 1e-3, True)
    laboratory = replace(plain, inputs=(source,))
    exact = replace(fit, stderr=np.zeros(len(fit.stderr)), discrepancy=np.zeros(len(fit.stderr)))
    held = Contributions.held((source,), np.zeros((len(fit.value), 1)))
    found = block_peaks(replace(exact, contributions=held), impacts, 0.0, laboratory)
    higher = laboratory.moved(source, 1.0)
    moved = block_peaks(exact, impacts, 0.0, higher, read_by=laboratory)
    assert found.u_total[:2] == pytest.approx(abs(moved.restitution - found.restitution)[:2], rel=0.05)


def test_inputs_shift_no_force_or_length_below_zero():
    """Edges that a run hardly determines: a corner of negative radius ended the job."""
    values = {"k": 1e6, "lambda": 1e7, "edge_radius": 1e-4, "theta0": 0.1}
    fit = SimpleNamespace(model="hunt_crossley", values=values)
    found = _shifted(fit, np.array([-2e6, 1e5, -1e-3, -0.2]))
    assert 0 < found["k"] < 1e6 and 0 < found["edge_radius"] < 1e-4
    assert found["lambda"] == 1.01e7 and found["theta0"] == pytest.approx(-0.1)


@pytest.mark.parametrize(("model", "energies"), [("housner", None), ("hunt_crossley", "found")])
def test_fits_of_a_foundations_law_alone_have_energies(model, energies, monkeypatch):
    monkeypatch.setattr(make_fits, "impact_energy", lambda *_, **__: "found")
    tree = fabricated.record(n_runs=1)
    fit = fabricated.fit(tree, model, runs_in(tree)[0], ())
    hypotheses = SimpleNamespace(settings=lambda model: FitSettings())
    found = make_fits._with_energies(fit, BLOCK, SimpleNamespace(view=None), None, hypotheses)
    assert found.energies == energies
