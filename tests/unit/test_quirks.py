"""Files in the manner of acquisition software: right values, or a refusal with place and remedy."""

import warnings
from datetime import datetime, timedelta
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter
from openpyxl import Workbook
from reading import refusal
from scipy.io import savemat, wavfile

from freerock.errors import FreerockError
from freerock.records.cells import kind_of, mark, seconds
from freerock.records.read import list_channels, read_record

QUIRKS = Path(__file__).parents[3] / "shared/data/acquisition/quirks"
N, STEP = 40, 0.0005
TIME = np.arange(N) * STEP
VOLTS = 5 + 0.01 * np.arange(N)


def rows(line, end="\n"):
    return end.join(line(i, t, v) for i, (t, v) in enumerate(zip(TIME, VOLTS, strict=True))) + end


def plain(i, t, v):
    return f"{1e3 * t:.1f},{v:.2f}"


def comma(line):
    return lambda *sample: line(*sample).replace(".", ",")


def at(hour_ms, i):
    """A time of day so many milliseconds, and 5 for each sample, after midnight."""
    total = (hour_ms + 5 * i) % 86_400_000
    minutes, ms = divmod(total, 60_000)
    return f"{minutes // 60:02}:{minutes % 60:02}:{ms / 1000:06.3f}"


# Name: content, unit of the channel laser (name, unit), rate; all hold VOLTS but where None.
READ = {
    "unit row and blank line": ("Time,laser\n(ms),(V)\n\n" + rows(plain), "V", 2000),
    "lines end twice": ("Time [ms],laser [V]\r\r\n" + rows(plain, "\r\r\n"), "V", 2000),
    "comment and dashes": ("# Time [ms],laser [V]\n# ----,----\n" + rows(plain), "V", 2000),
    "rows end in a delimiter": ("Time [ms],laser [V]\n" + rows(lambda *s: plain(*s) + ","), "V", 2000),
    "increment of the header": (
        "X,laser,Start,Increment,\nSequence,Volt,0.0e+00,5.0e-04\n" + rows(lambda i, t, v: f"{i},{v:.2f},"),
        "Volt",
        2000,
    ),
    "increment beside the headings": (
        "Time(s),laser(V),t0 = 0.0e+00, tInc = 5.0e-04\n" + rows(lambda i, t, v: f"{t:.4f},{v:.2f},,"),
        "V",
        2000,
    ),
    "units alone": (
        "Record Length,Analog:40\nSample Interval,Analog:5.0E-04\nSecond,laser\n"
        + rows(lambda i, t, v: f"{t:.4f},{v:.2f}"),
        "",
        2000,
    ),
    "index and time": (",time [ms],laser [V]\n" + rows(lambda *s: f"{s[0]},{plain(*s)}"), "V", 2000),
    "run behind the unit": ("Time (ms) Run #1,laser (V)\n" + rows(plain), "V", 2000),
    "rate of frames": (
        "Frame rate: 200 Hz\nFrame;laser\n" + rows(lambda i, t, v: f"{i + 1};{v:.2f}"),
        "",
        200,
    ),
    "rate with thousands": (
        "Abtastrate: 20.000,00 Hz\nlaser [V];Kraft [N]\n" + rows(comma(lambda i, t, v: f"{v:.2f};1.5")),
        "V",
        20000,
    ),
    "midnight": ("Time;laser [V]\n" + rows(lambda i, t, v: f"{at(86_399_950, i)};{v:.2f}"), "V", 200),
    "noon of twelve hours": (
        "Time;laser\n" + rows(lambda i, t, v: f"{at(43_199_900, i)} {'AM' if i < 20 else 'PM'};{v:.2f}"),
        "",
        200,
    ),
    "clock set back": (
        "Time;laser\n"
        + rows(lambda i, t, v: f"2024-10-27 {at(10_799_900 - 3_600_000 * (i > 19), i)};{v:.2f}"),
        "",
        200,
    ),
    "clock of a zone": (
        "time,laser\n"
        + rows(
            lambda i, t, v: (
                f"2024-10-27T{at(10_799_900 - 3_600_000 * (i > 19), i)}+0{2 - (i > 19)}:00,{v:.2f}"
            )
        ),
        "",
        200,
    ),
    "name of the month": ("Time,laser\n" + rows(lambda i, t, v: f"14-Sep-2024 {at(0, i)},{v:.2f}"), "", 200),
    "seconds with a unit": ("Time,laser\n" + rows(lambda i, t, v: f"{t:.4g} sec,{v:.2f}"), "", 2000),
    "days and time": ("time,laser\n" + rows(lambda i, t, v: f"0 days 00:00:{t:09.6f},{v:.2f}"), "", 2000),
    "minutes and seconds": ("Time,laser\n" + rows(lambda i, t, v: f"16:{47 + t:07.4f},{v:.2f}"), "", 2000),
    "milliseconds since 1970": (
        "timestamp,laser\n" + rows(lambda i, t, v: f"{1726280207000 + 5 * i},{v:.2f}"),
        "",
        200,
    ),
    "quoted decimal commas": (
        '"Time [ms]","laser [V]"\n'
        + rows(comma(lambda i, t, v: f'"{1e3 * t:.1f}"|"{v:.2f}"')).replace("|", ","),
        "V",
        2000,
    ),
    "name is a unit": ("millis,laser\n" + rows(lambda i, t, v: f"{5 * i},{v:.2f}"), "", 200),
    "brackets after blanks": (
        "# t [ms] laser [V]\n" + rows(lambda i, t, v: f"{1e3 * t:.4f} {v:.2f}"),
        "V",
        2000,
    ),
}
REFUSED = {
    "no unit of time": (
        "time,laser\n" + rows(plain),
        "the time states no unit; write it as time [ms]",
    ),
    "unknown unit of time": (
        "Time [x],laser\n" + rows(lambda i, t, v: f"{t:.4f},{v:.2f}"),
        "the time is in 'x'; give it in s, ms",
    ),
    "index without a name": (
        ",laser\n" + rows(lambda i, t, v: f"{i},{v:.2f}"),
        "'column 1' counts the samples",
    ),
    "counter": ("Sample,laser\n" + rows(lambda i, t, v: f"{i},{v:.2f}"), "'Sample' counts the samples"),
    "no headings": (rows(plain), "no column of time and no sampling rate"),
    "heading not understood": ("Time/ms laser/V x\n" + rows(plain), "holds neither numbers nor 2 headings"),
    "rate that may be 2 Hz": (
        "Abtastrate: 2.000 Hz\nlaser [V];b [N]\n" + rows(comma(lambda i, t, v: f"{v:.2f};1.5")),
        "of Abtastrate 2.000 may stand between thousands",
    ),
    "thousands": (
        "Time [ms];laser\n" + rows(lambda i, t, v: f"{1e3 * t:.1f};5,00{i % 10}.5"),
        "line 2, column 2",
    ),
    "thousands later": (
        "Time [ms];laser\n" + rows(lambda i, t, v: f"{1e3 * t:.1f};{'1,000' if i == 30 else 999}.5"),
        "line 32, column 2: '1,000.5' has a mark between thousands",
    ),
    "unknown mark": (
        "Time [ms],laser\n" + rows(lambda i, t, v: f"{1e3 * t:.1f},{v if i else 'KO7'}"),
        "line 2 holds neither numbers nor 2 headings: '0.0,KO7'",
    ),
    "numbers beside a header": (
        "".join(
            f"{'a,1' if i < 4 else ','},,{t:.4f},{v:.2f},\n"
            for i, (t, v) in enumerate(zip(TIME, VOLTS, strict=True))
        ),
        "line 4 holds neither numbers nor 5 headings",
    ),
    "decimal mark that changes": (
        "Time [ms];laser\n"
        + rows(lambda i, t, v: comma(plain)(i, t, v) if i > 19 else f"{1e3 * t:.1f};{v:.2f}"),
        "is not a number",
    ),
}


