from datetime import datetime, timedelta

import numpy as np
import pytest
from reading import refusal

from freerock.records.dates import start
from freerock.records.read import read_record

TIME = np.arange(50) / 1000
VOLTS = np.round(5 + np.sin(90 * TIME), 6)


def table(path, *head, delimiter=";", comma=False, encoding="utf-8", columns=(TIME, VOLTS), end="\n"):
    rows = [delimiter.join(f"{x:.6f}" for x in row) for row in zip(*columns, strict=True)]
    if comma:
        rows = [row.replace(".", ",") for row in rows]
    path.write_bytes((end.join([*head, *rows]) + end).encode(encoding))
    return path


@pytest.mark.parametrize(
    ("delimiter", "comma", "reading"),
    [
        ("\t", False, "columns between tabs, decimal point, utf-8"),
        ("\t", True, "columns between tabs, decimal comma, utf-8"),
        (";", False, "columns between semicolons, decimal point, utf-8"),
        (";", True, "columns between semicolons, decimal comma, utf-8"),
        (",", False, "columns between commas, decimal point, utf-8"),
        (", ", False, "columns between commas, decimal point, utf-8"),
        ("  ", False, "columns between spaces, decimal point, utf-8"),
        (" ", True, "columns between spaces, decimal comma, utf-8"),
    ],
)
def test_delimiter_and_decimal_mark(tmp_path, delimiter, comma, reading):
    head = delimiter.join(["time[s]", "laser[V]"])
    dataset = read_record(table(tmp_path / "a.csv", head, delimiter=delimiter, comma=comma))
    assert dataset.attrs == {"format": "text", "sampling_rate_hz": pytest.approx(1000), "reading": reading}
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
    assert dataset["laser"].attrs["units"] == "V"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends(tmp_path, encoding, end):
    path = table(tmp_path / "a.txt", "Zeit (s);Weg (µm)", comma=True, encoding=encoding, end=end)
    dataset = read_record(path, "Weg")
    np.testing.assert_array_equal(dataset["Weg"], VOLTS)
    assert dataset["Weg"].attrs["units"] == "µm"
    assert dataset.attrs["reading"] == f"columns between semicolons, decimal comma, {encoding}"


def test_headings_of_several_rows_and_a_column_of_remarks(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"{t:.6f};{v:.6f};{'release' if t == 0.02 else ''}" for t, v in zip(TIME, VOLTS, strict=True)]
    path.write_text("\n".join(["Operator: N. N.", "", "Time;Laser;Remark", "ms;V;", *rows]))
    dataset = read_record(path)
    assert list(dataset.data_vars) == ["Laser"] and dataset["Laser"].attrs["units"] == "V"
    np.testing.assert_allclose(dataset["time"], TIME / 1000, atol=1e-15)


def test_quoted_headings(tmp_path):
    dataset = read_record(table(tmp_path / "a.csv", '"Time, s","Laser, left (V)"', '"s","V"', delimiter=","))
    assert list(dataset.data_vars) == ["Laser, left"]


