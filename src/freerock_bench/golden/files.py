"""The golden solutions as files, and solutions of anybody read."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.files import atomic
from freerock_bench.golden.make import Golden
from freerock_bench.golden.scenes import Scene, instants

SOLUTIONS = Path(__file__).parent / "solutions"
NETCDF, TRAJECTORIES, EVENTS, SCENES = "golden.nc", "trajectories.csv", "events.csv", "scenes.csv"
COLUMNS = ["scene", "time_s", "theta_rad", "theta_rate_rad_s"]
NEEDED = COLUMNS[:3]
LAYOUT = "give a CSV with the columns scene, time_s, theta_rad and, if known, theta_rate_rad_s"
PARAMETERS = {"r": "r", "k": "k_n_m2", "c": "c_n_s_m2", "lambda": "lambda_n_s_m3"}
ATTRIBUTES = {
    "title": "Golden solutions of the free-rocking benchmark",
    "summary": "Rotation of rocking blocks by two independent methods that agree within 1e-11 rad",
    "license": "CC0-1.0",
    "Conventions": "CF-1.11",
    "references": "docs/benchmark.md of freerock; doi:10.1016/j.proeng.2017.09.024",
}
UNITS = {  # of the variables of the netCDF file
    "time": ("s", "time from the release"),
    "theta": ("rad", "rotation, positive clockwise"),
    "theta_rate": ("rad s-1", "angular rate"),
    "impact_time": ("s", "instant at which the rotation changes its sign"),
    "impact_rate": ("rad s-1", "angular rate then; of a rigid block before the impact"),
    "peak_time": ("s", "instant at which the angular rate changes its sign"),
    "peak_theta": ("rad", "rotation then"),
}


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
    """Write the golden solutions: one netCDF file, and the same as three tables.

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
    with atomic(folder / NETCDF) as part:
        _dataset(made, tables[SCENES]).to_netcdf(part)


def read_golden(folder: Path = SOLUTIONS) -> dict[str, Trajectory]:
    """What is quoted of each scene."""
    with xr.open_dataset(folder / NETCDF) as dataset:
        return dict(_of_dataset(dataset.load()))


def read_solution(path: str | Path) -> dict[str, Trajectory]:
    """Anybody's solutions by scene: a CSV with `COLUMNS`, or a netCDF file like `golden.nc`.

    Raises
    ------
    FreerockError
        The file can't be read, lacks a column, or holds what is no number.
    """
    path = Path(path)
    if not path.is_file():
        raise FreerockError(path, "no such file", LAYOUT)
    if path.suffix in (".nc", ".nc4"):
        return _read_netcdf(path)
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


def _read_netcdf(path: Path) -> dict[str, Trajectory]:
    layout = "give variables scene, time and theta(scene, time), as golden.nc has them"
    try:
        with xr.open_dataset(path) as dataset:
            loaded = dataset.load()
    except (OSError, ValueError) as error:
        raise FreerockError(path, "is no netCDF file", layout) from error
    for name in ("scene", "time", "theta"):
        if name not in loaded.variables:
            raise FreerockError(path, f"lacks the variable {name}", layout)
    if loaded["theta"].dims != ("scene", "time"):
        raise FreerockError(
            path, f"theta has the dimensions {', '.join(map(str, loaded['theta'].dims))}", layout
        )
    return dict(_of_dataset(loaded))


def _of_dataset(dataset: xr.Dataset) -> Iterator[tuple[str, Trajectory]]:
    """Each scene without the instants after its end."""
    time = dataset["time"].to_numpy().astype(float)
    for i, scene in enumerate(dataset["scene"].to_numpy().tolist()):
        theta = dataset["theta"].to_numpy()[i]
        end = 1 + int(np.flatnonzero(np.isfinite(theta)).max(initial=-1))
        rate = dataset["theta_rate"].to_numpy()[i][:end] if "theta_rate" in dataset else None
        yield str(scene), Trajectory(time[:end], theta[:end], rate)


def _samples(made: Golden) -> Iterator[tuple[str, float, str, str]]:
    for time, theta, rate in zip(made.time_s, made.theta_rad, made.theta_rate_rad_s, strict=True):
        yield made.scene.name, float(time), f"{theta:.14e}", f"{rate:.14e}"


def _events(made: Golden) -> Iterator[dict[str, Any]]:
    for kind, events in (("impact", made.impacts), ("peak", made.peaks)):
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
        "end_s": float(made.time_s[-1]),
        "apart_rad": f"{made.apart_rad:.1e}",
        "apart_rad_s": f"{made.apart_rad_s:.1e}",
        "apart_s": f"{made.apart_s:.1e}",
    }


def _dataset(made: Sequence[Golden], rows: pd.DataFrame) -> xr.Dataset:
    time = np.array(instants(max(each.time_s[-1] for each in made)))
    columns = {
        "theta": (("scene", "time"), _padded([each.theta_rad for each in made], time.size)),
        "theta_rate": (("scene", "time"), _padded([each.theta_rate_rad_s for each in made], time.size)),
    }
    for kind, value, part in (("impact", "impact_rate", 2), ("peak", "peak_theta", 1)):
        events = [np.array(getattr(each, f"{kind}s")).reshape(-1, 3) for each in made]
        longest = max(len(each) for each in events)
        columns[f"{kind}_time"] = (("scene", kind), _padded([each[:, 0] for each in events], longest))
        columns[value] = (("scene", kind), _padded([each[:, part] for each in events], longest))
    stated = {name: ("scene", rows[name].to_numpy()) for name in rows.columns[1:]}
    for name in ("theta0_rad", "z_cb0_m", "apart_rad", "apart_rad_s", "apart_s"):
        stated[name] = ("scene", rows[name].astype(float).to_numpy())
    dataset = xr.Dataset(columns | stated, {"scene": rows["scene"].to_numpy(), "time": time}, ATTRIBUTES)
    for name, (unit, meaning) in UNITS.items():
        dataset[name].attrs = {"units": unit, "long_name": meaning}
    return dataset


def _padded(rows: Sequence[Floats], length: int) -> Floats:
    table = np.full((len(rows), length), np.nan)
    for i, row in enumerate(rows):
        table[i, : len(row)] = row
    return table
