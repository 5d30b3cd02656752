"""A scene to be simulated: a block, models, a release or a moving ground, and a laser that watches or none.

A scene with a laser becomes a record file as a laboratory would have it; without one θ(t) of each model.
"""

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from freerock.config.campaign import load_section
from freerock.config.keys import Debonding, Invalid, Model, Number, Positive, Section, Whole
from freerock.config.sections import BlockSection, check_parameters
from freerock.config.sensor import LaserSection

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from freerock.models.ground import GroundMotion
    from freerock.models.simulate import Response

COLUMNS = ("time_s", "x_m_s2", "z_m_s2")


class PulseSection(Section):
    """An analytic pulse of the ground."""

    shape: Literal["sine", "half_sine", "cosine"] = Field("sine", description="sine, half_sine or cosine")
    period_s: Positive = Field(description="its period in seconds")
    x_m_s2: Number = Field(0.0, description="the amplitude of the horizontal acceleration in m/s²")
    z_m_s2: Number = Field(0.0, description="the amplitude of the vertical acceleration, upward, in m/s²")
    start_s: Number = Field(0.0, description="when it starts in seconds")
    cycles: Positive | None = Field(None, description="its length in periods; left out, that of its shape")


class GroundSection(Section):
    """The motion of the ground: a pulse, or the samples of a file."""

    pulse: PulseSection | None = Field(None, description="an analytic pulse")
    file: str = Field(
        "",
        validate_default=True,
        description=f"a CSV file beside the scene with columns {', '.join(COLUMNS)} (the last optional)",
    )

    @field_validator("file")
    @classmethod
    def _one_of_the_two(cls, file: str, info: ValidationInfo) -> str:
        if file and info.data.get("pulse"):
            raise Invalid("has both a pulse and a file", "keep one of the two")
        if not file and info.data.get("pulse", ...) is None:
            raise Invalid("has neither a pulse nor a file", "give one of the two")
        return file


class VirtualLaser(LaserSection):
    """The laser that watches, and its noise."""

    noise_v: Positive = Field(0.002, description="the standard deviation of its noise in volts")
    seed: Whole = Field(0, ge=0, description="of the noise and of the operator's angles and times")
    releases: Whole = Field(3, ge=1, description="the number of releases on the record")

    @model_validator(mode="after")
    def _volts_and_a_range(self) -> Self:
        if self.units not in ("", "V") or not (self.range_m or self.sensitivity_per_mm):
            raise Invalid("the virtual laser has volts and a range", "give range_m, leave units out")
        return self


class Scene(Section):
    """What `freerock simulate` simulates."""

    block: BlockSection = Field(description="the block")
    models: dict[Model, dict[str, Positive]] = Field(
        min_length=1, description="model: parameter: value, in SI units"
    )
    release_angle_deg: Number = Field(0.0, description="the angle it is released at in degrees, or 0")
    duration_s: Positive = Field(10.0, description="how long it is followed in seconds")
    sampling_rate_hz: Positive = Field(1000.0, description="samples per second")
    debonding: Debonding = Field("geometric", description="as in a campaign's fits")
    ground: GroundSection | None = Field(None, description="the motion of the ground; left out, it rests")
    laser: VirtualLaser | None = Field(
        None, validate_default=False, description="the laser of a record; left out, θ(t) itself is written"
    )

    @field_validator("models")
    @classmethod
    def _complete(cls, models: dict[Model, dict[str, float]]) -> dict[Model, dict[str, float]]:
        for model, parameters in models.items():
            check_parameters(model, parameters)
        return models

    @field_validator("laser")
    @classmethod
    def _a_record_is_of_one_release(
        cls, laser: VirtualLaser | None, info: ValidationInfo
    ) -> VirtualLaser | None:
        if laser is None:
            return laser
        if len(info.data.get("models", ())) > 1:
            raise Invalid("a record is of one model", "keep one of the models")
        if info.data.get("ground"):
            raise Invalid("the ground of a record rests", "remove ground, or laser")
        if not info.data.get("release_angle_deg"):
            raise Invalid("nothing is released", "give release_angle_deg")
        return laser


def load_scene(path: str | Path) -> Scene:
    """Read and check a scene.

    Raises
    ------
    freerock.config.mistakes.ConfigError
        All problems of the file.
    """
    scene: Scene = load_section(Scene, path)
    return scene