@pytest.mark.parametrize(
    "line", ["# fs: 200", "% Sampling rate [kHz] = 0.2", "dt;0,005 s", "Sample rate\t200 Hz"]
)
def test_stated_sampling_rate(tmp_path, line):
    path = table(tmp_path / "a.txt", line, "volts [V];second [V]", columns=(VOLTS, VOLTS[::-1]))
    dataset = read_record(path, "second")
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(200)
    assert dataset["time"][-1] == pytest.approx(49 / 200)


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("Sampling rate: 2 kS/s", 2000),
        ("fs = 2000 Samples/s", 2000),
        ("Sample rate [S/s]: 500", 500),
        ("Sample rate: 2500 samples per second", 2500),
        ("sampling frequency: 0,25 kHz", 250),
        ("fs: 0.01 MHz", 10_000),
        ("dt = 500 ns", 2e6),
        ("dt: 0,500 ms", 2000),
        ("fs: 1250,5", 1250.5),
        ("Sampling rate;2;kHz", 2000),
        ("Sampling rate;2;channels 2", 2),
        ("Sampling rate,0.5,kHz", 500),
        ("dt;500;\tus", 2000),
        ("Sampling rate;2;[kHz]", 2000),
        ("Sampling rate [kHz];2;Samples;400", 2000),
        ("Sampling rate;2000;Samples;400", 2000),
        ("Sampling interval;0.0005;Min;-10;Max;10", 2000),
        ("fs;0,5;kHz", 500),
    ],
)
def test_units_of_a_stated_sampling_rate(tmp_path, line, rate):
    path = table(tmp_path / "a.txt", line, "volts [V];second [V]", columns=(VOLTS, VOLTS[::-1]))
    assert read_record(path).attrs["sampling_rate_hz"] == pytest.approx(rate)


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("fs: 2 kN", "fs is in 'kN'; give it in Hz, kHz, MHz or samples/s"),
        ("dt = 2 h", "dt is in 'h'; give it in s, ms, us or ns"),
        (
            "Sampling rate: 2,000 Hz",
            "the comma of Sampling rate 2,000 may stand for a point, or between thousands; "
            "write the number without it",
        ),
    ],
)
def test_a_sampling_rate_that_is_not_told_is_needed_only_without_a_column_of_time(tmp_path, line, what):
    path = table(tmp_path / "a.txt", line, "volts [V];second [V]", columns=(VOLTS, VOLTS[::-1]))
    assert refusal(path) == what
    timed = table(tmp_path / "timed.txt", line, "time [s];volts [V]")
    assert read_record(timed).attrs["sampling_rate_hz"] == pytest.approx(1000)


def test_what_is_taken_for_granted_is_told(tmp_path):
    dataset = read_record(table(tmp_path / "a.txt"))
    assert dataset.attrs["reading"] == (
        "columns between semicolons, decimal point, utf-8; column 1 rises steadily and is taken for time; "
        "time has no unit and is taken for seconds"
    )
    assert list(dataset.data_vars) == ["column 2"]


def test_pairs_of_columns(tmp_path):
    head = ("A;;B;", "t [s];theta [rad];t [s];theta [rad]")
    path = table(tmp_path / "a.csv", *head, columns=(TIME, VOLTS, 2 * TIME, -VOLTS))
    assert refusal(path) == "channels of several time bases: A, B; name the channel"
    dataset = read_record(path, "B")
    np.testing.assert_array_equal(dataset["B"], -VOLTS)
    assert dataset.attrs["sampling_rate_hz"] == pytest.approx(500)
    same = table(tmp_path / "b.csv", *head, columns=(TIME, VOLTS, TIME, -VOLTS))
    assert list(read_record(same).data_vars) == ["A", "B"]


