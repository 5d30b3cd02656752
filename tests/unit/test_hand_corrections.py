"""Runs set by hand and what is left out: cells read and written again, what they do, what can't be done."""

import math
from functools import cache

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from test_runs import one_run, record

from freerock.config.correction_cells import (
    Override,
    read_overrides,
    written_overrides,
)
from freerock.config.processing import RunLimits
from freerock.runs.beginning import begun_by_hand
from freerock.runs.hand_corrections import ByHand
from freerock.runs.impacts import IMPACT_COLUMNS
from freerock.runs.runs import find_runs, measured
from freerock.runs.signal import signal_of

WHY = "why"


@st.composite
def cells(draw):
    """Runs in order, as a cell may set them, with times of any digits."""
    times = sorted(
        draw(st.sets(st.floats(0, 1e6, allow_subnormal=False).map(lambda t: round(t, 9)), min_size=4))
    )
    runs = [times[i : i + 4] for i in range(0, len(times) - 3, 4)]
    return tuple(
        Override(number, release, end, hold_s=(start, until) if draw(st.booleans()) else None)
        for number, (start, until, release, end) in enumerate(runs, 1)
    )


@given(cells())
def test_a_cell_is_written_as_it_was_read(runs):
    assert read_overrides(written_overrides(runs)) == runs


@cache
def three():
    """Arguments of find_runs for a record of three runs, their releases [s], and the runs as found."""
    arguments, releases = record(one_run(), one_run(-9.0), one_run(8.0))
    return arguments, releases, find_runs(*arguments)


def by_hand(arguments, *overrides, exclusions=()):
    """The runs that are found with such overrides."""
    return find_runs(
        *arguments, by_hand=ByHand([(*each[:3], WHY, *each[3:]) for each in overrides], exclusions)
    )


def hidden(arguments, release, hold_s=1.4):
    """What lies above 3°, from before a hold until shortly after its release, is not seen."""
    beyond = (arguments[0] > release - hold_s - 1.6) & (arguments[0] < release + 0.1)
    time, theta, sigma, flags, block = arguments
    return time, theta, sigma, np.where(beyond & (np.abs(theta) > math.radians(3)), 1, flags), block


def test_set_one_of_several():
    arguments, (_, second, _), found = three()
    one, two, three_ = by_hand(arguments, (2, second + 0.01, found[1].end_s))
    assert (one, three_) == (found[0], found[2])
    assert (two.release_s, two.end_s) == (second + 0.01, found[1].end_s)
    assert math.degrees(two.theta0) == pytest.approx(-9.0, abs=0.002)
    assert two.verdict.texts == ("overridden: why",)


def test_add_a_run_whose_hold_is_hidden_with_the_window_in_which_it_is_seen():
    arguments, (_, second, _), found = three()
    window = (second - 1.2, second - 1.0)
    seen = (arguments[0] > window[0]) & (arguments[0] < window[1])
    arguments = hidden(arguments, second)
    arguments[3][seen] = 0
    assert find_runs(*arguments)[1].verdict.names == ("hold_unseen",)
    one, two, three_ = by_hand(arguments, (2, second, found[1].end_s, window))
    assert [run.number for run in (one, two, three_)] == [1, 2, 3]
    others = found[0].release_s, found[2].release_s
    assert (one.release_s, three_.release_s) == pytest.approx(others, abs=1e-5)  # the rests show less noise
    assert math.degrees(two.theta0) == pytest.approx(-9.0, abs=0.002)
    assert (two.hold_start_s, two.release_s) == (window[0], second)


def test_add_a_run_whose_hold_is_hidden_altogether():
    arguments, (_, second, _), found = three()
    one, two, three_ = by_hand(hidden(arguments, second), (2, second, found[1].end_s))
    assert (one.verdict.level, three_.verdict.level) == ("ok", "ok")
    assert two.release_s > second + 0.2 and two.fit_start_s == two.release_s
    assert two.verdict.level == "warn" and two.verdict.texts == (
        "overridden: why",
        f"no hold is seen before {second:g} s: the run begins at its first clean peak, {two.release_s:.3f} s",
    )
    near = np.abs(arguments[0] - two.release_s) < 0.01
    assert two.theta0 == pytest.approx(np.mean(arguments[1][near]), rel=2e-3)


@pytest.mark.parametrize(("still_s", "hold_start_s"), [(0.0, 0.97), (1.5, 1.5)])
def test_a_hold_that_was_not_found_is_what_stands_still_before_the_release(still_s, hold_start_s):
    """Over `held_s` at most, up to `finger_s` before the release."""
    time_s = np.arange(0, 3, 1e-3)
    theta = np.where(time_s < still_s, 0.08, 0.1 - 0.05 * np.maximum(time_s - 2, 0) ** 2)
    signal = signal_of(time_s, theta, 1e-5, np.zeros(time_s.size, np.uint8))
    begun = begun_by_hand(signal, Override(1, 2.0, 3.0), None, 3.0, RunLimits())
    assert begun.hold_start_s == pytest.approx(hold_start_s, abs=0.026)
    assert begun.held.theta0 == pytest.approx(0.1) and begun.fit_start_s == 2.03


