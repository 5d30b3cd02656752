"""UFF58, MDF4 and WAV, through pyuff, asammdf and SciPy: signals that carry their own clock."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.records.channels import Channel, Contents, Even, Stamps
from freerock.records.headings import seconds_in, split_unit

FORMAT = "UFF58, MDF4 or WAV"
TIME_RESPONSE, UNEVEN, OF_TIME = 1, 0, 17  # func_type, abscissa_spacing and kind of abscissa of UFF58


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a UFF58, MDF4 or WAV file."""
    suffix = path.suffix.lower()
    of_format = {".wav": _wav, ".mf4": _mdf, ".mdf": _mdf}.get(suffix, _uff)
    with of_format(path) as found:
        yield found


@contextmanager
def _wav(path: Path) -> Iterator[Contents]:
    """Numbers as stored: no WAV states volts."""
    from scipy.io import wavfile

    rate, data = wavfile.read(path)
    samples = np.asarray(data).reshape(len(data), -1)
    names = [f"channel {i + 1}" for i in range(samples.shape[1])]
    found = [Channel(name, "", i, Even(1 / rate)) for i, name in enumerate(names)]
    yield Contents(
        found,
        lambda columns: {i: samples[:, i].astype(float) for i in columns},
        "WAV",
        [f"samples are {samples.dtype} as stored; the file states no unit"],
    )


@contextmanager
def _uff(path: Path) -> Iterator[Contents]:
    """Time responses (dataset 58); named by id1 where these differ, else by node and direction."""
    import pyuff

    read = pyuff.UFF(str(path)).read_sets()
    sets = [each for each in (read if isinstance(read, list) else [read]) if each.get("type") == 58]
    if not sets:
        raise FreerockError(path, "the file holds no dataset 58", "export time responses as UFF58")
    ids = [str(each.get("id1", "")).strip() for each in sets]
    telling = len({*ids}) == len(ids) and "" not in ids and "NONE" not in ids
    names = ids if telling else [_of_node(each) for each in sets]
    found = []
    for i, (name, each) in enumerate(zip(names, sets, strict=True)):
        unit = _known(each.get("abscissa_axis_units_lab"))
        clock: Even | Stamps | str
        if each["func_type"] != TIME_RESPONSE or each.get("abscissa_spec_data_type") not in (
            0,
            OF_TIME,
            None,
        ):
            clock = f"is no time response (function type {each['func_type']})"
        elif each.get("abscissa_spacing") == UNEVEN:
            clock = Stamps(f"abscissa of {name}", (i, "x"), unit or "s")
        else:
            factor = seconds_in(f"{path}: {name}", unit) if unit else 1.0
            step, start = each["abscissa_inc"], each.get("abscissa_min", 0.0)
            clock = Even(float(step) * factor, float(start) * factor)
        found.append(Channel(name, _known(each.get("ordinate_axis_units_lab")), (i, "data"), clock))

    def values(columns: Sequence[tuple[int, str]]) -> dict[tuple[int, str], Floats]:
        return {(i, what): np.real(np.asarray(sets[i][what])).astype(float) for i, what in columns}

    yield Contents(found, values, "UFF58", [])


def _known(label: object) -> str:
    """A label of UFF58; NONE stands for none."""
    text = str(label or "").strip()
    return "" if text.upper() == "NONE" else text


def _of_node(each: dict[str, Any]) -> str:
    axis = {1: "+x", 2: "+y", 3: "+z", -1: "-x", -2: "-y", -3: "-z"}.get(each.get("rsp_dir", 0), "")
    return f"{_known(each.get('rsp_ent_name'))}{each.get('rsp_node', 0)}{axis}"


@contextmanager
def _mdf(path: Path) -> Iterator[Contents]:
    """Channels of all groups with the time of their own."""
    from asammdf import MDF

    with MDF(path) as file:
        found = []
        for g, group in enumerate(cast(Any, file.groups)):
            master = file.masters_db.get(g)
            for i, channel in enumerate(group.channels):
                if i == master:
                    continue
                clock: Stamps | str = Stamps(f"time of group {g}", (g, None), "s")
                if master is None:
                    clock = "has no time"
                elif not group.channel_group.cycles_nr:
                    clock = "is empty"
                unit = channel.unit or split_unit(channel.name)[1]
                found.append(Channel(channel.name, unit, (g, i), clock, f"group {g}"))

        def values(columns: Sequence[tuple[int, int | None]]) -> dict[tuple[int, int | None], Floats]:
            read: dict[tuple[int, int | None], Floats] = {}
            for g, i in columns:
                if i is None:
                    read[g, i] = np.asarray(file.get_master(g), float)
                    continue
                signal = file.get(group=g, index=i)
                if signal.samples.dtype.kind not in "iuf" or signal.samples.ndim != 1:
                    what = f"channel {signal.name!r} holds {signal.samples.dtype}, not one number a sample"
                    raise FreerockError(path, what, "name a channel that holds numbers")
                samples = signal.samples.astype(float)
                if signal.invalidation_bits is not None:
                    samples[np.asarray(signal.invalidation_bits, bool)] = np.nan
                read[g, i] = samples
            return read

        start = file.header.start_time
        yield Contents(found, values, f"MDF {file.version}", [], start.isoformat() if start else "")
