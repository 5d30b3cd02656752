"""Reading large record files: processor time, and memory at its peak, each in a process of its own.

python -m freerock_bench.speed_of_records [part …] (needs up to 2 GB in the temporary folder)
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
from nptdms import ChannelObject, TdmsWriter

READ = """
import resource, sys, time
from freerock.records.read import read_record
import nptdms, pandas, xarray
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
start = time.process_time()
record = read_record(sys.argv[1], sys.argv[2] or None)
seconds = time.process_time() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
channels = sum(channel.nbytes for channel in record.data_vars.values())
print(record.sizes["time"], seconds, peak / 1024, before / 1024, (peak - before) * 1024 / channels)
"""


def tdms_2gb(folder):
    """16 channels of doubles, 2 GB, in segments of a second at 10 kHz; one channel is read."""
    return _tdms(folder, channels=16, segments=1600), "ai7", "16 channels, one read: under 500 MB"


def tdms(folder):
    """4 channels of doubles, 10 minutes at 10 kHz; all are read."""
    return _tdms(folder, channels=4, segments=600), "", "4 channels, all read: 100 MB/s or more"


def text(folder):
    """Time and 4 channels in text, 1 minute at 10 kHz."""
    path = folder / "record.csv"
    table = np.column_stack([np.arange(600_000) / 1e4, *[_volts(600_000) for _ in range(4)]])
    np.savetxt(path, table, "%.6f", ";", header="time [s];a;b;c;d", comments="")
    return path, "", "4 channels and time, all read"


def hdf5_2gb(folder):
    """A channel of doubles, 2 GB, whose sampling rate is stated."""
    return _hdf5(folder / "record.h5", 250_000_000), "laser", "below 1.5 times the channel"


def mat_2gb(folder):
    """The same in a MATLAB file v7.3."""
    return _hdf5(folder / "record.mat", 250_000_000), "laser", "below 1.5 times the channel"


def stamps(folder):
    """A channel of doubles, 1 GB, with a column of time."""
    return _hdf5(folder / "record.h5", 125_000_000, stamped=True), "laser", "below 1.5 times the channel"


PARTS = {part.__name__: part for part in (tdms_2gb, tdms, text, hdf5_2gb, mat_2gb, stamps)}


def _hdf5(path, n, rows=1_000_000, stamped=False):
    shape = (1, n) if path.suffix == ".mat" else (n,)
    with h5py.File(path, "w", userblock_size=512) as file:
        laser = file.create_dataset("laser", shape, "f8")
        time = file.create_dataset("time", shape, "f8") if stamped else None
        if not stamped:
            file["fs"] = [[1e4]]
        for start in range(0, n, rows):
            laser[..., start : start + rows] = _volts(rows)
            if time is not None:
                time[..., start : start + rows] = np.arange(start, start + rows) / 1e4
    return path


def _tdms(folder, channels, segments, rows=10_000):
    path = folder / "record.tdms"
    with TdmsWriter(path) as writer:
        for _ in range(segments):
            volts = _volts(rows)
            waveform = {"wf_increment": 1e-4, "wf_samples": rows, "unit_string": "V"}
            writer.write_segment([ChannelObject("daq", f"ai{i}", volts, waveform) for i in range(channels)])
    return path


def _volts(n):
    return 5 + np.cos(np.arange(n) / 1000)


def main(parts):
    for name in parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            path, channel, target = PARTS[name](Path(folder))
            size = path.stat().st_size / 1e6
            command = [sys.executable, "-c", READ, path, channel]
            printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        samples, seconds, peak, before, share = (float(x) for x in printed)
        print(
            f"{name:8s} {size:5.0f} MB, {target}: {samples:.0f} samples in {seconds:.2f} s, "
            f"{size / seconds:.0f} MB/s, peak {peak:.0f} MB, of which {before:.0f} MB before reading, "
            f"the others {share:.2f} times the channels",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:])
