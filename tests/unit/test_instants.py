"""Time that is made where it is looked at: a user sees no difference to stored instants."""

import pickle

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from freerock.records.instants import time_of
from freerock.records.timebase import Grid

GRID = Grid(0.3, 1 / 3000, 1001)
STORED = np.arange(GRID.size, dtype=float) * GRID.step_s + GRID.start_s


def of(time):
    return xr.Dataset({"laser": ("time", np.sin(9 * STORED), {"units": "V"})}, coords=time)


MADE, KEPT = of(time_of(GRID)), of({"time": ("time", STORED, {"units": "s"})})
PARTS = {
    "interval": lambda d: d.sel(time=slice(0.4, 0.5)),
    "instant": lambda d: d.sel(time=STORED[3]),
    "nearest": lambda d: d.sel(time=[0.5, 0.52], method="nearest"),
    "every seventh": lambda d: d.isel(time=slice(3, None, 7)),
    "last": lambda d: d.isel(time=-1),
    "condition": lambda d: d.where(d.time > 0.4, drop=True),
    "means": lambda d: d.coarsen(time=7, boundary="trim").mean(),
    "between": lambda d: d.interp(time=[0.41, 0.43]),
    "renamed": lambda d: d.rename(time="t").sel(t=slice(0.4, 0.5)),
    "later": lambda d: d.assign_coords(time=d.time + 1),
    "joined": lambda d: xr.concat([d, d.assign_coords(time=d.time + 1)], "time"),
    "twice": lambda d: xr.concat([d, d], "time"),
    "copied": lambda d: pickle.loads(pickle.dumps(d.copy(deep=True))).isel(time=slice(None)),
}


@pytest.mark.parametrize("part", PARTS)
def test_parts_are_those_over_stored_instants(part):
    assert PARTS[part](MADE).identical(PARTS[part](KEPT))


def test_tables_and_files_are_those_over_stored_instants(tmp_path):
    assert MADE.to_dataframe().equals(KEPT.to_dataframe())
    for name, dataset in {"made": MADE, "kept": KEPT}.items():
        dataset.to_netcdf(tmp_path / name)
    assert (tmp_path / "made").read_bytes() == (tmp_path / "kept").read_bytes()


def test_another_grid_is_not_taken_for_the_same():
    assert MADE.equals(of(time_of(GRID)))
    other = of(time_of(Grid(0.3, 1 / 3001, 1001)))
    assert not MADE.equals(other)
    with pytest.raises(NotImplementedError):
        MADE + other


@given(st.floats(-1e9, 1e9), st.floats(1e-9, 1e3), st.integers(1, 300))
def test_instants_are_start_and_steps_to_the_last_bit(start_s, step_s, size):
    time = time_of(Grid(start_s, step_s, size))["time"]
    expected = np.arange(size, dtype=float) * step_s + start_s
    np.testing.assert_array_equal(time.values, expected)
    np.testing.assert_array_equal(time[::3].values, expected[::3])
    assert time[-1] == expected[-1]
