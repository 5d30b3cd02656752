import struct
import tracemalloc

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr
from reading import refusal
from scipy.io import netcdf_file

from freerock.products.netcdf import write_record
from freerock.records.read import read_record

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


def test_sampling_rate_by_a_single_number(tmp_path):
    dataset = read_record(hdf5(tmp_path / "a.h5", {"daq/laser": VOLTS, "daq/fs": 500.0}))
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(500)


def test_packed_values(tmp_path):
    packed = np.arange(60, dtype=np.int16)
    packed[3] = -999
    attrs = {"laser__scale_factor": 0.5, "laser__add_offset": 1.0, "laser___FillValue": np.int16(-999)}
    dataset = read_record(hdf5(tmp_path / "a.h5", {"time": TIME, "laser": packed}, **attrs))
    np.testing.assert_array_equal(dataset["laser"], np.where(packed == -999, np.nan, 1 + 0.5 * packed))


def test_classic_netcdf(tmp_path):
    path = tmp_path / "a.nc"
    with netcdf_file(path, "w") as file:
        file.createDimension("time", None)
        for name, values, units in [("time", TIME, "seconds since 2017-05-02"), ("theta", VOLTS, "rad")]:
            variable = file.createVariable(name, "f8", ("time",))
            variable[:] = values
            variable.units = units
    dataset = read_record(path)
    np.testing.assert_array_equal(dataset["theta"], VOLTS)
    assert dataset.attrs == {
        "format": "netCDF classic",
        "sampling_rate_hz": pytest.approx(500),
        "start_time": "2017-05-02",
    }


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
    write_record(path, record, [], [], attrs)
    dataset = read_record(path, "theta")
    np.testing.assert_array_equal(dataset["theta"], VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert dataset["theta"].attrs["units"] == "rad"
    assert dataset.attrs["start_time"] == "2017-05-02T09:00:00.000Z"


def test_nothing_outside_the_file_is_read(tmp_path):
    other = hdf5(tmp_path / "other.h5", {"secret": VOLTS})
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS})
    raw = tmp_path / "raw.bin"
    raw.write_bytes(VOLTS.tobytes())
    with h5py.File(path, "a") as file:
        file["link"] = h5py.ExternalLink(other, "secret")
        layout = h5py.VirtualLayout((60,), float)
        layout[:] = h5py.VirtualSource(other, "secret", (60,))
        file.create_virtual_dataset("virtual", layout)
        file.create_dataset("external", (60,), float, external=[(raw, 0, 480)])
    assert list(read_record(path).data_vars) == ["laser"]


def test_more_data_than_the_file_can_hold(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("laser", shape=(10**10,), dtype="u1", chunks=(1000,))
    assert refusal(path).startswith("the file declares 8e+10 bytes of data, more than its ")


def test_no_time_and_no_rate(tmp_path):
    assert refusal(hdf5(tmp_path / "a.h5", {"laser": VOLTS, "wire": VOLTS})) == (
        "no vector of time and no sampling rate (vectors: laser, wire); "
        "add a vector time, or an attribute sampling_rate in Hz"
    )


def test_a_vector_of_another_length(tmp_path):
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS, "peaks": VOLTS[:7]})
    assert list(read_record(path).data_vars) == ["laser"]
    assert refusal(path, "peaks") == (
        "channel 'peaks' has 7 samples, its time 60; name a channel that holds numbers"
    )


def test_no_vector(tmp_path):
    assert refusal(hdf5(tmp_path / "a.h5", {"image": np.zeros((3, 4))})) == (
        "the file holds no vector of numbers; copy it again from the acquisition computer"
    )


def test_truncated(tmp_path):
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS})
    path.write_bytes(path.read_bytes()[:-200])
    assert refusal(path).startswith("not a readable HDF5 file (OSError: Unable to synchronously open file")


DEADLY = "the file is damaged: HDF5's library crashes on it; copy it again from the acquisition computer"


def test_a_collection_of_texts_without_end(tmp_path, monkeypatch):
    """HDF5's library (2.0.0) never returns from reading this attribute."""
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS}, laser__units="V")
    content = path.read_bytes()
    free = content.index(b"GCOL") + 16 + 24
    (length,) = struct.unpack_from("<Q", content, free + 8)
    path.write_bytes(content[: free + 8] + struct.pack("<Q", length - 16) + content[free + 16 :])
    monkeypatch.setattr("freerock.bounds.HDF5_WALK_S", 1)
    assert refusal(path) == DEADLY


def test_a_file_that_ends_the_library(tmp_path):
    """HDF5's library (2.0.0) ends in a segmentation fault where a text's type is of an unknown class."""
    path = hdf5(tmp_path / "a.h5", {"time": TIME, "laser": VOLTS}, laser__units="V")
    content = path.read_bytes()
    assert content.count(b"units\0\0\0\x19\x01") == 1
    path.write_bytes(content.replace(b"units\0\0\0\x19\x01", b"units\0\0\0\x19\x05"))
    assert refusal(path) == DEADLY


@pytest.mark.parametrize("value", [1.7e308, -1.7e308])
def test_a_sample_beyond_any_sensor_is_one_line(tmp_path, value):
    samples = np.sin(np.arange(100.0))
    samples[7] = value
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["laser"] = samples
        file.attrs["sampling_rate"] = 100.0
    assert f"channel 'laser' holds {value:g} at sample 7, beyond ±1e+100; export it again" in refusal(
        tmp_path / "a.h5"
    )


@pytest.mark.parametrize("kind", ["f8", "f4", "i2"])
def test_memory_of_a_vector_is_that_of_its_doubles(tmp_path, kind):
    n = 3_000_000
    samples = np.random.default_rng(1).integers(0, 4096, n).astype(kind)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["laser"] = samples
        file["laser"].attrs.update(scale_factor=2.0, add_offset=1.0)
        file.attrs["sampling_rate"] = 100.0
    read_record(tmp_path / "a.h5")
    tracemalloc.start()
    try:
        dataset = read_record(tmp_path / "a.h5")
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(dataset["laser"], 2.0 * samples + 1.0)
    assert most < 1.5 * dataset["laser"].nbytes


@pytest.mark.parametrize(
    ("kept", "suffix"),
    [("all", "h5"), ("with gaps", "mat"), ("some lost", "h5"), ("rounded", "h5"), ("rounded", "mat")],
)
def test_memory_of_a_vector_with_stamps_is_that_of_its_doubles(tmp_path, kept, suffix):
    """Scratch arrays of one part count besides, hence a record long enough for these to be few."""
    n = 6_000_000
    at = {
        "all": slice(None),
        "with gaps": np.r_[0 : n // 3, n // 3 + 1000 : n],
        "some lost": np.flatnonzero(np.arange(n) % 50 != 7),
        "rounded": slice(None),
    }[kept]
    time = np.arange(n) / 1024
    time = np.round(time, 3) if kept == "rounded" else time[at]
    with h5py.File(tmp_path / f"a.{suffix}", "w") as file:
        shape = (1, -1) if suffix == "mat" else (-1,)
        file["time"], file["laser"] = time.reshape(shape), np.sin(time).reshape(shape)
    read_record(tmp_path / f"a.{suffix}")
    tracemalloc.start()
    try:
        dataset = read_record(tmp_path / f"a.{suffix}")
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert np.isfinite(dataset["laser"]).sum() == time.size
    assert most < 1.5 * dataset["laser"].nbytes