def test_empty_cells_are_missing_samples_and_gaps_are_told(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    lines = path.read_text().splitlines()
    lines[11] = lines[11].split(";")[0] + ";"
    del lines[31:34]
    path.write_text("\n".join(lines) + "\n")
    dataset = read_record(path)
    assert np.flatnonzero(np.isnan(dataset["laser"])).tolist() == [10, 30, 31, 32]
    assert dataset.attrs["time_base"] == "3 samples missing in 1 gap, the longest of 3 after 0.029 s"


def test_faults_of_the_time_column_name_it(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]", columns=(np.sin(400 * TIME), VOLTS))
    assert refusal(path).startswith("'time': time runs backwards ")


def test_a_cell_that_is_no_number(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    path.write_text(path.read_text().replace(f"{VOLTS[20]:.6f}", "5.1 V", 1))
    assert refusal(path) == (
        "line 22, column 2: '5.1 V' is not a number; correct the line, or export the file again"
    )


def test_a_row_with_too_many_cells(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    path.write_text(path.read_text().replace(f"{VOLTS[20]:.6f}", "5;1", 1))
    assert refusal(path) == "line 22 has 3 cells instead of 2; correct the line, or export the file again"


def test_a_last_line_that_is_cut_off(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    path.write_text(path.read_text()[:-9])
    assert refusal(path) == (
        "the file is truncated: its last line is incomplete; copy it again from the acquisition computer"
    )


def test_a_last_line_that_does_not_end_is_left_out(tmp_path):
    """Its number may be cut, and a rest would end in a jump."""
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    whole, text = read_record(path, "laser"), path.read_text()
    path.write_text(text[:-3])
    (cut,), (every,) = (found.data_vars.values() for found in (read_record(path, "laser"), whole))
    np.testing.assert_array_equal(cut.values, every.values[:-1])


@pytest.mark.parametrize("head", [[], ["time,volts"]])
def test_decimal_commas_between_commas(tmp_path, head):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([*head, *(f"0,{i:03d},5,{i:03d}" for i in range(20))]) + "\n")
    assert refusal(path) == (
        f"line {len(head) + 1} may hold 4 columns, or decimal commas; "
        "export with tabs or semicolons between the columns, or decimal points"
    )


def test_no_time_and_no_rate(tmp_path):
    path = table(tmp_path / "a.csv", "a;b", columns=(VOLTS, np.cos(500 * TIME)))
    assert refusal(path) == (
        "no column of time and no sampling rate; "
        "head the column of time with time [s], or state the sampling rate"
    )


def test_nothing_but_time(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];time [ms]")
    assert refusal(path) == "no channel beside the time; export at least one channel"


def test_no_table(tmp_path):
    path = tmp_path / "a.txt"
    for content in ["dear diary\nit is 3 o'clock\n", "\n", "\0\0\0"]:
        path.write_text(content)
        assert refusal(path) == (
            "no table of numbers in its first lines; "
            "export rows of numbers between tabs, semicolons or commas"
        )


def test_unknown_channel_and_unit_of_time(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];laser [V]")
    assert refusal(path, "lazer") == (
        "no channel 'lazer'; its channels are laser; correct the channel column of the campaign's CSV"
    )
    path = table(tmp_path / "b.csv", "time [h];laser [V]")
    assert refusal(path) == "the time is in 'h'; give it in s, ms, us or min"


@pytest.mark.parametrize(
    ("stamp", "delimiter", "start"),
    [
        ("2017-05-02 09:30:{:09.6f}", ";", "2017-05-02T09:30:05.000000"),
        ("2017/05/02T09:30:{:09.6f}Z", "\t", "2017-05-02T09:30:05.000000Z"),
        ("09:30:{:06.3f}", ",", None),
        ("2017-05-02 09:30:{:06.3f}", "  ", None),
    ],
)
@pytest.mark.parametrize("comma", [False, True])
def test_clock_times(tmp_path, stamp, delimiter, start, comma):
    rows = [f"{stamp.format(5 + t)}{delimiter}{v:.6f}" for t, v in zip(TIME, VOLTS, strict=True)]
    if comma and delimiter != ",":
        rows = [row.replace(".", ",") for row in rows]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([f"when{delimiter}laser [V]", *rows]) + "\n")
    dataset = read_record(path)
    assert "seconds" not in dataset.attrs["reading"]
    assert dataset.attrs.get("start_time") == start
    np.testing.assert_array_equal(next(iter(dataset.values())), VOLTS)
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)


def test_a_cell_that_is_no_time(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"09:30:{5 + t:06.3f};{v:.6f}" for t, v in zip(TIME, VOLTS, strict=True)]
    rows[40] = "soon;5.0"
    path.write_text("\n".join(rows) + "\n")
    assert refusal(path) == (
        "line 41, column 1: 'soon' is not a time; correct the line, or export the file again"
    )


def test_a_temperature_is_no_time(tmp_path):
    path = table(tmp_path / "a.csv", "time [s];T [°C];laser [V]", columns=(TIME, VOLTS, VOLTS))
    assert list(read_record(path).data_vars) == ["T", "laser"]


def clocked(path, stamps, head="when;laser [V]"):
    rows = [f"{stamp};{v:.6f}" for stamp, v in zip(stamps, VOLTS, strict=False)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def stamps(begin, form):
    """Times of a logger, each millisecond, written out as its form says."""
    times = [begin + timedelta(milliseconds=i) for i in range(len(VOLTS))]
    return [form(t).replace("FFF", f"{t.microsecond // 1000:03}") for t in times]


def german(t):
    return f"{t:%d.%m.%Y %H:%M:%S},FFF"


def american(t):
    return f"{t.month}/{t.day}/{t.year} {t.hour % 12 or 12}:{t:%M:%S}.FFF {'PM' if t.hour > 11 else 'AM'}"


def with_slashes(t):
    return f"{t:%d/%m/%Y %H:%M:%S}.FFF"


AFTERNOON = datetime(2026, 11, 22, 13, 5, 7, 123000)


@pytest.mark.parametrize(
    ("begin", "form", "start", "order"),
    [
        (AFTERNOON, german, "2026-11-22T13:05:07.123", "day, month, year"),
        (AFTERNOON, lambda t: f"{t:%d.%m.%y %H:%M:%S}.FFF", "2026-11-22T13:05:07.123", "day, month, year"),
        (AFTERNOON, lambda t: f"{t:%d.%m.%Y, %H:%M:%S},FFF", "2026-11-22T13:05:07.123", "day, month, year"),
        (AFTERNOON, american, "2026-11-22T13:05:07.123", "month, day, year"),
        (datetime(2026, 11, 22, 12, 59, 59, 980000), american, "2026-11-22T12:59:59.980", "month, day, year"),
        (datetime(2026, 11, 22), american, "2026-11-22T00:00:00.000", "month, day, year"),
        (datetime(2026, 11, 22, 23, 59, 59, 980000), american, "2026-11-22T23:59:59.980", "month, day, year"),
        (AFTERNOON, with_slashes, "2026-11-22T13:05:07.123", "day, month, year"),
        (
            datetime(2026, 12, 31, 23, 59, 59, 980000),
            with_slashes,
            "2026-12-31T23:59:59.980",
            "day, month, year",
        ),
        (datetime(2026, 4, 30, 23, 59, 59, 980000), german, "2026-04-30T23:59:59.980", "day, month, year"),
    ],
)
def test_dates_of_loggers(tmp_path, begin, form, start, order):
    dataset = read_record(clocked(tmp_path / "a.txt", stamps(begin, form)))
    assert dataset.attrs["start_time"] == start
    assert dataset.attrs["reading"].endswith(f"; dates are read as {order}")
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)
    np.testing.assert_array_equal(dataset["laser"], VOLTS)


def test_times_of_twelve_hours_without_a_date(tmp_path):
    noon = datetime(2026, 11, 22, 11, 59, 59, 980000)
    path = clocked(tmp_path / "a.txt", stamps(noon, lambda t: american(t).partition(" ")[2]))
    dataset = read_record(path)
    assert "start_time" not in dataset.attrs
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)