@pytest.mark.parametrize("kind", READ)
def test_right_values(tmp_path, kind):
    content, unit, rate = READ[kind]
    path = tmp_path / "a.csv"
    path.write_bytes(content.encode())
    read = read_record(path, "laser")
    assert read["laser"].attrs["units"] == unit
    assert read.attrs["sampling_rate_hz"] == pytest.approx(rate, rel=1e-9)
    np.testing.assert_allclose(read["laser"], VOLTS, atol=1e-12)
    np.testing.assert_allclose(read["time"], np.arange(N) / rate, atol=1e-9)


@pytest.mark.parametrize("kind", REFUSED)
def test_refusals_name_place_and_remedy(tmp_path, kind):
    content, what = REFUSED[kind]
    path = tmp_path / "a.csv"
    path.write_text(content)
    said = refusal(path)
    assert what in said and ";" in said


def test_keys_state_what_a_file_does_not(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,laser\n" + rows(plain))
    assert read_record(path, time_unit="ms").attrs["sampling_rate_hz"] == pytest.approx(2000)
    path.write_text(",laser\n" + rows(lambda i, t, v: f"{i},{v:.2f}"))
    assert read_record(path, rate_hz=500.0).attrs["sampling_rate_hz"] == 500
    path.write_text("time [ms],laser\n" + rows(plain))
    for wrong in ({"time_unit": "s"}, {"rate_hz": 500.0}):
        with pytest.raises(FreerockError, match=r"time_unit is s|sampling_rate_hz states 500 Hz"):
            read_record(path, **wrong)


@pytest.mark.parametrize(
    "head",
    ["Zeit  1 - schnell [s]\tA [V]\tZeit  2 [s]\tlaser [V]", "Time (s) Run #1\tA\tTime (s) Run #2\tlaser"],
)
def test_each_channel_has_the_clock_at_its_left(tmp_path, head):
    path = tmp_path / "a.txt"
    path.write_text(
        head + "\n" + rows(lambda i, t, v: f"{t:.4f}\t1.5\t" + (f"{2 * t:.4f}\t{v:.2f}" if i < 20 else "\t"))
    )
    assert "several time bases" in refusal(path)
    read = read_record(path, "laser")
    assert read.attrs["sampling_rate_hz"] == pytest.approx(1000) and read.sizes["time"] == 20
    np.testing.assert_allclose(read["laser"], VOLTS[:20])


@pytest.mark.parametrize("text", ["OVL", "Überlauf", "1.#INF", "∞", "-OVL", "9.9E+37", "+Over"])
@pytest.mark.parametrize("place", [0, 7])
@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_marks_of_overflow_are_missing_and_counted(tmp_path, text, place, suffix):
    path = tmp_path / f"a{suffix}"
    cells = [text if i == place else v for i, v in enumerate(VOLTS)]
    if suffix == ".csv":
        path.write_text(
            "Time [s],laser [V],b\n" + "".join(f"{t:.4f},{c},1.5\n" for t, c in zip(TIME, cells, strict=True))
        )
    else:
        save(path, ["Time [s]", "laser [V]", "b"], *([t, c, 1.5] for t, c in zip(TIME, cells, strict=True)))
    laser = read_record(path)["laser"]
    assert np.flatnonzero(np.isnan(laser)).tolist() == [place] == list(laser.attrs["out_of_range"])
    np.testing.assert_array_equal(np.delete(laser.values, place), np.delete(VOLTS, place))


@pytest.mark.parametrize("text", ["#NV", "#N/A", "-", "NaN", "1.#IND", "n.a.", "########"])
def test_marks_of_missing_samples(tmp_path, text):
    path = tmp_path / "a.csv"
    path.write_text("Time [ms];laser\n" + rows(lambda i, t, v: f"{1e3 * t:.1f};{text if i == 5 else v}"))
    laser = read_record(path)["laser"]
    assert np.flatnonzero(np.isnan(laser)).tolist() == [5] and "out_of_range" not in laser.attrs


def save(path, *rows):
    book = Workbook()
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


def test_numbers_and_times_of_excel(tmp_path):
    texts = save(
        tmp_path / "a.xlsx",
        ["Time [s]", "laser"],
        *([t, f"{v:.2f}"] for t, v in zip(TIME, VOLTS, strict=True)),
    )
    read = read_record(texts)
    np.testing.assert_array_equal(read["laser"], np.round(VOLTS, 2))
    wrong = save(
        tmp_path / "b.xlsx",
        ["Time [s]", "laser"],
        *([t, f"{v:.2f}".replace(".", ",")] for t, v in zip(TIME, VOLTS, strict=True)),
    )
    assert "cell B2" in refusal(wrong)
    day = datetime(2024, 9, 14, 23, 59, 59, 900_000)
    clock = [(day + timedelta(milliseconds=5 * i)) for i in range(N)]
    for name, stamps in {
        "c": clock,
        "d": [each.time() for each in clock],
        "e": [each - day for each in clock],
    }.items():
        read = read_record(
            save(tmp_path / f"{name}.xlsx", ["Time", "laser"], *zip(stamps, VOLTS, strict=True))
        )
        assert read.attrs["sampling_rate_hz"] == pytest.approx(200)
    assert "counts the samples" in refusal(save(tmp_path / "f.xlsx", [None, "laser"], *enumerate(VOLTS)))
    assert "no unit" in refusal(save(tmp_path / "g.xlsx", ["Time", "laser"], *zip(TIME, VOLTS, strict=True)))


def test_left_out_columns_and_rows_above_are_named(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "Operator: N. N.\nDate;Time [ms];laser;remark\n"
        + rows(lambda i, t, v: f"14.09.2024;{1e3 * t:.1f};{v:.2f};ok")
    )
    found = list_channels(path)
    assert {name for name, c in found.items() if c.fault} == {"Date", "remark"}
    assert list(found.above) == ["line 1: Operator: N. N."]


def write(path, *channels):
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("g", name, values, properties) for name, values, properties in channels]
        )
    return path


