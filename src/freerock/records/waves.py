"""UFF58, MDF4 and WAV, through pyuff, asammdf and SciPy: signals that carry their own clock."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import Channel, Contents, Even, Stamps, unfit
from freerock.records.headings import seconds_in, split_unit

TIME_RESPONSE, UNEVEN = 1, 0  # func_type and abscissa_spacing of UFF58
OF_TIME = (0, 17, None)  # kinds of abscissa of UFF58


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a UFF58, MDF4 or WAV file."""
    of_format = {".wav": _wav, ".mf4": _mdf, ".mdf": _mdf}.get(path.suffix.lower(), _uff)
    yield of_format(path)


def _wav(path: Path) -> Contents:
    """Numbers as stored: no WAV states volts."""
    from scipy.io import wavfile

    rate, data = wavfile.read(path)
    columns = np.asarray(data).reshape(len(data), -1).T
    found = [
        Channel(f"channel {i + 1}", "", partial(_floats, c), Even(1 / rate)) for i, c in enumerate(columns)
    ]
    return Contents(found, "WAV", [f"samples are {data.dtype} as stored; the file states no unit"])


def _uff(path: Path) -> Contents:
    """Time responses (dataset 58); named by id1, else by node and direction."""
    import pyuff

    read = pyuff.UFF(str(path)).read_sets()
    sets = [each for each in (read if isinstance(read, list) else [read]) if each.get("type") == 58]
    if not sets:
        raise FreerockError(path, "the file holds no dataset 58", "export time responses as UFF58")
    found = []
    for each in sets:
        name = _known(each.get("id1")) or _of_node(each)
        unit = _known(each.get("abscissa_axis_units_lab"))
        if each["func_type"] != TIME_RESPONSE or each.get("abscissa_spec_data_type") not in OF_TIME:
            found.append(unfit(name, f"is no time response (function type {each['func_type']})"))
            continue
        if each.get("abscissa_spacing") == UNEVEN:
            clock: Even | Stamps = Stamps(f"abscissa of {name}", partial(_floats, each["x"]), unit or "s")
        else:
            factor = seconds_in(f"{path}: {name}", unit or "s")
            clock = Even(float(each["abscissa_inc"]) * factor, float(each.get("abscissa_min", 0.0)) * factor)
        units = _known(each.get("ordinate_axis_units_lab"))
        found.append(Channel(name, units, partial(_floats, each["data"]), clock))
    return Contents(found, "UFF58", [])


def _floats(values: Any) -> Floats:
    return np.real(np.asarray(values)).astype(float)


def _known(label: object) -> str:
    """A label of UFF58; NONE stands for none."""
    text = str(label or "").strip()
    return "" if text.upper() == "NONE" else text


def _of_node(each: dict[str, Any]) -> str:
    axis = {1: "+x", 2: "+y", 3: "+z", -1: "-x", -2: "-y", -3: "-z"}.get(each.get("rsp_dir", 0), "")
    return f"{_known(each.get('rsp_ent_name'))}{each.get('rsp_node', 0)}{axis}"


def _mdf(path: Path) -> Contents:
    """Channels of all groups with the time of their own."""
    from asammdf import MDF

    with MDF(path) as file:
        found = [_of_signal(each) for each in cast(Any, file).iter_channels()]
        start = file.header.start_time
    return Contents(found, f"MDF {file.version}", [], start.isoformat() if start else "")


def _of_signal(signal: Any) -> Channel:
    """A channel of MDF, NaN where it marks samples as invalid."""
    name, group, samples = signal.name, f"group {signal.group_index}", signal.samples
    if samples.dtype.kind not in "iuf" or samples.ndim != 1:
        return unfit(name, f"holds {samples.dtype}, not one number a sample", group)
    invalid = signal.invalidation_bits
    values = _floats(samples) if invalid is None else np.where(invalid, np.nan, _floats(samples))
    time = Stamps(f"time of {group}", partial(_floats, signal.timestamps), "s")
    return Channel(name, signal.unit or split_unit(name)[1], partial(_floats, values), time, group)
