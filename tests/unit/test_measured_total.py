"""Total uncertainty of release angle, peaks and restitutions: the record analysed with an input moved."""

import math
from dataclasses import replace

import numpy as np
import pytest

from freerock.models.block import Block
from freerock.models.simulate import Solver, simulate_fitted
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.runs.impacts import Impacts, find_impacts
from freerock.runs.runs import measured, on_one_bed
from freerock.runs.u_of_measured import measured_contributions, measured_total
from freerock.virtual_lab.virtual_record import VirtualRelease, simulate_record

BLOCK = Block(0.28, 0.07, 5.84)
THETA0 = math.radians(8)
NEAR, LOW = Laser("horizontal", 0.2, 0.1), Laser("horizontal", 0.08, 0.1)
INPUTS = {
    "height_m": Input("b", "height_m", 3e-4, False),
    "width_m": Input("b", "width_m", 3e-4, False),
    "mass_kg": Input("b", "mass_kg", 0.00584, False),
    "position_m": Input("l", "position_m", 6e-4, True),
    "scale_fraction": Input("l", "scale_fraction", 1e-3, False),
    "sampling_rate_fraction": Input("l", "sampling_rate_fraction", 6e-5, False),
}
LASERS = {
    "face": {"l": NEAR},
    "outrigger": {"l": Laser("vertical", -0.2, 0.1)},
    "two": {"l": NEAR, "m": LOW},
}


def volts_of(lasers):
    """A record of each laser, of one motion: a rigid block in little noise of each laser's own."""
    releases = [VirtualRelease(THETA0, {"r": 0.9})]
    made = [
        simulate_record(BLOCK, laser, "housner", releases, seed=seed)
        for seed, laser in enumerate(lasers.values(), 3)
    ]
    return made[0].time_s, [each.volts for each in made]


def analysed(time_s, volts, laboratory):
    """Release angle, its error and the impacts of the run, by the chain of signals with these numbers."""
    lasers = [
        replace(laser, range_m=laser.range_m * scale)
        for laser, scale in zip(laboratory.lasers.values(), laboratory.scales, strict=False)
    ]
    record = find_rotation(time_s * laboratory.clock, volts, lasers, laboratory.block)
    found = measured(record, laboratory.block)
    return found.runs[0], found.impacts[0]


def numbers(run, impacts):
    return np.concatenate(
        [[run.theta0], impacts.peak_before_rad, impacts.peak_after_rad, impacts.restitution]
    )


@pytest.mark.slow
@pytest.mark.parametrize("beam", LASERS)
def test_contributions_are_those_of_the_record_analysed_with_the_input_moved(beam):
    """Within 2 %, or of what hardly counts 5 % of the standard error, which the windows of the peaks move."""
    laboratory = Laboratory(BLOCK, LASERS[beam], tuple(INPUTS.values()))
    time_s, volts = volts_of(laboratory.lasers)
    run, impacts = analysed(time_s, volts, laboratory)
    stderr = np.concatenate(
        [
            [run.theta0_stderr],
            impacts.peak_before_stderr_rad,
            impacts.peak_after_stderr_rad,
            impacts.restitution_stderr,
        ]
    )
    shifts = measured_contributions(run.theta0, impacts, laboratory)
    for source, shift in zip(laboratory.inputs, shifts.T, strict=True):
        ends = [
            numbers(*analysed(time_s, volts, laboratory.moved({source: side})))[: len(shift)]
            for side in (1, -1)
        ]
        expected = (ends[0] - ends[1]) / 2
        assert np.all(np.abs(shift - expected) < 0.02 * np.abs(expected) + 0.05 * stderr)