def test_clocks_of_tdms(tmp_path):
    begun = np.datetime64("2024-09-14T02:16:47", "us")
    even = {"wf_increment": STEP, "wf_start_time": begun}
    late = even | {"wf_start_time": begun + np.timedelta64(1, "s")}
    path = write(tmp_path / "a.tdms", ("a", VOLTS, even), ("b", VOLTS, late))
    assert "several time bases" in refusal(path)
    assert read_record(path, "b").attrs["start_time"] == "2024-09-14T02:16:48.000Z"
    unset = {"wf_increment": 1.0, "wf_start_time": np.datetime64("1904-01-01", "us")}
    assert "gives no sampling rate" in refusal(write(tmp_path / "b.tdms", ("a", VOLTS, unset)))
    read = read_record(write(tmp_path / "c.tdms", ("Time (us)", 1e6 * TIME, {}), ("laser (V)", VOLTS, {})))
    assert read.attrs["sampling_rate_hz"] == pytest.approx(2000) and read["laser (V)"].attrs["units"] == "V"
    with TdmsWriter(tmp_path / "d.tdms") as writer:
        for step in (STEP, 2 * STEP):
            writer.write_segment([ChannelObject("g", "a", VOLTS, {"wf_increment": step})])
    assert "changes its wf_increment between segments" in refusal(tmp_path / "d.tdms")


