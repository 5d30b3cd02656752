import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, RootObject, TdmsWriter
from reading import refusal

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


def test_linear_scaling(tmp_path):
    counts = np.arange(-5, 995, dtype=np.int32)
    linear = {"Scale_Type": "Linear", "Linear_Slope": 0.5, "Linear_Y_Intercept": 2.0}
    path = write(tmp_path / "record.tdms", ("g", "laser", counts, scaled(linear)))
    np.testing.assert_array_equal(read_record(path)["laser"], 2 + 0.5 * counts)


def test_missing_channel_lists_those_present(record):
    assert refusal(record, "lazer") == (
        "no channel 'lazer'; its channels are laser; "
        "name one (of a campaign in the channel column of its CSV)"
    )


def test_fewer_samples_than_announced(tmp_path):
    path = write(tmp_path / "record.tdms", ("g", "laser", VOLTS[:700], WAVEFORM))
    assert refusal(path) == (
        "the file is truncated: channel 'laser' holds 700 of 1000 samples; "
        "copy it again from the acquisition computer"
    )


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.floats(0, 0.999))
def test_truncated_anywhere(tmp_path_factory, share):
    path = tmp_path_factory.mktemp("cut") / "record.tdms"
    write(path, ("rocking", "laser", VOLTS, WAVEFORM))
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert refusal(path, "laser").endswith("copy it again from the acquisition computer")


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
        write(tmp_path / "c.tdms", ("g", "Time", time, {"unit_string": "V"}), ("g", "laser", VOLTS, {}))
    ) == ("'Time': the time is in 'V'; give it in s, ms, us or min")


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
