import struct
import tracemalloc
import zlib

import h5py
import numpy as np
import pytest
from reading import refusal
from scipy.io import savemat

from freerock.records.read import read_record

TIME = np.arange(60) / 500
VOLTS = 5 + np.sin(20 * TIME)


def save(path, variables, version):
    if version == "7.3":
        with h5py.File(path, "w", userblock_size=512) as file:
            for name, value in variables.items():
                array = np.atleast_2d(value)
                file.create_dataset(name, data=array if np.ndim(value) == 1 else array.T)
            file.create_dataset("#refs#/a", data=TIME)
    else:
        savemat(path, variables, format="4" if version == "4" else "5", do_compression=version == "7")
    return path


@pytest.mark.parametrize("version", ["4", "5", "7", "7.3"])
def test_versions(tmp_path, version):
    variables = {"t": TIME, "laser": VOLTS, "both": np.column_stack([VOLTS, -VOLTS])}
    dataset = read_record(save(tmp_path / "a.mat", variables, version))
    assert list(dataset.data_vars) == ["laser", "both(:,1)", "both(:,2)"]
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_array_equal(dataset["both(:,2)"], -VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert dataset.attrs == {
        "format": "MAT v5" if version == "7" else f"MAT v{version}",
        "sampling_rate_hz": pytest.approx(500),
        "reading": "time has no unit and is taken for seconds",
    }


@pytest.mark.parametrize("version", ["4", "7", "7.3"])
@pytest.mark.parametrize("rate", [{"fs": 500.0}, {"dt": 0.002}, {"sampling_rate_hz": 500.0}])
def test_stated_sampling_rate(tmp_path, version, rate):
    dataset = read_record(save(tmp_path / "a.mat", {"laser": VOLTS} | rate, version))
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(500)
    assert dataset["time"][0] == 0


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_a_matrix_with_time_in_its_first_column(tmp_path, version):
    dataset = read_record(save(tmp_path / "a.mat", {"data": np.column_stack([TIME, VOLTS])}, version))
    np.testing.assert_array_equal(dataset["data(:,2)"], VOLTS)
    assert dataset.attrs["reading"] == (
        "data(:,1) rises steadily and is taken for time; time has no unit and is taken for seconds"
    )


def test_unit_of_time(tmp_path):
    dataset = read_record(save(tmp_path / "a.mat", {"time_ms": 1000 * TIME, "laser": VOLTS}, "5"))
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert "reading" not in dataset.attrs


def test_only_plain_arrays_are_looked_at(tmp_path):
    variables = {
        "t": TIME,
        "laser": VOLTS,
        "note": "by hand",
        "cell": np.array([1, "a", VOLTS], object),
        "setup": {"gain": 2.0},
    }
    dataset = read_record(save(tmp_path / "a.mat", variables, "5"))
    assert list(dataset.data_vars) == ["laser"]


def test_complex_numbers_are_refused(tmp_path):
    variables = {"t": TIME, "laser": VOLTS, "spectrum": 1j * VOLTS}
    path = save(tmp_path / "a.mat", variables, "4")
    assert refusal(path) == "variable 'spectrum' holds no real numbers; name the channel"
    assert list(read_record(path, "laser").data_vars) == ["laser"]
    assert list(read_record(save(tmp_path / "b.mat", variables, "5")).data_vars) == ["laser"]


def test_no_time_and_no_rate(tmp_path):
    for version in ("5", "7.3"):
        path = save(tmp_path / "a.mat", {"laser": VOLTS, "mass": 12.0}, version)
        assert refusal(path) == (
            "no vector of time and no sampling rate (variables: laser, mass); "
            "save the time as t, or the sampling rate in Hz as fs"
        )


def test_no_signal(tmp_path):
    assert refusal(save(tmp_path / "a.mat", {"t": TIME, "s": {"laser": VOLTS}}, "5")) == (
        "no numeric vector that could be a signal; save(…) the time and the signals as numeric vectors"
    )


def test_signal_and_time_of_unequal_length(tmp_path):
    assert refusal(save(tmp_path / "a.mat", {"t": TIME[:-1], "laser": VOLTS}, "5")) == (
        "60 samples but 59 time stamps in 't'; copy it again from the acquisition computer"
    )


def test_more_data_than_the_file_can_hold(tmp_path):
    """A v4 header that announces 10^9 rows, and an HDF5 dataset of as many that were never written."""
    path = save(tmp_path / "a.mat", {"fs": 500.0, "laser": VOLTS[:, None]}, "4")
    content = path.read_bytes()
    at = content.index(b"laser\0") - 16
    path.write_bytes(content[:at] + np.int32(10**9).tobytes() + content[at + 4 :])
    assert refusal(path).startswith("the file declares 8e+09 bytes of data, more than its ")
    path = tmp_path / "b.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("laser", shape=(1, 10**9), dtype=float, chunks=(1, 1000))
    assert refusal(path).startswith("the file declares 8e+09 bytes of data, more than its ")


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"])
@pytest.mark.parametrize("compressed", [False, True])
def test_types_of_numbers(tmp_path, kind, compressed):
    whole = np.arange(60).astype(kind)
    savemat(
        tmp_path / "a.mat", {"fs": 500, "laser": whole, "m": whole.reshape(20, 3)}, do_compression=compressed
    )
    dataset = read_record(tmp_path / "a.mat", "laser")
    np.testing.assert_array_equal(dataset["laser"], np.arange(60))
    np.testing.assert_array_equal(read_record(tmp_path / "a.mat", "m(:,3)")["m(:,3)"], np.arange(2, 60, 3))


def test_the_other_byte_order(tmp_path):
    """A v5 file as a big-endian machine writes it: 3 samples and a sampling rate."""

    def element(kind, data):
        return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8)

    def matrix(name, values):
        flags, size = struct.pack(">II", 6, 0), struct.pack(">ii", len(values), 1)
        body = element(6, flags) + element(5, size) + element(1, name)
        return element(14, body + element(9, struct.pack(f">{len(values)}d", *values)))

    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack(">H", 0x0100) + b"MI"
    path = tmp_path / "a.mat"
    path.write_bytes(head + matrix(b"fs", [2.0]) + matrix(b"laser", [1.0, 2.5, 4.0]))
    np.testing.assert_array_equal(read_record(path)["laser"], [1, 2.5, 4])


