"""Motion capture in c3d files, through the library c3d: markers, and the plane motion of a body with some.

A marker A gives the channels A:x, A:y and A:z. A body is named with its plane (horizontal and vertical axis)
and its markers: theta:xz:A+B+C is its rotation, x:xz:A+B+C and z:xz:A+B+C are the position of their mean.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import c3d
import numpy as np

from freerock.arrays import Complexes, Floats
from freerock.errors import FreerockError
from freerock.records.channels import COPY_AGAIN, Channel, Contents, Even, check_declared, names_in_short

FORMAT = "c3d"
AXES = "xyz"
MOTIONS = ("x", "z", "theta")
WRITE_IT = "name it as theta:xz:A+B, with the horizontal and the vertical axis and two or more markers"
ROUNDS = 3  # of aligning the frames with their mean shape; the second changes less than the noise
FLAT = 1e-3  # markers that lie as close to each other as this share of their coordinates tell no rotation


class Marker(NamedTuple):
    """A coordinate of a marker."""

    point: int
    axis: int


class Body(NamedTuple):
    """A motion of the body with some markers in a plane."""

    motion: str
    plane: str
    points: tuple[int, ...]


@contextmanager
def contents(path: Path) -> Iterator[Contents]:
    """The channels of a c3d file.

    A file is truncated when it holds fewer frames than it states.
    """
    with open(path, "rb") as stream:
        file = c3d.Reader(stream)
        if file.get("POINT") is None or not file.point_used:
            raise FreerockError(path, "has no POINT section with markers", "export it with trajectories")
        labels, rate = _labels(file), float(file.point_rate)
        if not rate > 0:
            raise FreerockError(path, f"POINT:RATE is {rate:g}", "export it again with its frame rate")
        clock, units = Even(1 / rate), _text(file, "POINT:UNITS")
        several = [each for each in dict.fromkeys(labels) if each and labels.count(each) > 1]
        doubled = [f"several markers are called {each!r}: passed over" for each in several]
        notes = [*doubled]

        def computed(name: str) -> Channel | None:
            _check_single(path, name.rpartition(":")[0], labels)
            body = _body(path, name, labels)
            return body and Channel(name, "rad" if body.motion == "theta" else units, body, clock)

        def read(columns: Sequence[Marker | Body]) -> dict[Marker | Body, Floats]:
            points, rigid = _points(path, file), list[str]()
            found = {
                c: points[:, c.point, c.axis]
                if isinstance(c, Marker)
                else _moved(path, points, c, units, rigid)
                for c in columns
            }
            notes[:] = [*doubled, *rigid]
            return found

        channels = [
            Channel(f"{label}:{axis}", units, Marker(i, j), clock)
            for i, label in enumerate(labels)
            for j, axis in enumerate(AXES)
            if label and label not in several
        ]
        yield Contents(channels, read, FORMAT, notes, computed=computed)


def _text(file: c3d.Reader, name: str) -> str:
    found = file.get(name)
    return str(found.string_value).strip(" \0") if found is not None else ""


def _labels(file: c3d.Reader) -> list[str]:
    """Names of the markers, of which a list holds 255; "" where there is none."""
    lists = ["POINT:LABELS", *(f"POINT:LABELS{i}" for i in range(2, 10))]
    found = [file.get(name) for name in lists]
    names = [str(each).strip(" \0") for some in found if some is not None for each in some.string_array]
    return names[: file.point_used]


def _check_single(path: Path, marker: str, labels: Sequence[str]) -> None:
    if marker and labels.count(marker) > 1:
        raise FreerockError(path, f"several markers are called {marker!r}", "rename them")


def _body(path: Path, name: str, labels: Sequence[str]) -> Body | None:
    """The body that a channel names; None where the name is of another form."""
    motion, colon, rest = name.partition(":")
    if motion not in MOTIONS or not colon:
        return None
    plane, _, markers = rest.partition(":")
    if len(plane) != 2 or len({*plane} & {*AXES}) != 2:
        raise FreerockError(path, f"channel {name!r} names no plane of x, y, z", WRITE_IT)
    wanted = [each.strip() for each in markers.split("+")]
    for marker in wanted:
        if marker not in labels:
            what = f"no marker {marker!r}; its markers are {names_in_short(filter(None, labels))}"
            raise FreerockError(path, what, "correct the channel and position columns of the campaign's CSV")
        _check_single(path, marker, labels)
    if len({*wanted}) < 2 or len({*wanted}) < len(wanted):
        raise FreerockError(path, f"channel {name!r} names fewer than two markers, or one twice", WRITE_IT)
    return Body(motion, plane, tuple(map(labels.index, wanted)))


def _points(path: Path, file: c3d.Reader) -> Floats:
    """Coordinates in the file's unit, shape (frames, markers, 3); NaN where a marker is not seen."""
    n, used = file.frame_count, file.point_used
    check_declared(path, 24 * used * max(n, 0))
    points = np.full((max(n, 0), used, 3), np.nan)
    done = 0
    for _, frame, _ in file.read_frames(copy=False):
        seen = frame[:, 3] >= 0
        points[done, seen] = frame[seen, :3]
        done += 1
    if done < n:
        raise FreerockError(path, f"the file is truncated: it holds {done} of {n} frames", COPY_AGAIN)
    return points


def _moved(path: Path, points: Floats, body: Body, units: str, notes: list[str]) -> Floats:
    """A motion of a body: rotation [rad] from the first whole frame, clockwise, or position of the mean."""
    across, up = map(AXES.index, body.plane)
    own = points[:, list(body.points)]
    at: Complexes = own[:, :, across] + 1j * own[:, :, up]
    whole = np.isfinite(at).all(axis=1)
    if not whole.any():
        raise FreerockError(path, "no frame shows all markers of the body", "name fewer markers")
    shape: Complexes = at[whole][0]
    if np.ptp(shape.real) + np.ptp(shape.imag) <= FLAT * np.abs(own[whole][0]).max():
        what = f"the markers coincide in the plane {body.plane}"
        raise FreerockError(path, what, "name another plane, or markers that lie apart")
    shape = shape - shape.mean()
    for _ in range(ROUNDS):
        turned, mean = _aligned(at[whole], shape)
        shape = ((at[whole] - mean[:, None]) / turned[:, None]).mean(axis=0)
    turned, mean = _aligned(at, shape)
    left = np.abs(at - mean[:, None] - turned[:, None] * shape)[np.isfinite(turned)]
    notes[:] = [f"the markers leave {np.sqrt(np.nanmean(left**2)):.2g} {units} of a rigid motion"]
    if body.motion != "theta":
        return mean.real if body.motion == "x" else mean.imag
    theta, known = np.full(len(at), np.nan), np.isfinite(turned)
    theta[known] = -np.unwrap(np.angle(turned[known]))
    return theta


def _aligned(at: Complexes, shape: Complexes) -> tuple[Complexes, Complexes]:
    """Rotation exp(iφ) and mean of a shape's points in each frame by least squares; NaN below two."""
    seen = np.isfinite(at)
    n = seen.sum(axis=1)
    few = n < 2
    weight = seen / np.maximum(n, 1)[:, None]
    here = np.where(seen, at, 0)
    centre, of_shape = (weight * here).sum(axis=1), (weight * shape).sum(axis=1)
    turned = ((here - centre[:, None]) * np.conj(shape - of_shape[:, None]) * seen).sum(axis=1)
    turned = np.where(few, np.nan, turned / np.where(few, 1, np.abs(turned)))
    return turned, centre - turned * of_shape
