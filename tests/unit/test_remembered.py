"""What the review desk remembers: the same to the last bit, made once, and the oldest let go."""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from freerock.models.block import Block
from freerock.review.remembered import Remembered, content


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


def test_the_one_not_asked_for_longest_is_let_go_and_the_folder_goes_with_the_process(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def asked():
        known, made = Remembered(2), []
        for number in (1, 2, 1, 3, 1, 2):
            assert known.get(number, lambda number=number: made.append(number) or number) == number
        (folder,) = tmp_path.iterdir()
        assert len([*folder.iterdir()]) == 2
        return made

    assert asked() == [1, 2, 3, 2]
    assert [*tmp_path.iterdir()] == []


def test_without_space_it_is_made_again(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    known = Remembered(2)

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr("freerock.review.remembered.np.save", full)
    assert [known.get(1, lambda n=n: np.full(5000, n))[0] for n in (7, 8)] == [7, 8]
    assert [each for each in tmp_path.rglob("*") if each.is_file()] == []


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (np.arange(3), np.arange(3.0)),
        (np.zeros(4), np.zeros((2, 2))),
        (Block(0.28, 0.07, 5.84), Block(0.28, 0.07, 5.85)),
        ({"a": 1}, {"a": 2}),
        ([1, 2], [2, 1]),
    ],
)
def test_contents_that_differ_have_keys_that_differ(one, other):
    assert content(one) != content(other)
    assert content(one) == content(one)
