"""A file that gives two sampling rates, or two decimal marks, is refused; no format chooses between them."""

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter
from openpyxl import Workbook
from reading import refusal
from scipy.io import savemat

from freerock.records.read import read_record

N = 200
VOLTS = np.linspace(1, 2, N)
REMEDY = "; correct the one that is wrong, or "


def text(path, *above, step=None):
    rows = [f"{n * step:.6f};{v:.4f}" if step else f"{v:.4f};0.5" for n, v in enumerate(VOLTS)]
    path.write_text("\n".join([*above, *rows, ""]))
    return path


def workbook(path, *rows, step=None):
    book = Workbook()
    for row in rows:
        book.active.append(row)
    for n, v in enumerate(VOLTS):
        book.active.append([n * step, v] if step else [v, 0.5])
    book.save(path)
    return path


def hdf5(path, attributes=None, of_file=None, step=None):
    with h5py.File(path, "w") as file:
        file["laser"] = VOLTS
        file["laser"].attrs.update(attributes or {})
        file.attrs.update(of_file or {})
        if step:
            file["time"] = np.arange(N) * step
            file["time"].attrs["units"] = "s"
    return path


def tdms(path, step, unit, stamps):
    with TdmsWriter(path) as writer:
        laser = ChannelObject("g", "laser", VOLTS, {"wf_increment": step, "wf_samples": N})
        time = ChannelObject("g", "Time", stamps, {"unit_string": unit})
        writer.write_segment([RootObject(), laser, time])
    return path


def test_two_statements_of_a_text(tmp_path):
    path = text(tmp_path / "a.csv", "fs = 2000 Hz", "dt = 0.001 s")
    assert refusal(path).startswith("fs and dt give 2000 and 1000 Hz; correct the one that is wrong")
    path = text(tmp_path / "a.csv", "fs = 2000 Hz", "dt = 0.0005 s")
    assert read_record(path, "column 1").attrs["sampling_rate_hz"] == 2000


def test_a_column_of_time_and_a_statement(tmp_path):
    mat = tmp_path / "a.mat"
    savemat(mat, {"laser": VOLTS, "t": np.arange(N) * 0.001, "fs": 2000.0})
    for path in (
        text(tmp_path / "a.csv", "fs = 2000 Hz", "time [s];V", step=0.001),
        workbook(tmp_path / "a.xlsx", ["fs", 2000], ["time [s]", "V"], step=0.001),
        hdf5(tmp_path / "a.h5", of_file={"fs": 2000.0}, step=0.001),
        mat,
    ):
        assert refusal(path) == (
            f"one clock gives 1000 Hz, and the file states 2000 Hz{REMEDY}its unit, or leave it out"
        )
    path = text(tmp_path / "a.csv", "fs = 1000 Hz", "time [ms];V", step=1.0)
    assert read_record(path).attrs["sampling_rate_hz"] == pytest.approx(1000)


@pytest.mark.parametrize(("unit", "factor"), [("s", 1), ("ms", 1e3), ("", 1e3), ("", 1), ("counts", 1)])
def test_an_increment_and_a_channel_of_time_that_agree(tmp_path, unit, factor):
    path = tdms(tmp_path / "a.tdms", 5e-4, unit, np.arange(N) * 5e-4 * factor)
    assert read_record(path, "laser").attrs["sampling_rate_hz"] == 2000


@pytest.mark.parametrize(("unit", "step"), [("s", 0.001), ("ms", 5e-4), ("", 0.001)])
def test_an_increment_and_a_channel_of_time_that_differ(tmp_path, unit, step):
    path = tdms(tmp_path / "a.tdms", 5e-4, unit, np.arange(N) * step)
    assert refusal(path, "laser").startswith("one clock gives 2000 Hz, and 'Time' gives ")
