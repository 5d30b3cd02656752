"""A campaign before any test: how well each block, angle, sensor and sampling rate will determine a law."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from freerock.errors import FreerockError
from freerock.identification.cramer_rao import standard_errors
from freerock.models.block import Block
from freerock.models.laws import MODELS, PER_RUN, unit_of
from freerock.rotation.beam import displacement_from_rotation, sensitivity
from freerock.rotation.sensor import Laser

if TYPE_CHECKING:
    from freerock.config.campaign import Campaign

CASE = ["block", "foundation", "laser", "sensor", "duration_s", "sampling_rate_hz", "release_angle_deg"]
CASE += ["model"]
COLUMNS = [*CASE, "sigma_theta_deg", "parameter", "value", "stderr", "unit", "note"]


@dataclass(frozen=True)
class Sensor:
    """A sensor as far as planning needs it: one noise, and a range.

    Parameters
    ----------
    noise_v, noise_m, noise_deg : float, optional
        Standard deviation of its white noise: in volts, as a displacement [m], or of θ itself [°].
    range_m : float, optional
        Measuring range [m]; None is that of the laser it takes the place of.
    """

    noise_v: float | None = None
    noise_m: float | None = None
    noise_deg: float | None = None
    range_m: float | None = None

    def sigma_theta(self, theta0: float, block: Block, laser: Laser) -> tuple[float, str]:
        """Noise of θ at the release angle [rad], and why it can't follow the block; "" where it can.

        Raises
        ------
        FreerockError
            The noise is in volts, and the laser has no scale; or the noise is not in degrees where there is
            no laser.
        """
        if self.noise_deg is not None:
            return math.radians(self.noise_deg), ""
        if laser.is_rotation:
            raise FreerockError("plan.sensors", "the records hold the rotation itself", "give noise_deg")
        if self.range_m is not None:
            laser = replace(laser, range_m=self.range_m, sensitivity_per_mm=None, calibration=None)
        noise_m = self.noise_m or 0.0
        if self.noise_v is not None:
            if laser.range_m is None and laser.sensitivity_per_mm is None:
                what = "noise_v has no scale, as the laser has no range_m"
                raise FreerockError("plan.sensors", what, "give range_m or noise_m to the sensor")
            noise_m = self.noise_v * abs(laser.metres_per("voltage"))
        sigma = float(noise_m / sensitivity(theta0, block, laser))
        travel = np.ptp(displacement_from_rotation(np.array([theta0, -theta0, 0.0]), block, laser))
        if np.isnan(travel):
            return sigma, "the beam leaves the block"
        if laser.range_m and travel > laser.range_m:
            return sigma, f"the target moves {1e3 * travel:.0f} mm, the range is {1e3 * laser.range_m:.0f} mm"
        return sigma, ""


@dataclass(frozen=True)
class Setup:
    """Block, foundation and laser that stand together, and what is expected of them.

    Parameters
    ----------
    block_name, foundation, laser_name : str
    block : Block
    laser : Laser
    expected : mapping of str to mapping of str to float
        model: parameter: value [SI].
    release_angles_deg : sequence of float
        Release angles of the block [°].
    """

    block_name: str
    foundation: str
    laser_name: str
    block: Block
    laser: Laser
    expected: Mapping[str, Mapping[str, float]]
    release_angles_deg: Sequence[float]


@dataclass(frozen=True)
class Choices:
    """What a campaign may choose.

    Parameters
    ----------
    sensors : mapping of str to Sensor
        By name; each takes the place of a setup's laser.
    sampling_rates_hz : sequence of float
        Sampling rates [Hz].
    durations_s : sequence of float
        Lengths of a run from its release [s].
    finger_s : float
        Time the finger takes to leave the block, whose samples don't count [s].
    """

    sensors: Mapping[str, Sensor]
    sampling_rates_hz: Sequence[float] = (2000.0,)
    durations_s: Sequence[float] = (8.0,)
    finger_s: float = 0.03


def plan(
    setups: Iterable[Setup],
    choices: Choices,
    *,
    free: Mapping[str, Sequence[str]] | None = None,
    debonding: str = "geometric",
) -> pd.DataFrame:
    """Predicted standard errors of a campaign, for every combination of what it may choose.

    Parameters
    ----------
    setups : iterable of Setup
        Those with the names of an earlier one are left out.
    choices : Choices
    free : mapping of str to sequence of str, optional
        Nuisances fitted besides the parameters of each model; θ₀ and t₀ by default.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    pandas.DataFrame
        A row per case and parameter: block, foundation, laser, sensor, duration_s, sampling_rate_hz,
        release_angle_deg, model, sigma_theta_deg (of one sample, at the release angle), parameter, value,
        stderr, unit, note (why there is no standard error).
    """
    rows: list[tuple[Any, ...]] = []
    seen = set()
    for setup in setups:
        names = setup.block_name, setup.foundation, setup.laser_name
        if names in seen:
            continue
        seen.add(names)
        for model in setup.expected:
            nuisances = PER_RUN if free is None else free[model]
            rows += _rows(setup, model, choices, nuisances, debonding)
    frame = pd.DataFrame(rows, columns=COLUMNS)
    appearance = [pd.factorize(frame[name])[0] for name in reversed(CASE)]
    return frame.iloc[np.lexsort(appearance)].reset_index(drop=True)


def _rows(
    setup: Setup, model: str, choices: Choices, free: Sequence[str], debonding: str
) -> Iterator[tuple[Any, ...]]:
    """Rows of one model on one setup."""
    parameters = setup.expected[model]
    cases = product(setup.release_angles_deg, choices.sampling_rates_hz, choices.durations_s)
    for angle, rate, duration in cases:
        time_s = np.arange(np.ceil(choices.finger_s * rate), np.floor(duration * rate) + 1) / rate
        theta0 = math.radians(angle)
        try:
            unit_errors = standard_errors(
                model, setup.block, parameters, time_s, theta0, 1.0, free=free, debonding=debonding
            )
            fault = "" if np.isfinite([*unit_errors.values()]).all() else "not determined by such a run"
        except FreerockError as error:
            unit_errors, fault = dict.fromkeys(parameters, np.nan), error.what
        for sensor_name, sensor in choices.sensors.items():
            sigma, off = sensor.sigma_theta(theta0, setup.block, setup.laser)
            names = setup.block_name, setup.foundation, setup.laser_name
            case = (*names, sensor_name, duration, rate, angle, model, math.degrees(sigma))
            for name in MODELS[model]:
                stderr = np.nan if off else unit_errors[name] * sigma
                yield (*case, name, parameters[name], stderr, unit_of(name), fault or off)


def plan_campaign(campaign: "Campaign") -> pd.DataFrame:
    """`plan` of a campaign as loaded: the setups are those of its records, which need not exist yet.

    A restitution per impact is planned as one r, that of `plan.expected`.

    Raises
    ------
    FreerockError
        The campaign has no section `plan`, or one of its sensors has no scale.
    """
    section = campaign.plan
    if section is None:
        remedy = "write what is expected of each foundation, and the sensors (config/README.md)"
        raise FreerockError(f"{campaign.name}.yaml: plan", "is missing", remedy)
    nominal = {name: block.release_angle_deg for name, block in campaign.blocks.items()}
    angles: dict[str, Sequence[float]] = {name: (angle,) for name, angle in nominal.items() if angle}
    angles |= section.release_angles_deg
    lasers = {
        name: Laser(**laser.model_dump(exclude={"calibration"})) for name, laser in campaign.lasers.items()
    }
    setups = [
        Setup(
            each.block,
            each.foundation,
            laser,
            campaign.blocks[each.block].block,
            lasers[laser],
            section.expected[each.foundation],
            angles[each.block],
        )
        for each in campaign.records
        for laser in each.lasers
    ]
    choices = Choices(
        {name: Sensor(**sensor.model_dump()) for name, sensor in section.sensors.items()},
        section.sampling_rates_hz,
        section.durations_s,
        campaign.processing.runs.finger_s,
    )
    freed = campaign.fits.freed.items()
    free = {model: [name for name in names if name != "r_per_impact"] for model, names in freed}
    return plan(setups, choices, free=free, debonding=campaign.fits.debonding)
