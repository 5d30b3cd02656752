import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, RootObject, TdmsWriter
from reading import refusal

from freerock.errors import FreerockError
from freerock.records.read import read_record

WAVEFORM = {"wf_increment": 5e-4, "wf_start_offset": 0.25, "wf_samples": 1000, "unit_string": "V"}
VOLTS = np.linspace(1, 2, 1000)


def write(path, *channels, segments=1):
    """A TDMS file of (group, name, data, properties) channels."""
    with TdmsWriter(path) as writer:
        for _ in range(segments):
            writer.write_segment([RootObject(), *(ChannelObject(*channel) for channel in channels)])
    return path


def scaled(scale):
    """Properties of a channel of raw counts with one of NI's scales."""
    properties = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1}
    return WAVEFORM | properties | {f"NI_Scale[0]_{name}": value for name, value in scale.items()}


@pytest.fixture
def record(tmp_path):
    return write(tmp_path / "record.tdms", ("rocking", "laser", VOLTS, WAVEFORM))


def test_volts_and_time(record):
    dataset = read_record(record, "laser")
    np.testing.assert_array_equal(dataset["laser"], VOLTS)
    np.testing.assert_allclose(dataset["time"], 0.25 + 5e-4 * np.arange(1000), rtol=1e-15)
    assert dataset["laser"].attrs["units"] == "V"
    assert dataset.attrs == {"format": "TDMS", "sampling_rate_hz": 2000.0}
    assert read_record(record, "rocking/laser").identical(dataset)
    assert read_record(str(record)).identical(dataset)


def test_start_time_and_missing_start_offset(tmp_path):
    properties = {"wf_increment": 0.01, "wf_start_time": np.datetime64("2017-05-01T09:30:00", "us")}
    path = write(tmp_path / "record.TDMS", ("g", "laser", VOLTS, properties))
    dataset = read_record(path)
    assert dataset["time"][0] == 0
    assert dataset.attrs["start_time"] == "2017-05-01T09:30:00.000Z"
    assert dataset["laser"].attrs["units"] == ""


def test_linear_scaling(tmp_path):
    counts = np.arange(-5, 995, dtype=np.int32)
    linear = {"Scale_Type": "Linear", "Linear_Slope": 0.5, "Linear_Y_Intercept": 2.0}
    path = write(tmp_path / "record.tdms", ("g", "laser", counts, scaled(linear)))
    np.testing.assert_array_equal(read_record(path)["laser"], 2 + 0.5 * counts)


def test_several_segments_and_streamed_wf_samples(tmp_path):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS, WAVEFORM | {"wf_samples": 1}), segments=3)
    np.testing.assert_array_equal(read_record(path)["laser"], np.tile(VOLTS, 3))


def test_same_name_in_two_groups(tmp_path):
    path = write(tmp_path / "record.tdms", ("a", "laser", VOLTS, WAVEFORM), ("b", "laser", -VOLTS, WAVEFORM))
    assert list(read_record(path).data_vars) == ["a/laser", "b/laser"]
    np.testing.assert_array_equal(read_record(path, "b/laser")["b/laser"], -VOLTS)
    assert refusal(path, "laser").startswith("no channel 'laser'; its channels are a/laser, b/laser; ")


def test_only_numbers_are_read(tmp_path):
    note = np.array(["hand", "off"], dtype=object)
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS, WAVEFORM), ("g", "note", note, {}))
    assert list(read_record(path).data_vars) == ["laser"]
    assert refusal(path, "note") == "channel 'note' holds no real numbers; name a channel that holds numbers"


def test_missing_channel_lists_those_present(record):
    assert refusal(record, "lazer") == (
        "no channel 'lazer'; its channels are laser; correct the channel column of the campaign's CSV"
    )


def test_no_sampling_rate(tmp_path):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS, {"wf_samples": 1000}))
    assert refusal(path) == (
        "channel 'laser' gives no sampling rate (wf_increment is absent); "
        "log it as a waveform, or set its property wf_increment to the sampling interval in seconds"
    )
    zero = write(tmp_path / "zero.tdms", ("g", "laser", VOLTS, {"wf_increment": 0.0}))
    assert "(wf_increment is 0.0)" in refusal(zero)


def test_fewer_samples_than_announced(tmp_path):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS[:700], WAVEFORM))
    assert refusal(path) == (
        "the file is truncated: channel 'laser' holds 700 of 1000 samples; "
        "copy it again from the acquisition computer"
    )


def test_empty_channel(tmp_path):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS[:0], WAVEFORM))
    assert refusal(path, "laser").startswith("channel 'laser' is empty; ")
    assert refusal(path).startswith("no channel holds a number (channels: laser); ")


