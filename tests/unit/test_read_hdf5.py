import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr
from reading import refusal

from freerock.products.netcdf import write_record
from freerock.records.read import read_record
from freerock.runs.runs import Measured

TIME = np.arange(60) / 500
VOLTS = 5 + np.sin(20 * TIME)


def hdf5(path, arrays, **attrs):
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file.create_dataset(name, data=values)
        for name, value in attrs.items():
            owner, _, key = name.partition("__")
            file[owner if key else "/"].attrs[key or name] = value
    return path


def test_time_in_the_group_or_above(tmp_path):
    arrays = {"time": TIME, "daq/laser": VOLTS, "slow/t": 2 * TIME, "slow/wire": -VOLTS}
    path = hdf5(tmp_path / "a.h5", arrays, daq__x=1, time__units="ms")
    assert refusal(path) == "channels of several time bases: laser, wire; name the channel"
    dataset = read_record(path, "daq/laser")
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME / 1000, atol=1e-12)
    assert read_record(path, "wire").attrs == {
        "format": "HDF5",
        "sampling_rate_hz": pytest.approx(250),
        "reading": "time has no unit and is taken for seconds",
    }


@pytest.mark.parametrize(
    "attrs", [{"laser__sampling_rate": 500.0}, {"fs": 500}, {"dt": 0.002}, {"laser__sample_rate": "0.5 kHz"}]
)
def test_sampling_rate_by_attribute(tmp_path, attrs):
    path = hdf5(tmp_path / "a.h5", {"laser": VOLTS}, laser__units="V", **attrs)
    dataset = read_record(path)
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(500)
    assert dataset["laser"].attrs["units"] == "V"


def test_netcdf4(tmp_path):
    path = tmp_path / "a.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("time", 60)
        for name, values, units in [("time", TIME, "s"), ("laser", VOLTS, "V")]:
            variable = file.createVariable(name, "f8", ("time",), zlib=True)
            variable[:] = values
            variable.units = units
    dataset = read_record(path)
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    assert dataset["laser"].attrs["units"] == "V"


def test_the_projects_own_records(tmp_path):
    record = xr.Dataset(
        {
            "theta": ("time", VOLTS),
            "sigma_theta": ("time", np.full(60, 1e-4)),
            "flags": ("time", np.zeros(60, np.uint8)),
            "voltage": ("time", VOLTS),
        },
        {"time": TIME},
    )
    attrs = {"campaign": "c", "test": "t", "origin": "simulated", "start_time": "2017-05-02T09:00:00.000Z"}
    path = tmp_path / "t.nc"
    write_record(path, record, Measured((), (), None), (), attrs)
    dataset = read_record(path, "theta")
    np.testing.assert_array_equal(dataset["theta"], VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert dataset["theta"].attrs["units"] == "rad"
    assert dataset.attrs["start_time"] == "2017-05-02T09:00:00.000Z"


def test_no_time_and_no_rate(tmp_path):
    assert refusal(hdf5(tmp_path / "a.h5", {"laser": VOLTS, "wire": VOLTS})) == (
        "no vector of time and no sampling rate (variables: laser, wire); "
        "head the time as Time [s], state the rate in the file as fs in Hz, or give sampling_rate_hz"
    )


def test_truncated(tmp_path):
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS})
    path.write_bytes(path.read_bytes()[:-200])
    assert refusal(path).startswith("not a readable .h5 file (OSError: Unable to synchronously open file")