def test_truncated(tmp_path):
    path = save(tmp_path / "a.mat", {"t": TIME, "laser": VOLTS}, "5")
    path.write_bytes(path.read_bytes()[:-8])
    assert refusal(path) == (
        "not a readable MAT file (ValueError: the element at byte 672 ends beyond the file); "
        "copy it again from the acquisition computer"
    )


def test_an_unknown_type_of_numbers(tmp_path):
    """Such a byte ends SciPy's reader in a segmentation fault."""
    path = save(tmp_path / "a.mat", {"fs": 500.0, "laser": VOLTS}, "5")
    content = path.read_bytes()
    at = content.index(VOLTS.tobytes()) - 8
    assert content[at : at + 4] == b"\x09\0\0\0"
    path.write_bytes(content[:at] + b"\x09\x80" + content[at + 2 :])
    assert refusal(path).startswith("not a readable MAT file (KeyError: 32777); ")


def test_not_a_mat_file(tmp_path):
    path = tmp_path / "a.mat"
    path.write_text("time;volts\n0;1\n" * 100)
    assert refusal(path).startswith("not a readable MAT file (")


def test_a_table_beside_the_channel_is_no_damage(tmp_path):
    path = save(tmp_path / "a.mat", {"t": TIME, "x": VOLTS, "cal": np.arange(7.0)}, "5")
    assert refusal(path) == "channels of unequal length: x 60, cal 7; name the channel"
    np.testing.assert_array_equal(read_record(path, "x")["x"], VOLTS)


def test_data_that_unpack_to_a_hundred_times_the_file_are_refused_unread(tmp_path):
    """30 million zeros, 240 MB, in a quarter of one; the file is written as MATLAB does."""
    n = 30_000_000
    flags = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, n, 1)
    head = flags + struct.pack("<HH4s", 1, 4, b"laser"[:4]) + struct.pack("<II", 9, 8 * n)
    packer = zlib.compressobj()
    body = packer.compress(struct.pack("<II", 14, len(head) + 8 * n) + head)
    body += b"".join(packer.compress(bytes(1_000_000)) for _ in range(8 * n // 1_000_000)) + packer.flush()
    path = tmp_path / "bomb.mat"
    path.write_bytes(
        b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(body)) + body
    )
    tracemalloc.start()
    try:
        assert "declares 2.4e+08 bytes of data, more than its" in refusal(path)
        assert tracemalloc.get_traced_memory()[1] < 10_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(("version", "kind"), [("5", "f8"), ("7", "f8"), ("7.3", "f8"), ("7.3", "f4")])
def test_memory_of_a_vector_is_that_of_its_doubles(tmp_path, version, kind):
    n = 4_000_000
    noise = (np.random.default_rng(1).integers(0, 4096, n) / 409.6).astype(kind)
    path = save(tmp_path / "a.mat", {"fs": 1000.0, "laser": noise}, version)
    read_record(path)
    tracemalloc.start()
    try:
        dataset = read_record(path)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(dataset["laser"], noise)
    assert most < 1.5 * dataset["laser"].nbytes
