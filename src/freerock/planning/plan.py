"""A campaign before any test: how well one run of each block, angle, sensor and rate will tell a law."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.columns import table_of
from freerock.config.campaign import Campaign
from freerock.config.campaign_file import SensorSection
from freerock.config.step_settings import laboratory
from freerock.errors import FreerockError
from freerock.identification.settings import freed
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import CANDIDATES, Rules
from freerock.models.simulate import simulate
from freerock.planning.bound import ExpectedRun, information_bound
from freerock.rotation.beam import displacement_from_rotation, sensitivity
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.sensor import Laser

NAMES = ("block", "foundation", "laser")
CASE_COLUMNS = [*NAMES, "sensor", "duration_s", "sampling_rate_hz", "release_angle_deg", "model"]
NUMBERS = ("stderr", "u_total", "first_input", "first_owner", "first_share")
NONE = np.empty((0, 0))


def sigma_theta_of(sensor: SensorSection, theta0: float, block: Block, laser: Laser) -> tuple[float, str]:
    """Noise of θ at the release angle [rad], and why a sensor can't follow the block; "" where it can.

    Raises
    ------
    FreerockError
        The noise is in volts, and the laser has no scale; or the noise is not in degrees where there is
        no laser.
    """
    if sensor.noise_deg is not None:
        return math.radians(sensor.noise_deg), ""
    if laser.beam is None:
        raise FreerockError("plan.sensors", "the records hold the rotation itself", "give noise_deg")
    if sensor.range_m is not None:
        laser = replace(laser, range_m=sensor.range_m, sensitivity_per_mm=None, calibration=None)
    noise_m = sensor.noise_m or 0.0
    if sensor.noise_v is not None:
        if laser.range_m is None and laser.sensitivity_per_mm is None:
            what = "noise_v has no scale, as the laser has no range_m"
            raise FreerockError("plan.sensors", what, "give range_m or noise_m to the sensor")
        noise_m = sensor.noise_v * abs(laser.metres_per("voltage"))
    sigma = float(noise_m / sensitivity(theta0, block, laser))
    travel = np.ptp(displacement_from_rotation(np.array([theta0, -theta0, 0.0]), block, laser))
    if np.isnan(travel):
        return sigma, "the beam leaves the block"
    if laser.range_m and travel > laser.range_m:
        return sigma, f"the target moves {1e3 * travel:.0f} mm, the range is {1e3 * laser.range_m:.0f} mm"
    return sigma, ""


def plan(campaign: Campaign) -> pd.DataFrame:
    """How well one run will tell each parameter, for every combination of what a campaign may choose.

    Blocks, foundations and lasers that stand together are those of its records, which need not exist yet.

    Parameters
    ----------
    campaign : Campaign
        As loaded, with a section `plan`.

    Returns
    -------
    pandas.DataFrame
        A row per case and parameter: block, foundation, laser, sensor, duration_s, sampling_rate_hz,
        release_angle_deg, model, sigma_theta_deg (of one sample, at the release angle), parameter, unit,
        value, stderr (Cramér–Rao bound: by noise alone, inputs exact), u_total (by noise and inputs),
        first_input and first_owner (the input that matters most), first_share (the share of u_total² that
        goes where it is exact), note (why there are no numbers). Impacts are taken not to scatter.

    Raises
    ------
    FreerockError
        The campaign has no section `plan`, or one of its sensors has no scale.
    """
    section = campaign.plan
    if section is None:
        remedy = "write what is expected of each foundation, and the sensors (config/README.md)"
        raise FreerockError(f"campaign {campaign.name}: plan", "is missing", remedy)
    records = {
        (each.block, each.foundation, laser): each for each in campaign.records for laser in each.lasers
    }
    rows = list[dict[str, Any]]()
    for names, record in records.items():
        known = Laboratory.of(laboratory(campaign, record.model_copy(update={"laser": names[2]}).scene))
        block, expected = campaign.blocks[names[0]], section.expected[names[1]]
        angles = section.release_angles_deg.get(names[0]) or (block.release_angle_deg,)
        for model, angle in product(expected, angles):
            run = _expected(campaign, model, expected[model], known, math.radians(angle or 0.0))
            for duration, rate in product(section.durations_s, section.sampling_rates_hz):
                start = math.ceil(campaign.processing.runs.finger_s * rate)
                time_s = np.arange(start, math.floor(duration * rate) + 1) / rate
                case: dict[str, Any] = dict(zip(NAMES, names, strict=True))
                case |= {"duration_s": duration, "sampling_rate_hz": rate, "release_angle_deg": angle}
                rows += _rows(run, time_s, section.sensors, case)
    frame = table_of("plan", rows)
    order = np.lexsort([pd.factorize(frame[name])[0] for name in reversed(CASE_COLUMNS)])
    return frame.iloc[order].reset_index(drop=True)


def _expected(
    campaign: Campaign, model: str, known: dict[str, float], stated: Laboratory, theta0: float
) -> ExpectedRun:
    """The run that is expected of a model from a release angle [rad]."""
    values, block = {**known, "theta0": theta0}, stated.block
    if CANDIDATES[model].width:
        values["width"] = values.pop("width_fraction") * block.width_m
        stated = replace(stated, block=replace(block, contact_width_m=values["width"]))
    free = freed(model, campaign.fits.freed[CANDIDATES[model].law])
    return ExpectedRun(model, values, stated, free, campaign.fits.debonding)


def _rows(
    run: ExpectedRun, time_s: Floats, sensors: dict[str, SensorSection], case: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """The rows of one run with each sensor; names, duration, rate and angle are its case."""
    stated = run.laboratory
    fault, bound, total = _fault(run, time_s), NONE, NONE
    by_numbers, by_inputs = (NONE, NONE) if fault else run.derivatives(time_s)
    for name, sensor in sensors.items():
        laser = stated.lasers[case["laser"]]
        sigma, off = sigma_theta_of(sensor, run.values["theta0"], stated.block, laser)
        note = fault or off
        if not note:
            bound, total = (
                information_bound(by_numbers, own, sigma) for own in (by_inputs[:, :0], by_inputs)
            )
            note = "not determined by such a run" if np.isnan(total).any() else ""
        for i, parameter in enumerate(CANDIDATES[run.model].parameters):
            value, unit = run.values[parameter], PARAMETERS[parameter].unit
            own = {"sensor": name, "model": run.model, "sigma_theta_deg": math.degrees(sigma), "note": note}
            own |= {"parameter": parameter, "value": value, "unit": unit}
            numbers = (math.nan, math.nan, "", "", math.nan) if note else _numbers(run, bound, total, i)
            yield case | own | dict(zip(NUMBERS, numbers, strict=True))


def _numbers(run: ExpectedRun, bound: Floats, total: Floats, i: int) -> tuple[float, float, str, str, float]:
    """The columns `NUMBERS` of the i-th number."""
    own, n = np.diag(total), len(run.names)
    shares = total[i, n:] ** 2 / own[n:] / own[i]
    first = run.inputs[np.argmax(shares)] if shares.size else None
    told = (first.name, first.owner, float(shares.max())) if first else ("", "", math.nan)
    return math.sqrt(bound[i, i]), math.sqrt(own[i]), *told


def _fault(run: ExpectedRun, time_s: Floats) -> str:
    """Why a run can't be expected; "" where it can."""
    candidate, angle = CANDIDATES[run.model], run.values["theta0"]
    block, rules = run.laboratory.block, Rules(run.debonding, candidate.kinematics)
    outcome = simulate(candidate.law, block, run.values, time_s[-1:], theta0=angle, rules=rules).outcome
    what = f"{run.model} released at {math.degrees(angle):g}°: {outcome}"
    return "" if outcome in ("completed", "at_rest") else what
