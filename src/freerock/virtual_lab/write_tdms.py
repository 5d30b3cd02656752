"""Records of the virtual laboratory as National Instruments' TDMS files, with their truth and checksums."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from freerock.files import atomic, write_manifest, write_text
from freerock.virtual_lab.virtual_record import VirtualRecord

GROUP, CHANNEL = "rocking", "laser"
START = "2017-05-02T09:00:00"
AUTHOR = "freerock.twin, the virtual laboratory"  # its name when the shipped files were written


def write_tdms(path: str | Path, record: VirtualRecord) -> None:
    """Write a record as NI-style TDMS: converter counts with NI's linear scaling to volts, a waveform.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter, types

    root = {
        "name": Path(path).stem,
        "title": "SIMULATED free-rocking record",
        "author": AUTHOR,
        "description": "SIMULATED laser record of a free-rocking test; nothing in it was measured.",
    }
    waveform = {
        "NI_ChannelName": CHANNEL,
        "unit_string": "V",
        "wf_start_time": np.datetime64(START, "us"),
        "wf_start_offset": 0.0,
        "wf_increment": 1 / record.truth["sampling_rate_hz"],
        "wf_samples": record.counts.size,
        "NI_Scaling_Status": "unscaled",
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": record.volts_per_count,
        "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        "NI_Scale[0]_Linear_Input_Source": types.Uint32(0xFFFFFFFF),
    }
    with atomic(path) as partial, TdmsWriter(partial) as writer:
        writer.write_segment(
            [RootObject(root), GroupObject(GROUP), ChannelObject(GROUP, CHANNEL, record.counts, waveform)]
        )


def write_records(folder: str | Path, records: Iterable[tuple[str, VirtualRecord]]) -> None:
    """Write records of named tests, as `palermo_records` gives them, with truth.json and manifest.csv.

    Raises
    ------
    FreerockError
        A file can't be written.
    """
    folder, truth = Path(folder), {}
    for test, record in records:
        write_tdms(folder / f"{test}.tdms", record)
        truth[test] = record.truth
    write_truth(folder, truth)
    write_manifest(folder, [*(f"{test}.tdms" for test in truth), "truth.json"])


def write_truth(folder: str | Path, truth: Mapping[str, Any]) -> None:
    """Write truth.json into the folder of the records: what is true of each, by test."""
    write_text(Path(folder, "truth.json"), json.dumps(truth, indent=1, ensure_ascii=False) + "\n")
