"""Ground motions in a folder: accelerograms as PEER AT2 or any table that a record may be."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError, attempt
from freerock.models.block import GRAVITY
from freerock.models.ground import GroundMotion, accelerogram
from freerock.records.at2 import read_at2
from freerock.records.read import READERS, read_record

AT2 = ".at2"
UNITS = {"g": GRAVITY, "mg": 1e-3 * GRAVITY, "m/s²": 1.0, "m/s2": 1.0, "m/s^2": 1.0}
UNITS |= {f"{size}/s{square}": by for size, by in (("cm", 1e-2), ("mm", 1e-3)) for square in ("²", "2", "^2")}
UNITS |= {"gal": 1e-2}
INTENSITIES = {"pga_g": "PGA / g", "pgv_m_s": "PGV / (m/s)"}  # of a motion
MOST = 20 * GRAVITY  # m/s²: no ground has moved so; a wrong unit does
SLOWEST_S = 0.05  # a longer sampling interval shows no ground motion


@dataclass(frozen=True)
class Accelerogram:
    """A horizontal ground acceleration.

    Parameters
    ----------
    name : str
    time_s : ndarray, shape (n,)
        Evenly spaced, from 0 [s].
    acceleration : ndarray, shape (n,)
        Of the ground, positive to the left [m/s²], as in `models.ground`.
    """

    name: str
    time_s: Floats
    acceleration: Floats

    @property
    def pga(self) -> float:
        """Peak ground acceleration [m/s²]."""
        return float(np.abs(self.acceleration).max())

    @property
    def pgv(self) -> float:
        """Peak ground velocity [m/s], by the trapezoidal rule, from a ground at rest."""
        step = self.time_s[1] - self.time_s[0]
        velocity = np.cumsum((self.acceleration[1:] + self.acceleration[:-1]) / 2) * step
        return float(np.abs(velocity).max())

    def scaled(self, scale: float) -> GroundMotion:
        """As the models take it, times a factor."""
        return accelerogram(self.time_s, scale * self.acceleration)


def ground_motions_in(folder: str | Path) -> tuple[list[Accelerogram], list[FreerockError]]:
    """The accelerograms of a folder by name, and a line for each file that is none."""
    paths = attempt(motion_files, folder)
    if isinstance(paths, FreerockError):
        return [], [paths]
    read = [attempt(read_motion, path) for path in paths]
    wrong = [each for each in read if isinstance(each, FreerockError)]
    return [each for each in read if not isinstance(each, FreerockError)], wrong


def motion_files(folder: str | Path) -> list[Path]:
    """Files of a folder that may be accelerograms, by name; each gives its motion its name.

    Raises
    ------
    FreerockError
        No such folder, no such file, or two files of one name.
    """
    if not Path(folder).is_dir():
        raise FreerockError(folder, "there is no such folder", "give the folder of the ground motions")
    paths = [path for path in sorted(Path(folder).iterdir()) if path.suffix.lower() in (AT2, *READERS)]
    paths = [path for path in paths if path.name != "manifest.csv"]
    if not paths:
        raise FreerockError(folder, "holds no ground motion", "put files as .at2 or .csv there")
    for one, other in pairwise(paths):
        if one.stem == other.stem:
            raise FreerockError(one, f"{other.name} has the same name", "rename one of the two")
    return paths


def read_motion(path: str | Path) -> Accelerogram:
    """Read an accelerogram: of a table the only channel.

    Raises
    ------
    FreerockError
        What `read_record` refuses (no time column, gaps in time), several channels, no unit or none of an
        acceleration, a sample that is no number, an acceleration that no ground has had.
    """
    if Path(path).suffix.lower() == AT2:
        time_s, values = read_at2(path)
        values = values * GRAVITY
    else:
        time_s, values = _of_table(path)
    step = float(time_s[-1] - time_s[0]) / max(1, time_s.size - 1)
    invalid = np.flatnonzero(~np.isfinite(values))
    if invalid.size:
        at = time_s[invalid[0]]
        what = f"{invalid.size} samples are no numbers, the first at {at:g} s"
        raise FreerockError(path, what, "fill the gap, or cut the record there")
    if step > SLOWEST_S:
        what = f"sampled every {step:g} s, which shows no ground motion"
        raise FreerockError(path, what, "give the unit of the time column, as time [ms]")
    largest = float(np.abs(values).max())
    if not 0 < largest < MOST:
        what = f"reaches {largest / GRAVITY:.3g} g"
        raise FreerockError(path, what, "correct the unit of the acceleration")
    return Accelerogram(Path(path).stem, time_s - time_s[0], values)


def _of_table(path: str | Path) -> tuple[Floats, Floats]:
    """Time [s] and acceleration [m/s²] of a table."""
    read = read_record(path)
    if len(read.data_vars) > 1:
        names = ", ".join(map(str, read.data_vars))
        raise FreerockError(path, f"has the channels {names}", "keep one acceleration in the file")
    (signal,) = read.data_vars.values()
    unit = str(signal.attrs["units"]).strip()
    if unit.lower() not in UNITS:
        what = f"{unit!r} is no unit of an acceleration" if unit else "states no unit of the acceleration"
        raise FreerockError(path, what, "head the column as acceleration [g] or [m/s²]")
    return read["time"].values, UNITS[unit.lower()] * np.asarray(signal.values, float)


def measures(motion: Accelerogram, scales: Sequence[float]) -> list[dict[str, float]]:
    """Intensity of a motion at each scale: PGA [g], PGV [m/s] and their ratio [s]."""
    pga, pgv = motion.pga, motion.pgv
    ratio = pgv / pga if pga else math.nan
    return [
        {"scale": scale, "pga_g": scale * pga / GRAVITY, "pgv_m_s": scale * pgv, "pgv_over_pga_s": ratio}
        for scale in scales
    ]