def test_the_order_of_a_date_that_does_not_tell_it_does_not_matter_within_a_day(tmp_path):
    dataset = read_record(clocked(tmp_path / "a.txt", stamps(datetime(2026, 4, 3, 22), with_slashes)))
    assert "start_time" not in dataset.attrs
    assert dataset.attrs["reading"] == (
        "columns between semicolons, decimal point, utf-8; "
        "the date 03/04/2026 may begin with the day or the month and is left out"
    )
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)


@pytest.mark.parametrize("form", [with_slashes, american])
def test_two_days_of_one_recording_tell_their_order(tmp_path, form):
    night = datetime(2026, 4, 3, 23, 59, 59, 980000)
    dataset = read_record(clocked(tmp_path / "a.txt", stamps(night, form)))
    assert dataset.attrs["start_time"] == "2026-04-03T23:59:59.980"
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)


def test_a_date_and_a_time_in_columns_of_their_own(tmp_path):
    cells = [stamp.replace(" ", ";") for stamp in stamps(AFTERNOON, german)]
    dataset = read_record(clocked(tmp_path / "a.csv", cells, "Datum;Uhrzeit;U / V"), "U")
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-9)
    assert dataset["U"].attrs["units"] == "V"


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (
            "03/04/2026 23:59:59.0",
            "05/06/2026 00:00:00.0",
            "the dates 03/04/2026 and 05/06/2026 may begin with the day or the month",
        ),
        ("22/11/2026 13:05:07.1", "11/22/2026 13:05:07.2", "11/22/2026 is no date of day, month, year"),
        (
            "03.04.2026 23:59:59.0",
            "03/05/2026 00:00:00.0",
            "the dates 03.04.2026 and 03/05/2026 may begin with the day or the month",
        ),
        ("31.02.2026 13:05:07.1", "31.02.2026 13:05:07.2", "31.02.2026 is no date of day, month, year"),
        (
            "22.11.2026 13:05:07.1",
            "2026-11-22 13:05:07.2",
            "'2026-11-22 13:05:07.2' is written otherwise than '22.11.2026 13:05:07.1'",
        ),
    ],
)
def test_dates_that_can_not_be_read(tmp_path, first, second, message):
    path = clocked(tmp_path / "a.csv", [first, second, second, second])
    assert refusal(path) == f"column 1: {message}; export the dates as 2026-11-22"