def ground_motion(section: GroundSection, folder: Path) -> "GroundMotion":
    """The motion of the ground that a scene in a folder describes.

    Raises
    ------
    FreerockError
        The file can't be read, or lacks a column.
    """
    from freerock.models import ground

    if section.pulse is not None:
        own = section.pulse
        return ground.pulse(
            own.shape, own.period_s, x=own.x_m_s2, z=own.z_m_s2, start_s=own.start_s, cycles=own.cycles
        )
    import numpy as np

    from freerock.errors import FreerockError

    path = folder / section.file
    try:
        with warnings.catch_warnings(action="ignore"):  # of an empty file
            table = np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8-sig")
    except (OSError, ValueError, IndexError) as error:
        told = str(error).partition("\n")[0]
        remedy = f"give a CSV file with columns {', '.join(COLUMNS)}"
        raise FreerockError(path, f"can't be read ({told})", remedy) from None
    present = table.dtype.names or ()
    missing = [name for name in COLUMNS[:2] if name not in present]
    if missing:
        raise FreerockError(path, f"has no column {missing[0]}", f"head its columns {', '.join(COLUMNS)}")
    try:
        vertical = table[COLUMNS[2]] if COLUMNS[2] in present else None
        return ground.accelerogram(table[COLUMNS[0]], table[COLUMNS[1]], vertical)
    except FreerockError as error:
        raise FreerockError(f"{path}: {error.where}", error.what, error.remedy) from None


def simulate_scene(scene: Scene, folder: str | Path = ".") -> "tuple[pd.DataFrame, dict[str, Response]]":
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
    import numpy as np
    import pandas as pd

    from freerock.models.simulate import simulate

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
            debonding=scene.debonding,
        )
        columns[f"theta_deg_{model}"] = np.degrees(responses[model].theta)
    return pd.DataFrame(columns), responses


def scene_text(scene: Scene, responses: "dict[str, Response]") -> str:
    """A line per model: how its motion ends, its largest angle, and how often the block changes its side."""
    import numpy as np

    critical = math.degrees(scene.block.block.theta_cr)
    lines = [f"critical angle {critical:.3f}°"]
    for model, response in responses.items():
        known = np.abs(np.degrees(response.theta[np.isfinite(response.theta)]))
        largest = f"largest angle {known.max():.4g}°" if known.size else "no motion"
        lines.append(f"{model}: {response.outcome}, {largest}, impacts: {len(response.impacts)}")
    return "\n".join(lines)


def scene_figure(frame: "pd.DataFrame") -> "Figure":
    """θ(t) of each model, below the acceleration of the ground where it moves."""
    from matplotlib.figure import Figure

    from freerock.figures.style import MODEL_STYLES, footer, legend_above, styled

    styles: Any = MODEL_STYLES
    ground = [name for name in frame if name.startswith("ground") and frame[name].any()]
    with styled():
        figure = Figure(figsize=(7.0, 2.6 + 1.4 * bool(ground)), layout="constrained")
        axes = figure.subplots(1 + bool(ground), 1, squeeze=False, sharex=True)[:, 0]
        for name in ground:
            direction = "horizontal" if name == "ground_x_m_s2" else "vertical"
            axes[0].plot(frame["time_s"], frame[name], linewidth=0.8, label=direction)
            axes[0].set_ylabel("ground / (m/s²)")
            legend_above(axes[0])
        for model, style in styles.items():
            if f"theta_deg_{model}" in frame:
                axes[-1].plot(frame["time_s"], frame[f"theta_deg_{model}"], **style)
        axes[-1].set(xlabel="time / s", ylabel="θ / °")
        legend_above(axes[-1])
        footer(figure, "simulated")
    return figure


def write_scene_record(scene: Scene, path: Path) -> None:
    """Write the record of a scene with a laser, as the virtual laboratory records it, to a TDMS file."""
    import numpy as np

    from freerock.rotation.sensor import Laser
    from freerock.virtual_lab.palermo import palermo_releases
    from freerock.virtual_lab.record import Noise, Recording, simulate_record
    from freerock.virtual_lab.tdms import write_record

    assert scene.laser is not None
    ((model, parameters),) = scene.models.items()
    generator = np.random.RandomState(scene.laser.seed)
    releases = palermo_releases(
        math.radians(scene.release_angle_deg),
        parameters,
        generator,
        number=scene.laser.releases,
        scatter=0.0,
    )
    record = simulate_record(
        scene.block.block,
        Laser(**scene.laser.model_dump(exclude={"noise_v", "seed", "releases"})),
        model,
        releases,
        seed=scene.laser.seed,
        recording=Recording(
            rate_hz=scene.sampling_rate_hz,
            longest_s=scene.duration_s,
            noise=Noise(white_v=scene.laser.noise_v),
        ),
        debonding=scene.debonding,
    )
    write_record(path, record)
