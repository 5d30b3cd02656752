"""The golden solutions as files, and solutions of anybody read."""

from pathlib import Path
from typing import NamedTuple

import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError

SOLUTIONS = Path(__file__).parent / "solutions"
TRAJECTORIES, EVENTS, SCENES = "trajectories.csv", "events.csv", "scenes.csv"
COLUMNS = ["scene", "time_s", "theta_rad", "theta_rate_rad_s"]
NEEDED = COLUMNS[:3]
LAYOUT = "give a CSV with the columns scene, time_s, theta_rad and, if known, theta_rate_rad_s"


class Trajectory(NamedTuple):
    """θ(t) of a scene.

    Parameters
    ----------
    time_s, theta_rad : ndarray, shape (n_time,)
    theta_rate_rad_s : ndarray, shape (n_time,), or None
    """

    time_s: Floats
    theta_rad: Floats
    theta_rate_rad_s: Floats | None


def read_golden() -> dict[str, Trajectory]:
    """What is quoted of each scene."""
    return read_solution(SOLUTIONS / TRAJECTORIES)


def read_solution(path: str | Path) -> dict[str, Trajectory]:
    """Anybody's solutions by scene: a CSV with `COLUMNS`.

    Raises
    ------
    FreerockError
        The file can't be read, lacks a column, or holds what is no number.
    """
    path = Path(path)
    if not path.is_file():
        raise FreerockError(path, "no such file", LAYOUT)
    try:
        frame = pd.read_csv(path, dtype={"scene": str}, comment="#")
    except (ValueError, OSError) as error:
        raise FreerockError(path, f"is no CSV: {error}", LAYOUT) from error
    if missing := [name for name in NEEDED if name not in frame]:
        raise FreerockError(path, f"lacks the column {missing[0]}", LAYOUT)
    numbers = [name for name in COLUMNS[1:] if name in frame]
    for name in numbers if len(frame) else []:
        if not pd.api.types.is_numeric_dtype(frame[name]):
            bad = frame[name][pd.to_numeric(frame[name], errors="coerce").isna() & frame[name].notna()]
            raise FreerockError(
                f"{path}, line {bad.index[0] + 2}", f"{name}: {bad.iloc[0]!r} is no number", LAYOUT
            )
    return {
        str(scene): Trajectory(
            *(rows[name].to_numpy(float) for name in numbers), *[None] * (3 - len(numbers))
        )
        for scene, rows in frame.groupby("scene", sort=False)
    }