@pytest.mark.parametrize("second", ["13:05:07.2 PM", "1:05:07.2"])
def test_times_that_are_not_of_twelve_hours(tmp_path, second):
    path = clocked(tmp_path / "a.csv", ["1:05:07.1 PM", second, second])
    assert refusal(path) == (
        f"column 1: {second!r} is no time of a clock of 12 hours; export the times with 24 hours"
    )


def test_a_comma_between_date_and_time(tmp_path):
    cells = stamps(AFTERNOON, lambda t: f"{t:%Y-%m-%d, %H:%M:%S}.FFF")
    found = read_record(clocked(tmp_path / "a.csv", cells), "laser")
    np.testing.assert_allclose(found["time"], TIME, atol=1e-9)
    assert found.attrs["start_time"] == "2026-11-22T13:05:07.123"


def test_a_clock_of_twelve_hours_after_the_year(tmp_path):
    stamp = "2026-11-22 1:05:07 PM"
    assert refusal(clocked(tmp_path / "a.csv", [stamp] * 4)) == (
        f"column 1: {stamp!r} has a clock of 12 hours after a date that begins with the year; "
        "export the times with 24 hours"
    )
    assert start([stamp]) == ("2026-11-22T13:05:07", "")


def test_a_cell_that_is_no_time_below_dates(tmp_path):
    path = clocked(tmp_path / "a.csv", [*stamps(AFTERNOON, german)[:40], "soon"])
    assert refusal(path) == (
        "line 42, column 1: 'soon' is not a time; correct the line, or export the file again"
    )


def test_a_clock_with_a_decimal_comma_between_commas(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"13:05:07,{i:03d},5,{i:03d}" for i in range(50)]
    path.write_text("\n".join(["time,laser", *rows]) + "\n")
    assert refusal(path) == (
        "line 2 may hold 4 columns, or decimal commas; "
        "export with tabs or semicolons between the columns, or decimal points"
    )


def test_headings_of_quantity_over_unit(tmp_path):
    path = table(tmp_path / "a.csv", "t / ms;U / V;T / °C", columns=(1000 * TIME, VOLTS, VOLTS))
    dataset = read_record(path)
    assert {name: dataset[name].attrs["units"] for name in dataset} == {"U": "V", "T": "°C"}
    np.testing.assert_allclose(dataset["time"], TIME, atol=1e-12)
