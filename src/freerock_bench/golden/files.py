"""The golden solutions as files, and solutions of anybody read."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.files import atomic
from freerock_bench.golden.make import Golden
from freerock_bench.golden.scenes import Scene

SOLUTIONS = Path(__file__).parent / "solutions"
TRAJECTORIES, EVENTS, SCENES = "trajectories.csv", "events.csv", "scenes.csv"
COLUMNS = ["scene", "time_s", "theta_rad", "theta_rate_rad_s"]
NEEDED = COLUMNS[:3]
LAYOUT = "give a CSV with the columns scene, time_s, theta_rad and, if known, theta_rate_rad_s"
PARAMETERS = {"r": "r", "k": "k_n_m2", "c": "c_n_s_m2", "lambda": "lambda_n_s_m3"}


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


def write(made: Sequence[Golden], folder: Path = SOLUTIONS) -> None:
    """Write the golden solutions as three tables.

    Raises
    ------
    FreerockError
        The folder can't be written.
    """
    tables = {
        TRAJECTORIES: pd.DataFrame([row for each in made for row in _samples(each)], columns=COLUMNS),
        EVENTS: pd.DataFrame([row for each in made for row in _events(each)]),
        SCENES: pd.DataFrame([_row(each) for each in made]),
    }
    for name, table in tables.items():
        with atomic(folder / name) as part:
            table.to_csv(part, index=False, lineterminator="\n")


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


def _samples(made: Golden) -> Iterator[tuple[str, float, str, str]]:
    quoted = made.quoted
    for time, theta, rate in zip(quoted.time_s, quoted.theta_rad, quoted.theta_rate_rad_s, strict=True):
        yield made.scene.name, time, f"{theta:.14e}", f"{rate:.14e}"


def _events(made: Golden) -> Iterator[dict[str, Any]]:
    for kind, events in (("impact", made.quoted.impacts), ("peak", made.quoted.peaks)):
        for number, (time, theta, rate) in enumerate(events, 1):
            yield {
                "scene": made.scene.name,
                "kind": kind,
                "number": number,
                "time_s": f"{time:.13f}",
                "theta_rad": "0" if kind == "impact" else f"{theta:.14e}",
                "theta_rate_rad_s": "0" if kind == "peak" else f"{rate:.14e}",
            }


def _row(made: Golden) -> dict[str, Any]:
    """All that states a scene, and how far apart the two methods are."""
    scene: Scene = made.scene
    return {
        "scene": scene.name,
        "law": scene.law,
        "debonding": "" if scene.law == "housner" else scene.debonding,
        "kinematics": scene.kinematics,
        "height_m": scene.block.height_m,
        "width_m": scene.block.width_m,
        "mass_kg": scene.block.mass_kg,
        **{column: scene.parameters.get(name) for name, column in PARAMETERS.items()},
        "theta0_rad": repr(scene.theta0),
        "z_cb0_m": f"{made.z_cb0_m:.15e}",
        "drop_m": scene.drop_m,
        "x_peak_m_s2": scene.pulse[0],
        "z_peak_m_s2": scene.pulse[1],
        "end_s": made.quoted.time_s[-1],
        "apart_rad": f"{made.apart_rad:.1e}",
        "apart_rad_s": f"{made.apart_rad_s:.1e}",
        "apart_s": f"{made.apart_s:.1e}",
    }
