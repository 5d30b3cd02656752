import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.records.read import on_grid, regular_grid

RATE = 2000
TIME = np.arange(4000) / RATE


def refusal(time, values=None):
    with pytest.raises(FreerockError) as error:
        grid = regular_grid("file", time)
        on_grid("file", grid, values)
    return str(error.value).removeprefix("file: ")


def test_even_stamps():
    grid = regular_grid("file", 0.25 + TIME)
    assert (grid.start_s, grid.size, grid.places, grid.faults) == (0.25, 4000, None, ())
    assert grid.step_s == pytest.approx(1 / RATE, rel=1e-12)
    values = np.arange(4000.0)
    np.testing.assert_array_equal(on_grid("file", grid, values), values)


def test_mild_jitter_gives_an_even_grid():
    random = np.random.default_rng(1)
    grid = regular_grid("file", TIME + random.uniform(-0.2, 0.2, TIME.size) / RATE)
    assert grid.size == 4000 and grid.places is None
    assert grid.step_s == pytest.approx(1 / RATE, rel=1e-5)
    assert grid.start_s == pytest.approx(0, abs=0.02 / RATE)
    assert grid.faults == ("time stamps jitter by up to 20 % of the sampling interval",)


def test_strong_jitter_is_refused():
    random = np.random.default_rng(1)
    message = refusal(np.sort(TIME + random.uniform(-0.6, 0.6, TIME.size) / RATE))
    assert message.startswith("the stamps leave an even grid of 0.0004")
    assert message.endswith("sampling intervals; export with the logger's own clock, or resample it evenly")


@pytest.mark.parametrize("rate", [1024, 1200, 2048, 5000, 700])
def test_stamps_rounded_to_milliseconds(rate):
    time = np.arange(5000) / rate
    grid = regular_grid("file", np.round(time, 3))
    assert grid.size == 5000 and grid.places is None
    assert grid.step_s == pytest.approx(1 / rate, rel=1e-4)
    (message,) = grid.faults
    assert message.startswith("time stamps rounded to 0.001 s; evenly spaced by ")


def test_gaps_become_missing_samples():
    kept = np.ones(4000, bool)
    kept[1000:1010] = kept[2500] = False
    grid = regular_grid("file", TIME[kept])
    assert grid.size == 4000 and grid.step_s == pytest.approx(1 / RATE, rel=1e-12)
    assert grid.faults == ("11 samples missing in 2 gaps, the first after 0.4995 s",)
    values = on_grid("file", grid, np.flatnonzero(kept))
    np.testing.assert_array_equal(values, np.where(kept, np.arange(4000.0), np.nan))


def test_time_that_runs_backwards_is_refused():
    assert refusal(np.concatenate([TIME, TIME])) == (
        "time runs backwards from 1.9995 to 0 s after sample 3999; split it into one file per recording"
    )
    swapped = TIME.copy()
    swapped[[10, 11, 20, 21]] = swapped[[11, 10, 21, 20]]
    assert refusal(swapped).startswith("time runs backwards from 0.0055 to 0.005 s")


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ([0.1], "no sampling rate from 1 time stamp; record more samples"),
        ([1, 1, 1], "all time stamps are 1 s; export the time column again"),
        (
            [0, np.nan, 2],
            "1 time stamp missing or infinite, the first at sample 1; export the time column again",
        ),
        (
            [0, 1, np.inf],
            "1 time stamp missing or infinite, the first at sample 2; export the time column again",
        ),
    ],
)
def test_stamps_without_a_grid(time, message):
    assert refusal(time) == message
