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


def test_no_time_and_no_rate(tmp_path):
    for version in ("5", "7.3"):
        path = save(tmp_path / "a.mat", {"laser": VOLTS, "mass": 12.0}, version)
        assert refusal(path) == (
            "no vector of time and no sampling rate (variables: laser, mass); "
            "head the time as Time [s], state the rate in the file as fs in Hz, or give sampling_rate_hz"
        )


def test_truncated(tmp_path):
    path = save(tmp_path / "a.mat", {"t": TIME, "laser": VOLTS}, "5")
    path.write_bytes(path.read_bytes()[:-8])
    assert refusal(path) == (
        "not a readable .mat file (OSError: could not read bytes); "
        "copy it again from the acquisition computer"
    )


def test_not_a_mat_file(tmp_path):
    path = tmp_path / "a.mat"
    path.write_text("time;volts\n0;1\n" * 100)
    assert refusal(path).startswith("not a readable .mat file (")