@pytest.mark.parametrize("lean_deg", [0.05, -0.1])
def test_a_base_off_level_counts_as_in_the_motion_on_it(lean_deg):
    """r of a rigid block on a base that leans, taken for level: the tilt contributes what it is off."""
    time_s = np.arange(0, 4.0, 5e-4)
    law = {"r": 0.92, "tilt": math.radians(lean_deg)}
    theta = simulate_fitted("housner", BLOCK, {**law, "theta0": THETA0}, time_s, solver=Solver(1e-11))
    impacts = find_impacts(time_s, theta, 0.0, BLOCK, theta0=THETA0)
    laboratory = Laboratory(BLOCK, {"l": Laser(units="rad")}, (Input("f", "levelled_deg", 0.01, True),))
    shift = measured_contributions(THETA0, impacts, laboratory)[-len(impacts.time_s) :, 0]
    high = np.abs(impacts.peak_before_rad) > math.radians(3)
    assert np.all(np.abs(impacts.restitution - 0.92)[high] > 1e-3)
    assert (impacts.restitution + shift * lean_deg / 0.01)[high] == pytest.approx(0.92, abs=1e-4)


def test_the_total_is_a_root_sum_of_squares_and_without_inputs_the_noise():
    time_s = np.arange(0, 4.0, 5e-4)
    theta = simulate_fitted("housner", BLOCK, {"r": 0.92, "theta0": THETA0}, time_s)
    theta = theta + 1e-4 * np.random.default_rng(1).standard_normal(theta.size)
    impacts = find_impacts(time_s, theta, 1e-4, BLOCK, theta0=THETA0, theta0_stderr=1e-5)
    known = measured_total(THETA0, 1e-5, impacts, Laboratory(BLOCK, {"l": NEAR}))
    assert known.theta0 == 1e-5
    np.testing.assert_array_equal(known.restitution, impacts.restitution_stderr)
    two = Laboratory(BLOCK, {"l": NEAR}, (INPUTS["width_m"], INPUTS["position_m"]))
    known, shifts = (
        measured_total(THETA0, 1e-5, impacts, two),
        measured_contributions(THETA0, impacts, two),
    )
    n = len(impacts.time_s)
    squares = impacts.restitution_stderr**2 + np.sum(shifts[-n:] ** 2, axis=1)
    np.testing.assert_allclose(known.restitution, np.sqrt(squares), rtol=1e-12)
    assert known.theta0 == pytest.approx(THETA0 * 6e-4 / 0.2, rel=0.05)  # that of the beam's height
    assert known.peak_before[0] == pytest.approx(known.theta0, rel=1e-9)


def test_it_holds_where_the_inputs_are_wrong_by_what_is_stated_of_them():
    """A rigid block of other sides under another beam than stated: true r and θ₀ inside ± 1.96 u in 95 %."""
    time_s, generator, inside = np.arange(0, 1.5, 5e-4), np.random.default_rng(7), []
    known = tuple(INPUTS[name] for name in ("height_m", "width_m", "position_m", "scale_fraction"))
    for _ in range(300):
        stated = true = Laboratory(BLOCK, {"l": NEAR}, known)
        for source in known:
            true = true.moved({source: float(generator.standard_normal())})
        theta = simulate_fitted("housner", true.block, {"r": 0.9, "theta0": THETA0}, time_s)
        theta = true.reread(theta, stated) + 1e-4 * generator.standard_normal(theta.size)
        held = float(true.reread(np.array([THETA0]), stated)[0])
        impacts = find_impacts(time_s, theta, 1e-4, BLOCK, theta0=held, theta0_stderr=1e-6)
        total = measured_total(held, 1e-6, impacts, stated)
        scores = np.append((impacts.restitution - 0.9) / total.restitution, (held - THETA0) / total.theta0)
        inside.append(np.abs(scores[[0, 1, -1]]) < 1.96)
        assert total.restitution[0] > 5 * impacts.restitution_stderr[0]
    assert np.all(np.abs(np.mean(inside, axis=0) - 0.95) < 0.038)  # three standard deviations of 300 draws


def test_a_run_whose_tail_does_not_show_the_bed_has_that_of_the_others():
    none = [np.empty(0)] * 8
    found = on_one_bed([Impacts(*none, theta_uplift=each) for each in (3e-3, 0.0, 1e-3)])
    assert [each.theta_uplift for each in found] == [3e-3, 2e-3, 1e-3]
    assert on_one_bed([Impacts(*none, theta_uplift=0.0)])[0].theta_uplift == 0