def test_hold_window():
    arguments, (first, _, _), found = three()
    one, *_ = by_hand(arguments, (1, first, found[0].end_s, (first - 0.5, first - 0.3)))
    assert one.hold_start_s == first - 0.5 and one.verdict.level == "ok"
    assert math.degrees(one.theta0) == pytest.approx(10.0, abs=0.003)


def cannot(what, others_from, *overrides, exclusions=()):
    """What stands in the verdict of the run in question, and that the others are as found."""
    arguments, _, found = three()
    runs = by_hand(arguments, *overrides, exclusions=exclusions)
    assert runs[others_from:] == found[others_from:]
    assert runs[0].verdict.level == "fail" and runs[0].verdict.texts[1] == what


def test_a_run_that_ends_after_the_next_is_released():
    _, (first, _, _), found = three()
    end_s = found[1].release_s + 0.5
    cannot(
        f"run 1 ends at {end_s:.3f} s, run 2 is released at {found[1].release_s:.3f} s: "
        "end it before, or exclude run 2",
        1,
        (1, first, end_s),
    )


def test_a_run_that_is_released_before_the_one_before_it_ends():
    arguments, _, found = three()
    release_s = found[0].end_s - 0.04
    one, two, *others = by_hand(arguments, (2, release_s, release_s + 1.0))
    assert (one, len(others)) == (found[0], 2) and two.verdict.level == "fail"
    assert two.verdict.texts[1] == (
        f"run 1 ends at {found[0].end_s:.3f} s, run 2 is released at {release_s:.3f} s: "
        "release it later, or exclude run 1"
    )


def test_a_run_that_ends_after_the_record():
    arguments, (_, _, third), found = three()
    *others, last = by_hand(arguments, (3, third, 99.0))
    assert others == found[:2] and last.end_s == arguments[0][-1]
    ends = f"the record ends at {arguments[0][-1]:.3f} s: give an end within the record"
    assert last.verdict.level == "fail" and last.verdict.texts[1] == f"set by hand to end at 99 s, {ends}"


def test_a_record_in_which_only_a_person_sees_a_run():
    arguments, (release,) = record()
    (run,) = by_hand(hidden(arguments, release), (1, release, release + 3))
    assert run.verdict.level == "warn" and run.n_impacts > 3


times = st.floats(-1e6, 1e6, allow_subnormal=False).map(lambda t: round(t, 9))


def judged(arguments, *stretches):
    """Runs and impacts as the record's job judges them, with stretches left out; θ is garbage there."""
    t, theta, sigma, flags, block = arguments
    without = ByHand(stretches=[(*each, "knocked") for each in stretches])
    over_time = {"theta": theta, "sigma_theta": np.full(t.size, sigma), "flags": np.asarray(flags, np.uint8)}
    columns = {name: ("time", each) for name, each in (over_time | {"rotation": theta}).items()}
    columns |= {f"fault{of}": ("fault", np.empty(0)) for of in ("", "_start", "_end", "_note", "_angle")}
    record = xr.Dataset(columns, {"time": t}, {"zero_stderr_rad": 0.0})
    found = measured(without.without_hidden(record), block, without)
    return [*zip(found.runs, found.impacts, strict=True)]


@cache
def second_of_three():
    """Impacts of the second of three runs, with nothing left out."""
    return judged(three()[0])[1][1]


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [(2, 3), (5, 5), (0, 0), (0, 1), (3, 6)])
def test_what_stands_in_a_stretch_does_not_matter_and_no_restitution_spans_it(first, last):
    """One unknown impact stands for those that are hidden; beyond all is as it was."""
    (arguments, _, _), plain = three(), second_of_three()
    stretch = plain.time_s[first] - 0.02, plain.time_s[last] + 0.02
    (_, _), (run, impacts), (_, _) = judged(arguments, stretch)
    spoiled = arguments[0].copy(), arguments[1].copy(), *arguments[2:]
    spoiled[1][slice(*np.searchsorted(spoiled[0], stretch))] += math.radians(30)
    (_, _), (again, same), (_, _) = judged(spoiled, stretch)
    assert again == run and run.verdict.level == "ok"
    for column in IMPACT_COLUMNS:
        np.testing.assert_array_equal(getattr(same, column), getattr(impacts, column))
    assert run.verdict.texts == (f"{stretch[0]:.3f} s to {stretch[1]:.3f} s left out: knocked",)
    unhidden = np.delete(np.arange(plain.time_s.size), slice(max(first - 1, 0), last + 2))
    known = np.isfinite(impacts.restitution)
    assert known.sum() == unhidden.size and np.isnan(impacts.time_s).sum() == 1
    for name, stderr in (("restitution", "restitution_stderr"), ("time_s", "time_stderr_s")):
        apart = getattr(impacts, name)[known] - getattr(plain, name)[unhidden]
        most = 4 * np.nan_to_num(getattr(plain, stderr)[unhidden], nan=1.0)  # windows about a peak may differ
        assert np.all(np.abs(apart) <= most)
