"""Small files of very many parts: read, or refused, in little time."""

import time

import h5py
import numpy as np
import pytest
from reading import refusal
from scipy.io import savemat

from freerock.records.read import list_channels, read_record

TOO_MANY = "the file has {} channels, more than 2000; export those of the record alone"


@pytest.fixture(autouse=True)
def quick():
    began = time.process_time()
    yield
    assert time.process_time() - began < 10


def test_a_text_of_very_many_columns(tmp_path):
    rows = [",".join([f"{n / 10}", *["1"] * 12_000]) for n in range(5)]
    (tmp_path / "a.csv").write_text(",".join(["t [s]", *["c"] * 12_000]) + "\n" + "\n".join(rows))
    assert refusal(tmp_path / "a.csv") == TOO_MANY.format(12_000)


def test_a_matlab_file_of_very_many_scalars(tmp_path):
    savemat(tmp_path / "a.mat", {f"s{i}": 1.0 for i in range(3000)} | {"laser": np.arange(9.0), "fs": 2.0})
    assert list(list_channels(tmp_path / "a.mat")) == ["laser"]
    assert read_record(tmp_path / "a.mat").attrs["sampling_rate_hz"] == 2


def test_an_hdf5_file_of_very_many_vectors_and_numbers(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for i in range(1900):
            file[f"v{i}"], file[f"s{i}"] = [1.0, 2.0], 1.0
        file["fs"] = 100.0
    assert read_record(tmp_path / "a.h5", "v7").attrs["sampling_rate_hz"] == 100


def test_an_hdf5_file_of_very_deep_groups(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["/".join(["g"] * 300) + "/laser"] = [1.0, 2.0]
        file["daq/laser"] = [3.0, 4.0]
        file["daq"].attrs["fs"] = 10.0
    assert list(list_channels(tmp_path / "a.h5")) == ["laser"]


def test_an_lvm_file_of_very_many_segments(tmp_path):
    segment = "Delta_X\t0.001\n***End_of_Header***\nX_Value\tV\n0\t1\n0.001\t2\n\n"
    head = "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\n\n"
    (tmp_path / "a.lvm").write_text(head + segment * 20_000)
    assert refusal(tmp_path / "a.lvm") == (
        "the file has more than 5000 segments; write it in fewer, or export it as one table"
    )
