"""A right table, mangled in the manner of one fault: its values, or a refusal; never other values."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from freerock.errors import FreerockError
from freerock.records.read import read_record

N, RATE = 40, 2000.0
TIME = np.arange(N) / RATE
VOLTS = np.round(1000 + 40 * np.sin(np.arange(N)), 2)
UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "min": 60.0}
TIMES = ["Time [{}]", "Zeit ({})", "Temps / {}", "Tiempo_{}", "tempo ({})", "Tijd [{}]", "Czas [{}]", "t/{}"]
layouts = st.tuples(st.sampled_from(";\t|,"), st.sampled_from(".,")).filter(lambda two: two[0] != two[1])
many = settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def read_or_refused(path, text):
    """Samples of a text, NaN where one is missing; None where it is refused in one line with a remedy."""
    path.write_text(text, encoding="utf-8")
    try:
        record = read_record(path, "laser")
    except FreerockError as error:
        assert str(path) in str(error) and ";" in str(error) and "\n" not in str(error)
        return None
    assert record.attrs["sampling_rate_hz"] == pytest.approx(RATE, rel=1e-6)
    return record["laser"].values


def table(head, times, cells, layout):
    delimiter, decimal = layout
    rows = [
        f"{t}|{v}".replace(".", decimal).replace("|", delimiter) for t, v in zip(times, cells, strict=True)
    ]
    return "\n".join([head.replace("|", delimiter), *rows, ""])


def stamps(unit):
    return [f"{t / UNITS[unit]:.9g}" for t in TIME]


@many
@given(layouts, st.sampled_from(TIMES), st.sampled_from([*UNITS]))
def test_separators_decimals_languages_and_units(tmp_path, layout, heading, unit):
    text = table(f"{heading.format(unit)}|laser [mV]", stamps(unit), VOLTS, layout)
    np.testing.assert_array_equal(read_or_refused(tmp_path / "a.csv", text), VOLTS)


@many
@given(layouts, st.integers(0, N - 1), st.sampled_from([",", ".", "'", " ", "\N{NO-BREAK SPACE}"]))
def test_marks_between_thousands(tmp_path, layout, place, mark):
    cells = [f"{v:,.2f}".replace(",", mark) if i >= place else f"{v:.2f}" for i, v in enumerate(VOLTS)]
    if mark in layout:
        return
    found = read_or_refused(tmp_path / "a.csv", table("Time [ms]|laser", stamps("ms"), cells, layout))
    assert found is None or np.array_equal(found, VOLTS)


@many
@given(
    layouts,
    st.integers(0, N - 1),
    st.sampled_from(["OVL", "-OVL", "#NV", "---", "1.#INF", "Überlauf", "soon"]),
)
def test_marks_among_numbers(tmp_path, layout, place, mark):
    cells = [mark if i == place else f"{v:.2f}" for i, v in enumerate(VOLTS)]
    text = table("Time [ms]|laser", stamps("ms"), cells, layout).replace("1,#", "1.#")
    found = read_or_refused(tmp_path / "a.csv", text)
    assert (found is None) == (mark == "soon")
    if found is not None:
        np.testing.assert_array_equal(found, np.where(np.arange(N) == place, np.nan, VOLTS))


@many
@given(
    layouts,
    st.sampled_from(["Sample", "Index", "Messwert-Nr.", "", "Frame", "Échantillon"]),
    st.sampled_from(["", "Sampling rate: 2000 Hz\n", "dt = 0.0005 s\n", "Abtastrate [kHz]: 2\n"]),
)
def test_counters_are_no_time(tmp_path, layout, name, above):
    text = above + table(f"{name}|laser", range(N), VOLTS, layout)
    found = read_or_refused(tmp_path / "a.csv", text)
    assert (found is None) == (not above)
    assert found is None or np.array_equal(found, VOLTS)


@many
@given(
    layouts,
    st.sampled_from(["2000", "2.000", "2,000", "2 000", "2'000", "2.000,00", "2,000.00", "2e3"]),
    st.sampled_from(["Sampling rate: {} Hz", "Abtastrate;{} Hz", "fs = {}"]),
)
def test_rates_are_never_read_otherwise(tmp_path, layout, rate, line):
    if rate == "2.000" and layout[1] == ".":  # 2 Hz
        return
    text = line.format(rate) + "\n" + table("laser [mV]|force [N]", VOLTS, VOLTS, layout)
    found = read_or_refused(tmp_path / "a.csv", text)
    assert found is None or np.array_equal(found, VOLTS)


@many
@given(layouts, st.integers(0, N), st.booleans(), st.sampled_from(["", "22.11.2024 ", "2024-11-22T"]))
def test_clocks_over_midnight(tmp_path, layout, passed, twelve, day):
    begin = 86_400_000_000 - 500 * passed
    cells = []
    for i in range(N):
        minutes, us = divmod((begin + 500 * i) % 86_400_000_000, 60_000_000)
        hour = minutes // 60
        shown = f"{(hour - 1) % 12 + 1 if twelve else hour:02}:{minutes % 60:02}:{us / 1e6:09.6f}"
        date = day.replace("22", "23") if begin + 500 * i >= 86_400_000_000 else day
        cells.append(f"{date}{shown}{' AM' if twelve and hour < 12 else ' PM' if twelve else ''}")
    text = "\n".join(["Time;laser", *(f"{c};{v}" for c, v in zip(cells, VOLTS, strict=True)), ""])
    np.testing.assert_array_equal(read_or_refused(tmp_path / "a.csv", text), VOLTS)


@many
@given(layouts, st.integers(1, 4), st.booleans())
def test_each_clock_stays_with_its_channel(tmp_path, layout, slower, first):
    fast, slow = stamps("ms"), [f"{slower * float(t):.9g}" for t in stamps("ms")]
    pairs = [("Zeit 1 [ms]", "laser", fast, VOLTS), ("Zeit 2 [ms]", "force", slow, -VOLTS)]
    one, two = pairs if first else pairs[::-1]
    cells = [f"{v}|{t}|{w}" for v, t, w in zip(one[3], two[2], two[3], strict=True)]
    text = table(f"{one[0]}|{one[1]}|{two[0]}|{two[1]}", one[2], cells, layout)
    np.testing.assert_array_equal(read_or_refused(tmp_path / "a.csv", text), VOLTS)