def test_unequal_lengths_and_rates(tmp_path):
    other = ("g", "second", VOLTS[:900], WAVEFORM | {"wf_samples": 1})
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS, WAVEFORM), other)
    assert refusal(path) == "channels of unequal length: laser 1000, second 900; name the channel"
    assert read_record(path, "laser")["laser"].size == 1000
    slow = ("g", "slow", VOLTS, WAVEFORM | {"wf_increment": 0.1})
    path = write(tmp_path / "rates.tdms", ("g", "laser", VOLTS, WAVEFORM), slow)
    assert refusal(path) == "channels of several time bases: laser, slow; name the channel"
    assert list(read_record(path, "slow").data_vars) == ["slow"]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.floats(0, 0.999))
def test_truncated_anywhere(tmp_path_factory, share):
    path = tmp_path_factory.mktemp("cut") / "record.tdms"
    write(path, ("rocking", "laser", VOLTS, WAVEFORM))
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert refusal(path, "laser").endswith("copy it again from the acquisition computer")


def test_a_truncated_file_is_told_of_once(tmp_path, capfd):
    path = tmp_path / "record.tdms"
    write(path, ("rocking", "laser", VOLTS, WAVEFORM))
    path.write_bytes(path.read_bytes()[:-100])
    assert "the file is truncated: its last segment is incomplete" in refusal(path, "laser")
    assert not capfd.readouterr().err


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 255))
def test_a_flipped_byte_never_ends_in_a_traceback(tmp_path_factory, place, flip):
    path = tmp_path_factory.mktemp("flip") / "record.tdms"
    write(path, ("rocking", "laser", VOLTS[:20], WAVEFORM | {"wf_samples": 20}))
    content = bytearray(path.read_bytes())
    content[place % len(content)] ^= flip
    path.write_bytes(content)
    try:
        read_record(path)
    except FreerockError as error:
        assert "\n" not in str(error)


def test_time_channel_beside_the_signal(tmp_path):
    time = np.arange(1000) * 2.0
    stamps = ("g", "Time", time, {"unit_string": "ms"})
    dataset = read_record(write(tmp_path / "a.tdms", stamps, ("g", "laser", VOLTS, {})))
    assert list(dataset.data_vars) == ["laser"]
    np.testing.assert_allclose(dataset["time"], time / 1000, atol=1e-12)
    dates = np.datetime64("2017-05-01T09:30:00", "us") + np.arange(1000) * np.timedelta64(500, "us")
    dataset = read_record(write(tmp_path / "b.tdms", ("g", "Time", dates, {}), ("g", "laser", VOLTS, {})))
    np.testing.assert_allclose(dataset["time"], np.arange(1000) / 2000, atol=1e-12)
    assert refusal(
        write(tmp_path / "c.tdms", ("g", "Time", time, {"unit_string": "h"}), ("g", "laser", VOLTS, {}))
    ) == ("the time is in 'h'; give it in s, ms, us or min")


def test_unset_start_time(tmp_path):
    unset = WAVEFORM | {"wf_start_time": np.datetime64("1904-01-01T00:00:00", "us")}
    assert "start_time" not in read_record(write(tmp_path / "a.tdms", ("g", "laser", VOLTS, unset))).attrs


def test_data_acquisition_scaling(tmp_path):
    """Counts of a converter, scaled by the polynomial that the driver stores."""
    counts = np.arange(-500, 500, dtype=np.int16)
    polynomial = {
        "Scale_Type": "Polynomial",
        "Polynomial_Coefficients_Size": 3,
        "Polynomial_Coefficients[0]": 1.0,
        "Polynomial_Coefficients[1]": 0.5,
        "Polynomial_Coefficients[2]": 0.25,
        "Polynomial_Input_Source": 0xFFFFFFFF,
    }
    path = write(tmp_path / "record.tdms", ("g", "laser", counts, scaled(polynomial)))
    x = counts.astype(float)
    np.testing.assert_allclose(read_record(path)["laser"], 1 + 0.5 * x + 0.25 * x**2, rtol=1e-14)


@pytest.mark.parametrize("step", [5e-324, 1e-300, 1e300, np.inf, np.nan, 0.0, -1.0])
def test_an_increment_that_is_no_interval_is_refused(tmp_path, step):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS, WAVEFORM | {"wf_increment": step}))
    assert refusal(path) == (
        f"channel 'laser' gives no sampling rate (wf_increment is {step}); log it as a waveform, or set its "
        "property wf_increment to the sampling interval in seconds"
    )


@pytest.mark.parametrize("start", [np.nan, np.inf, "noon"])
def test_a_start_offset_that_is_no_number_is_taken_for_0(tmp_path, start):
    """Two channels with it are of one time base."""
    odd = WAVEFORM | {"wf_start_offset": start}
    path = write(tmp_path / "record.tdms", ("g", "one", VOLTS, odd), ("g", "two", VOLTS, odd))
    dataset = read_record(path)
    assert dataset["time"][0] == 0
    assert dataset.attrs["reading"].startswith("wf_start_offset of one is no number and is taken for 0; ")
