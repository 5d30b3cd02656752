"""Small record files of every format, and ways to damage them."""

import os
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from subprocess import PIPE, Popen
from zipfile import ZipFile

import c3d as c3d_files
import h5py
import numpy as np
from nptdms import ChannelObject, RootObject, TdmsWriter
from openpyxl import Workbook
from scipy.io import netcdf_file, savemat

from freerock.records import hdf5_walk

TIME = np.arange(100) / 200
VOLTS = np.round(320 + 64 * np.cos(20 * TIME)) / 64  # exact in six digits and in single precision


def tdms(path):
    waveform = {"wf_increment": 0.005, "wf_samples": 100, "unit_string": "V"}
    with TdmsWriter(path) as writer:
        for part in np.split(VOLTS, 2):
            laser = ChannelObject("rocking", "laser", part, waveform | {"wf_samples": 50})
            writer.write_segment([RootObject(), laser])


def lvm(path):
    head = [
        "LabVIEW Measurement",
        "Writer_Version\t2",
        "Separator\tTab",
        "Decimal_Separator\t,",
        "X_Columns\tOne",
        "***End_of_Header***",
        "",
        "Channels\t1",
        "Samples\t100",
        "Date\t2017/05/02",
        "Time\t09:00:00,5",
        "Y_Unit_Label\tV",
        "X0\t0,0",
        "Delta_X\t0,005000",
        "***End_of_Header***",
        "X_Value\tlaser\tComment",
    ]
    rows = [f"{t:.6f}\t{v:.6f}".replace(".", ",") for t, v in zip(TIME, VOLTS, strict=True)]
    path.write_text("\n".join(head + rows) + "\n")


def csv(path):
    rows = [f"{t:.3f};{v:.6f}".replace(".", ",") for t, v in zip(TIME, VOLTS, strict=True)]
    path.write_text("\n".join(["Operator: N. N.", "Time [s];laser [V]", *rows]) + "\n")


def mat5(path):
    savemat(path, {"t": TIME, "laser": VOLTS, "note": "by hand"})


def mat7(path):
    savemat(path, {"t": TIME, "laser": VOLTS}, do_compression=True)


def mat4(path):
    savemat(path, {"fs": 200.0, "laser": VOLTS}, format="4")


def mat73(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"t": TIME, "laser": VOLTS}.items():
            file.create_dataset(name, data=values[None], compression="gzip")
            file[name].attrs["MATLAB_class"] = np.bytes_("double")


def excel(path):
    book = Workbook()
    sheet = book.active
    for row in [["A1", None], ["time", "θ"], ["[s]", "[rad]"]]:
        sheet.append(row)
    for pair in zip(TIME, VOLTS, strict=True):
        sheet.append(pair)
    book.save(path)


def hdf5(path):
    with h5py.File(path, "w") as file:
        laser = file.create_dataset("daq/laser", data=VOLTS, chunks=(25,), compression="gzip")
        laser.attrs["units"] = "V"
        file["daq"].attrs["sampling_rate"] = 200.0


def netcdf(path):
    with netcdf_file(path, "w") as file:
        file.createDimension("time", TIME.size)
        for name, values, units in [("time", TIME, "s"), ("laser", VOLTS, "V")]:
            variable = file.createVariable(name, "f8", ("time",))
            variable[:] = values
            variable.units = units


def c3d(path):
    writer = c3d_files.Writer(point_rate=200.0)
    for volts in VOLTS:
        writer.add_frames([(np.array([[volts, 0, 1, 0, 0]], np.float32), np.zeros((0, 1)))])
    writer.set_point_labels(["laser"])
    with open(path, "wb") as file, warnings.catch_warnings(action="ignore"):  # of no analog channels
        writer.write(file)


# Kind of file: suffix and writer.
KINDS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "tdms": (".tdms", tdms),
    "lvm": (".lvm", lvm),
    "csv": (".csv", csv),
    "mat v4": (".mat", mat4),
    "mat v5": (".mat", mat5),
    "mat v7": (".mat", mat7),
    "mat v7.3": (".mat", mat73),
    "excel": (".xlsx", excel),
    "sheet": (".xlsx", excel),
    "hdf5": (".h5", hdf5),
    "netcdf": (".nc", netcdf),
    "c3d": (".c3d", c3d),
}


SHEET = "xl/worksheets/sheet1.xml"


def damaged_files(kind: str, folder: Path, n: int, seed: int) -> Iterator[Path]:
    """Write n damaged files of a kind, one after the other, to one path; of a "sheet" inside its archive."""
    suffix, write = KINDS[kind]
    path = folder / f"record{suffix}"
    write(path)
    if kind == "sheet":
        with ZipFile(path) as archive:
            parts = {name: archive.read(name) for name in archive.namelist()}
        for copy in damaged(parts[SHEET], n, seed):
            with ZipFile(path, "w") as archive:
                for name, part in (parts | {SHEET: copy}).items():
                    archive.writestr(name, part)
            yield path
    else:
        for copy in damaged(path.read_bytes(), n, seed):
            path.write_bytes(copy)
            yield path


def damaged(content: bytes, n: int, seed: int) -> Iterator[bytes]:
    """Yield n damaged copies: flipped bits, a truncated end, shuffled chunks, or a chunk of other bytes."""
    random = np.random.default_rng(seed)
    whole = np.frombuffer(content, np.uint8)
    for i in range(n):
        copy = whole.copy()
        if i % 4 == 0:
            places = random.integers(copy.size, size=random.integers(1, 9))
            copy[places] ^= (1 << random.integers(0, 8, places.size)).astype(np.uint8)
        elif i % 4 == 1:
            copy = copy[: random.integers(copy.size)]
        elif i % 4 == 2:
            chunks = np.array_split(copy, random.integers(2, 33))
            copy = np.concatenate([chunks[j] for j in random.permutation(len(chunks))])
        else:
            start = random.integers(copy.size)
            end = start + random.integers(1, 65)
            copy[start:end] = random.choice([0, 255, 127, 57], copy[start:end].size)
        yield copy.tobytes()


WALKER = """\
import os, sys
import hdf5_walk

for line in sys.stdin:
    path, seconds, most_bytes = line.rstrip("\\n").rsplit(" ", 2)
    child = os.fork()
    if not child:
        code = 1
        try:
            hdf5_walk.limit_time(int(seconds))
            hdf5_walk.walk(path, float(most_bytes))
            code = 0
        finally:
            os._exit(code)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@cache
def walker() -> Popen[str]:
    """A Python that forks for each file; it is small, what reads the files is not and takes long to fork."""
    environment = os.environ | {"PYTHONPATH": str(Path(hdf5_walk.__file__).parent)}
    return Popen([sys.executable, "-c", WALKER], env=environment, stdin=PIPE, stdout=PIPE, text=True)


def walked_by_a_fork(path: str, seconds: int, most_bytes: float) -> int:
    """In place of `hdf5.walked`, where thousands of files are read: to start Python as often takes hours."""
    there = walker()
    print(path, seconds, most_bytes, file=there.stdin, flush=True)
    return int(there.stdout.readline())