def test_shapes_of_hdf5_and_matlab(tmp_path):
    pairs = np.array([*zip(TIME, VOLTS, strict=True)], dtype=[("time", float), ("laser", float)])
    labels = {"columns": ["time [ms]", "laser [V]"]}
    for name, data in {
        "column": {"time": TIME[:, None], "laser": VOLTS[:, None]},
        "fields": {"record": pairs},
        "labels": {"record": np.column_stack([1e3 * TIME, VOLTS])},
        "unit": {"time": 1e3 * TIME, "laser": VOLTS},
    }.items():
        with h5py.File(tmp_path / f"{name}.h5", "w") as file:
            for key, value in data.items():
                file[key] = value
                file[key].attrs.update(
                    labels if name == "labels" else {"unit": "ms"} if (name, key) == ("unit", "time") else {}
                )
        read = read_record(tmp_path / f"{name}.h5")
        assert read.attrs["sampling_rate_hz"] == pytest.approx(2000)
        np.testing.assert_array_equal(next(iter(read.values())), VOLTS)
    savemat(tmp_path / "a.mat", {"data": {"time": 1e3 * TIME, "laser": VOLTS, "fs": 2000.0}})
    read = read_record(tmp_path / "a.mat", "laser")
    assert read.attrs["sampling_rate_hz"] == pytest.approx(2000)
    savemat(tmp_path / "b.mat", {"data": np.column_stack([TIME, VOLTS])})
    assert "data(:,1), data(:,2)" in refusal(tmp_path / "b.mat")
    savemat(tmp_path / "c.mat", {"t": 1e3 * TIME, "laser": VOLTS})
    assert "states no unit" in refusal(tmp_path / "c.mat")  # 2 Hz, were it in seconds


