"""Markers and the plane motion of a body in c3d files, written by the library or spoilt byte by byte."""

import warnings

import c3d
import numpy as np
import pytest
from reading import refusal

from freerock.errors import FreerockError
from freerock.records.read import list_channels, read_record

N, RATE = 300, 250.0
TIME = np.arange(N) / RATE
THETA = 0.2 * np.cos(6 * TIME) + 0.03 * TIME  # clockwise
X, Z = 100 * np.sin(2 * TIME), 500 + 5 * np.cos(TIME)  # mm
SHAPE = np.array([[-200, -300], [200, -300], [200, 300], [-200, 300.0]])
OTHER = np.array([[-40, -250], [170, 60], [0, 300.0]])
BODY = "A+B+C+D"


def turned(shape, plane="xz"):
    """Trajectories (frames, markers, 3) of a shape that moves in a plane."""
    points = np.full((N, len(shape), 3), 7.0)
    s, c = np.sin(THETA)[:, None], np.cos(THETA)[:, None]
    points[:, :, "xyz".index(plane[0])] = X[:, None] + c * shape[:, 0] + s * shape[:, 1]
    points[:, :, "xyz".index(plane[1])] = Z[:, None] - s * shape[:, 0] + c * shape[:, 1]
    return points


def write(path, points, labels="ABCD", units="mm", scale=-1.0):
    """A c3d file; NaN is a marker that is not seen."""
    writer = c3d.Writer(point_rate=RATE, point_units=units, point_scale=scale)
    for frame in points:
        unseen = np.isnan(frame).any(axis=1)
        rows = np.column_stack([np.nan_to_num(frame), np.where(unseen, -1, 0), np.where(unseen, -1, 0)])
        writer.add_frames([(rows.astype(np.float32), np.zeros((0, 1)))])
    writer.set_point_labels([*labels])
    with open(path, "wb") as file, warnings.catch_warnings(action="ignore"):  # of no analog channels
        writer.write(file)
    return path


def value(path, channel):
    return read_record(path, channel)[channel].values


@pytest.mark.parametrize("plane", ["xz", "yz", "xy", "zy"])
def test_a_known_motion_is_found(tmp_path, plane):
    path = write(tmp_path / "a.c3d", turned(SHAPE, plane))
    read = read_record(path, f"theta:{plane}:{BODY}")
    assert read.attrs["format"] == "c3d" and read.attrs["sampling_rate_hz"] == RATE
    assert read[f"theta:{plane}:{BODY}"].attrs["units"] == "rad"
    np.testing.assert_allclose(value(path, f"theta:{plane}:{BODY}"), THETA - THETA[0], atol=1e-6)
    np.testing.assert_allclose(value(path, f"x:{plane}:{BODY}"), X, atol=1e-4)  # mm: 1e-7 m
    np.testing.assert_allclose(value(path, f"z:{plane}:{BODY}"), Z, atol=1e-4)


def test_a_file_in_metres_and_one_of_scaled_integers(tmp_path):
    path = write(tmp_path / "m.c3d", turned(SHAPE) / 1000, units="m")
    read = read_record(path, f"z:xz:{BODY}")
    assert read[f"z:xz:{BODY}"].attrs["units"] == "m"
    np.testing.assert_allclose(read[f"z:xz:{BODY}"], Z / 1000, atol=1e-6)
    path = write(tmp_path / "i.c3d", turned(SHAPE), scale=0.05)
    np.testing.assert_allclose(value(path, f"theta:xz:{BODY}"), THETA - THETA[0], atol=3e-4)


def test_two_turns_are_not_folded(tmp_path):
    global_turn = np.linspace(0, 4 * np.pi, N)
    at = np.stack([np.cos(global_turn), 0 * TIME, -np.sin(global_turn)], axis=1)[:, None, :]
    path = write(tmp_path / "a.c3d", np.concatenate([100 * at, -100 * at], axis=1), "AB")
    np.testing.assert_allclose(value(path, "theta:xz:A+B"), global_turn, atol=1e-5)


def test_unseen_markers_leave_the_motion_to_the_others(tmp_path):
    points = turned(OTHER)
    points[20:40, 0] = np.nan
    points[60:70, 1:] = np.nan
    path = write(tmp_path / "a.c3d", points, "ABC")
    theta = value(path, "theta:xz:A+B+C")
    lost = np.zeros(N, bool)
    lost[60:70] = True
    np.testing.assert_array_equal(np.isnan(theta), lost)
    np.testing.assert_array_equal(np.isnan(value(path, "x:xz:A+B+C")), lost)
    np.testing.assert_allclose(theta[~lost], (THETA - THETA[0])[~lost], atol=1e-6)
    known = np.isnan(value(path, "A:x"))
    assert known[20:40].all() and known.sum() == 20


