"""What the review desk remembers: the same to the last bit, made once, and the oldest let go."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from freerock.review.remembered import Remembered


@dataclass(frozen=True)
class Some:
    theta: np.ndarray
    unit: tuple


@dataclass(frozen=True)
class Identified:
    fits: dict
    errors: dict
    rest: list


def test_what_is_remembered_is_the_same_to_the_last_bit_and_each_asker_has_its_own():
    values = np.random.default_rng(1).standard_normal(1000)
    values[3] = np.nan
    made = xr.Dataset(
        {"theta": ("time", values, {"units": "rad"})}, {"time": np.arange(1000) / 3}, {"a": 0.1}
    )
    known, times = Remembered(2), []

    def make():
        times.append(1)
        return made

    of = ({"block": 1, "rate": 0.1}, values)
    first, second = known.get(of, make), known.get(({"rate": 0.1, "block": 1}, values.copy()), make)
    assert len(times) == 1 and first.identical(second) and first.identical(made)
    second["theta"].values[0] = 5.0
    assert known.get(of, make).identical(made)


def test_fits_come_back_as_they_were(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    found = Identified({"housner": Some(np.arange(4000.0), (1.5, "s"))}, {"winkler": "no"}, [np.zeros(3)])
    known = Remembered(2)
    known.get("a", lambda: found)
    assert len([*tmp_path.rglob("*.npy")]) == 1  # large arrays of a fit keep no memory
    again = known.get("a", lambda: None)
    assert type(again) is Identified and again.errors == found.errors and again is not found
    np.testing.assert_array_equal(again.fits["housner"].theta, np.arange(4000.0))
    assert again.fits["housner"].unit == (1.5, "s")
    again.rest[0][0] = 1.0
    assert known.get("a", lambda: None).rest[0][0] == 0.0 == found.rest[0][0]