def test_formats_that_carry_their_clock(tmp_path):
    wavfile.write(tmp_path / "a.wav", 2000, (100 * VOLTS).astype(np.int16))
    assert read_record(tmp_path / "a.wav").attrs["sampling_rate_hz"] == 2000
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append([Signal(VOLTS, TIME, name="laser", unit="V")])
        file.append([Signal(VOLTS[::2], TIME[::2], name="force", unit="N")])
        file.save(tmp_path / "a.mf4")
    read = read_record(tmp_path / "a.mf4", "laser")
    assert read["laser"].attrs["units"] == "V" and read.attrs["sampling_rate_hz"] == pytest.approx(2000)
    np.testing.assert_array_equal(read["laser"], VOLTS)
    head = ["    -1", "    58", "laser", "NONE", "NONE", "NONE", "NONE"]
    head.append("    1         0    0         0       NONE         1   3       NONE         1   3")
    head.append(f"         4{N:10}         1  0.00000e+00  5.00000e-04  0.00000e+00")
    head += [
        "        17    0    0    0                 NONE                    s",
        "         8    0    0    0                 NONE                    V",
        *["         0    0    0    0                 NONE                 NONE"] * 2,
    ]
    body = ["".join(f"{v:20.11e}" for v in VOLTS[i : i + 4]) for i in range(0, N, 4)]
    (tmp_path / "a.uff").write_text("\n".join([*head, *body, "    -1", ""]))
    read = read_record(tmp_path / "a.uff")
    assert read["laser"].attrs["units"] == "V" and read.attrs["sampling_rate_hz"] == pytest.approx(2000)
    np.testing.assert_allclose(read["laser"], VOLTS, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.dxd", b"x"), ("a.xls", b"x"), ("a.dat", b"|CF,2,1,1;"), ("a.dat", b"\0\1\2" * 50)],
)
def test_what_is_not_read_is_named(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert "export it" in refusal(path)


@given(
    st.sampled_from([" ", "", "\n", "# a remark\n", "----;----\n", "\r\r"]),
    st.sampled_from(["s", "ms", "us", "min", "sek", ""]),
    st.sampled_from(["[]", "()", "{}"]),
    st.sampled_from(["", "Operator: N. N.\n", "Sampling rate: 2000 Hz\n"]),
    st.booleans(),
    st.booleans(),
)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_mangled_heads_give_right_values_or_a_refusal(
    tmp_path, between, unit, brackets, above, trailing, marks
):
    """A right table whose head, rows and marks are written as loggers do: never other values."""
    size = {"s": 1, "sek": 1, "ms": 1e-3, "us": 1e-6, "min": 60.0}.get(unit, 1e-3)
    path = tmp_path / "a.csv"
    head = f"Time {brackets[0]}{unit}{brackets[1]};laser (V)\n" if unit else "Time;laser (V)\n"
    body = rows(lambda i, t, v: f"{t / size:.9g};{'OVL' if marks and i == 3 else f'{v:.2f}'}{';' * trailing}")
    path.write_text(above + head + (between if between.strip() or "\n" in between else "") + body, newline="")
    with warnings.catch_warnings(action="error"):
        try:
            read = read_record(path)
        except FreerockError as error:
            assert str(path) in str(error) and ";" in str(error) and (not unit and not above.startswith("S"))
            return
    assert (
        read.attrs["sampling_rate_hz"] == pytest.approx(2000, rel=1e-6)
        and read["laser"].attrs["units"] == "V"
    )
    expected = np.where((np.arange(N) == 3) & marks, np.nan, np.round(VOLTS, 2))
    np.testing.assert_array_equal(read["laser"], expected)


@given(
    st.datetimes(datetime(2001, 1, 1), datetime(2037, 1, 1)),
    st.sampled_from(
        [
            "%Y-%m-%dT%H:%M:%S.%f",
            "%Y-%m-%d %H:%M:%S.%fZ",
            "%d.%m.%Y %H:%M:%S.%f",
            "%d-%b-%Y %H:%M:%S.%f",
            "%b %d, %Y %I:%M:%S.%f %p",
        ]
    ),
    st.integers(1, 500_000),
)
@settings(max_examples=60, deadline=None)
def test_times_of_day_are_read_in_every_manner(begun, manner, step_us):
    import pandas as pd

    stamps = [(begun + timedelta(microseconds=step_us * i)).strftime(manner) for i in range(20)]
    assert all(kind_of(stamp, ".") == "c" for stamp in stamps)
    found, _, start = seconds("a.csv", pd.Series(stamps))
    np.testing.assert_allclose(found, 1e-6 * step_us * np.arange(20), atol=1e-9)
    assert start.startswith(f"{begun:%Y-%m-%dT%H:%M:%S}")


@given(st.text(max_size=12))
def test_no_number_is_taken_for_a_mark(text):
    if kind_of(text.strip(), ".") == "n":
        assert mark(text) is None


KINDS = {
    "s01_picoscope_blank_line.csv": 2000,
    "s04_trailing_delimiter_in_rows.csv": 2000,
    "s05_crcrlf.csv": 2000,
    "s07_rigol_sequence.csv": 2000,
    "s09_index_without_name.csv": "counts the samples",
    "s10_first_value_ovl.csv": 2000,
    "s12_catman_two_rates.txt": "several time bases",
    "s14_rate_german_thousands.txt": "may stand between thousands",
    "s16_midnight.csv": 200,
    "s18_iso_zone.csv": 200,
    "s20_matlab_duration.csv": 2000,
    "s22_thousands.csv": "'5,000.5' has a mark between thousands",
    "s25_overflow_midway.csv": 2000,
    "na_text.xlsx": 2000,
    "increment_changes.tdms": "wf_increment",
    "time_ms_no_unit.tdms": 2000,
    "column_n1.h5": 2000,
    "compound.h5": 2000,
    "struct_simple.mat": 2000,
}


@pytest.mark.skipif(not QUIRKS.is_dir(), reason="the example files are not here")
@pytest.mark.parametrize("name", KINDS)
def test_files_as_their_readme_says(name):
    if isinstance(KINDS[name], str):
        assert KINDS[name] in refusal(QUIRKS / name)
        return
    assert read_record(QUIRKS / name).attrs["sampling_rate_hz"] == pytest.approx(KINDS[name])