def test_noise_of_the_markers_is_averaged_and_noted(tmp_path):
    noise = np.random.default_rng(1).normal(0, 0.1, (N, 4, 3))
    path = write(tmp_path / "a.c3d", turned(SHAPE) + noise)
    read = read_record(path, f"theta:xz:{BODY}")
    error = read[f"theta:xz:{BODY}"].values - THETA
    expected = 0.1 / np.sqrt((SHAPE**2).sum())  # least squares
    assert 0.85 < error.std() / expected < 1.15
    told = read.attrs["reading"]
    assert told.startswith("the markers leave 0.1") and told.endswith(" mm of a rigid motion")


def test_channels_are_the_markers(tmp_path):
    path = write(tmp_path / "a.c3d", turned(OTHER), ["block:P", "block:Q", "R"])
    assert [*list_channels(path)][:4] == ["block:P:x", "block:P:y", "block:P:z", "block:Q:x"]
    np.testing.assert_allclose(value(path, "theta:xz:block:P+block:Q+R"), THETA - THETA[0], atol=1e-6)
    np.testing.assert_allclose(value(path, "R:y"), 7.0)


WRITE_IT = "name it as theta:xz:A+B, with the horizontal and the vertical axis and two or more markers"


@pytest.mark.parametrize(
    "channel, told",
    [
        ("theta:A+B", f"channel 'theta:A+B' names no plane of x, y, z; {WRITE_IT}"),
        ("theta:zz:A+B", f"channel 'theta:zz:A+B' names no plane of x, y, z; {WRITE_IT}"),
        ("x:xz:A", f"channel 'x:xz:A' names fewer than two markers, or one twice; {WRITE_IT}"),
        ("x:xz:A+B+A", f"channel 'x:xz:A+B+A' names fewer than two markers, or one twice; {WRITE_IT}"),
        (
            "z:xz:A+Q",
            "no marker 'Q'; its markers are A, B, C, D; correct the channel and position columns of the "
            "campaign's CSV",
        ),
        ("z:xz:A+", None),
        ("Q:x", None),
    ],
)
def test_a_channel_that_is_none_is_one_line(tmp_path, channel, told):
    refused = refusal(write(tmp_path / "a.c3d", turned(SHAPE)), channel)
    assert refused == told or (told is None and refused.startswith("no "))


def test_markers_that_tell_no_rotation_are_refused(tmp_path):
    points = turned(SHAPE)
    points[:, 1] = points[:, 0] + [0, 50, 0]
    path = write(tmp_path / "a.c3d", points, "ABCC")
    assert refusal(path, "theta:xz:A+B") == (
        "the markers coincide in the plane xz; name another plane, or markers that lie apart"
    )
    assert refusal(path, "theta:xz:A+C") == "several markers are called 'C'; rename them"
    assert refusal(path, "C:x") == "several markers are called 'C'; rename them"
    assert [*list_channels(path)] == [f"{marker}:{axis}" for marker in "AB" for axis in "xyz"]
    whole = read_record(path)
    assert [*whole] == [*list_channels(path)]
    assert whole.attrs["reading"] == "several markers are called 'C': passed over"
    assert "reading" not in read_record(write(tmp_path / "c.c3d", points)).attrs
    points[: N // 2, 0], points[N // 2 :, 3] = np.nan, np.nan
    path = write(tmp_path / "b.c3d", points)
    assert refusal(path, "theta:xz:A+D") == "no frame shows all markers of the body; name fewer markers"


def test_what_is_no_c3d_is_one_line(tmp_path):
    path = tmp_path / "a.c3d"
    path.write_text("time,x\n" + "0.1,2\n" * 400)
    assert refusal(path).startswith("not a readable c3d file (")
    whole = write(path, turned(SHAPE)).read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert "the file is truncated: it holds " in refusal(path)
    path.write_bytes(whole[:700])
    assert refusal(path).endswith("copy it again from the acquisition computer")
    path.write_bytes(whole.replace(b"\x05\x01POINT", b"\x05\x01PAINT").replace(b"POINT", b"PAINT"))
    assert refusal(path) == "has no POINT section with markers; export it with trajectories"


def test_every_cut_is_refused_or_read(tmp_path):
    path = write(tmp_path / "a.c3d", turned(SHAPE)[:20])
    whole = path.read_bytes()
    for length in range(1, len(whole), 97):
        path.write_bytes(whole[:length])
        try:
            read_record(path, f"theta:xz:{BODY}")
        except FreerockError as error:
            assert "\n" not in str(error)
        else:
            assert length >= len(whole) - 512  # the padding of the last block
