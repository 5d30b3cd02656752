"""The scenes of `freerock simulate`: θ(t) of models, or a record as a laboratory would have it."""

import math
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.config.keys_of_scene import GROUND_COLUMNS, GroundSection, Scene
from freerock.errors import FreerockError
from freerock.models.ground import GroundMotion, accelerogram, pulse
from freerock.models.laws import LAWS, Rules
from freerock.models.simulate import Response, simulate
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.added_noise import AddedNoise
from freerock.virtual_lab.palermo import palermo_releases
from freerock.virtual_lab.virtual_record import Recording, simulate_record
from freerock.virtual_lab.write_tdms import write_tdms


def ground_motion(section: GroundSection, folder: Path) -> GroundMotion:
    """The motion of the ground that a scene in a folder describes.

    Raises
    ------
    FreerockError
        The file can't be read, or lacks a column.
    """
    if section.pulse is not None:
        own = section.pulse
        return pulse(
            own.shape, own.period_s, x=own.x_m_s2, z=own.z_m_s2, start_s=own.start_s, cycles=own.cycles
        )
    path = folder / section.file
    try:
        with warnings.catch_warnings(action="ignore"):  # of an empty file
            table = np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8-sig")
    except (OSError, ValueError, IndexError) as error:
        why = str(error).partition("\n")[0]
        remedy = f"give a CSV file with columns {', '.join(GROUND_COLUMNS)}"
        raise FreerockError(path, f"can't be read ({why})", remedy) from None
    present = table.dtype.names or ()
    missing = [name for name in GROUND_COLUMNS[:2] if name not in present]
    if missing:
        remedy = f"head its columns {', '.join(GROUND_COLUMNS)}"
        raise FreerockError(path, f"has no column {missing[0]}", remedy)
    try:
        vertical = table[GROUND_COLUMNS[2]] if GROUND_COLUMNS[2] in present else None
        return accelerogram(table[GROUND_COLUMNS[0]], table[GROUND_COLUMNS[1]], vertical)
    except FreerockError as error:
        raise FreerockError(f"{path}: {error.where}", error.what, error.remedy) from None


def simulate_scene(scene: Scene, folder: str | Path = ".") -> tuple[pd.DataFrame, dict[str, Response]]:
    """Simulate a scene with each of its models.

    Parameters
    ----------
    scene : Scene
    folder : path
        Holds the file of the ground's motion, if the scene names one.

    Returns
    -------
    frame : pandas.DataFrame
        time_s; ground_x_m_s2 and ground_z_m_s2 where the ground moves; theta_deg_<model>.
    responses : dict of str to Response
        By model.

    Raises
    ------
    FreerockError
        What the scene holds can't be simulated.
    """
    motion = ground_motion(scene.ground, Path(folder)) if scene.ground else None
    time = np.arange(round(scene.duration_s * scene.sampling_rate_hz) + 1) / scene.sampling_rate_hz
    columns = {"time_s": time}
    if motion is not None:
        columns |= dict(zip(("ground_x_m_s2", "ground_z_m_s2"), motion(time), strict=True))
    responses: dict[str, Response] = {}
    for model, parameters in scene.models.items():
        responses[model] = simulate(
            model,
            scene.block.block,
            parameters,
            time,
            theta0=math.radians(scene.release_angle_deg),
            base_excitation=motion,
            rules=Rules(scene.debonding, scene.kinematics),
        )
        columns[f"theta_deg_{model}"] = np.degrees(responses[model].theta)
    return pd.DataFrame(columns), responses


def scene_text(scene: Scene, responses: dict[str, Response]) -> str:
    """A line per model: how its motion ends, its largest angle, and how often the block changes its side."""
    critical = math.degrees(scene.block.block.theta_cr)
    lines = [f"critical angle {critical:.3f}°"]
    for model, response in responses.items():
        known = np.abs(np.degrees(response.theta[np.isfinite(response.theta)]))
        largest = f"largest angle {known.max():.4g}°" if known.size else "no motion"
        lines.append(f"{model}: {response.outcome}, {largest}, impacts: {len(response.impacts)}")
    return "\n".join(lines)


def write_scene_record(scene: Scene, path: Path) -> None:
    """Write the record of a scene with a laser, as the virtual laboratory records it, to a TDMS file."""
    assert scene.laser is not None
    ((model, parameters),) = scene.models.items()
    releases = palermo_releases(
        math.radians(scene.release_angle_deg),
        parameters,
        np.random.RandomState(scene.laser.seed),
        number=scene.laser.releases,
        scatter=0.0,
    )
    if LAWS[model].relaxes:  # no finger that leaves gradually is worked out
        releases = [replace(each, fade_s=0.0) for each in releases]
    record = simulate_record(
        scene.block.block,
        Laser(**scene.laser.model_dump(exclude={"noise_v", "seed", "releases", "uncertainty"})),
        model,
        releases,
        seed=scene.laser.seed,
        recording=Recording(
            rate_hz=scene.sampling_rate_hz,
            longest_s=scene.duration_s,
            noise=AddedNoise(white_v=scene.laser.noise_v),
        ),
        rules=Rules(scene.debonding, scene.kinematics),
    )
    write_tdms(path, record)
