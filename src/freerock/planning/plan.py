"""A campaign before any test: how well each block, angle, sensor and sampling rate will determine a law, and
which rivals they will tell from it."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from freerock.config.fit_settings import FitSettings
from freerock.config.keys_of_plan import SensorSection
from freerock.errors import FreerockError, attempt
from freerock.models.block import Block
from freerock.models.free_parameters import unit_of
from freerock.models.laws import CANDIDATES, KINEMATICS, PAPER_MODELS
from freerock.planning.cramer_rao import standard_errors
from freerock.planning.rivals import best_rival, expected_motion, rivals_of
from freerock.rotation.beam import displacement_from_rotation, sensitivity
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT, n_freed

CASE_COLUMNS = ["block", "foundation", "laser", "sensor", "duration_s", "sampling_rate_hz"]
CASE_COLUMNS += ["release_angle_deg", "model"]
COLUMNS = [
    *CASE_COLUMNS,
    "sigma_theta_deg",
    "parameter",
    "value",
    "stderr",
    "unit",
    "tilt_stderr_deg",
    "note",
]
RIVALS = [*CASE_COLUMNS, "sigma_theta_deg", "rival", "bic_difference", "epsilon_theta", "told_apart", "note"]


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
    if laser.is_rotation:
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


@dataclass(frozen=True)
class Setup:
    """Block, foundation and laser that stand together, and what is expected of them.

    Parameters
    ----------
    names : (str, str, str)
        Of its block, foundation and laser.
    laboratory : Laboratory
        What it is measured with, and how well that is known.
    expected : mapping of str to mapping of str to float
        model: parameter: value [SI]; of a model that frees the contact width also width_fraction, that width
        over the block's.
    release_angles_deg : sequence of float
        Release angles of the block [°].
    """

    names: tuple[str, str, str]
    laboratory: Laboratory
    expected: Mapping[str, Mapping[str, float]]
    release_angles_deg: Sequence[float]

    def worn(self, model: str) -> Block:
        """The block with the contact width that a model expects."""
        block = self.laboratory.block
        if not CANDIDATES[model].width:
            return block
        return replace(block, contact_width_m=self.expected[model]["width_fraction"] * block.width_m)


@dataclass(frozen=True)
class Choices:
    """What a campaign may choose, and how its runs will be fitted.

    Parameters
    ----------
    sensors : mapping of str to SensorSection
        By name; each takes the place of a setup's laser, whose range it has where it has none of its own.
    sampling_rates_hz : sequence of float
        Sampling rates [Hz].
    durations_s : sequence of float
        Lengths of a run from its release [s].
    finger_s : float
        Time the finger takes to leave the block, whose samples don't count [s].
    model_error : float
        ε_θ that even the right law is expected to leave beyond the noise, as a fraction.
    laws, kinematics : sequence of str
        Those that rivals may have (`freerock.planning.rivals.rivals_of`).
    free : mapping of str to sequence of str
        Nuisances fitted besides the parameters of each law; θ₀ and t₀ by default.
    debonding : str
        "geometric" or "tensionless".
    """

    sensors: Mapping[str, SensorSection]
    sampling_rates_hz: Sequence[float] = (2000.0,)
    durations_s: Sequence[float] = (8.0,)
    finger_s: float = 0.03
    model_error: float = 0.0
    laws: Sequence[str] = PAPER_MODELS
    kinematics: Sequence[str] = KINEMATICS
    free: Mapping[str, Sequence[str]] = field(default_factory=lambda: BY_DEFAULT.free)
    debonding: str = "geometric"

    def settings_of(self, model: str) -> FitSettings:
        """How a candidate will be fitted."""
        return FitSettings(self.free[CANDIDATES[model].law], self.debonding)


def plan(setups: Iterable[Setup], choices: Choices) -> pd.DataFrame:
    """Predicted standard errors of a campaign, for every combination of what it may choose.

    Parameters
    ----------
    setups : iterable of Setup
        Those with the names of an earlier one are left out.
    choices : Choices

    Returns
    -------
    pandas.DataFrame
        A row per case and parameter: block, foundation, laser, sensor, duration_s, sampling_rate_hz,
        release_angle_deg, model, sigma_theta_deg (of one sample, at the release angle), parameter, value,
        stderr, unit, tilt_stderr_deg (of a base off level, were a fit of this model to find it), note (why
        there is no standard error).
    """
    rows: list[tuple[Any, ...]] = []
    for setup, model, duration, angle in cases_of(setups, choices):
        block, parameters, freed = setup.worn(model), setup.expected[model], choices.settings_of(model).free
        names = CANDIDATES[model].parameters
        values = {"width": 2 * block.b, **parameters}
        for rate in choices.sampling_rates_hz:
            time_s = np.arange(np.ceil(choices.finger_s * rate), np.floor(duration * rate) + 1) / rate
            of_run = partial(standard_errors, model, block, parameters, time_s, math.radians(angle), 1.0)
            errors = partial(of_run, debonding=choices.debonding)
            unit_errors, fault = _or_why_not(errors, freed)
            if not fault and not np.isfinite([unit_errors[name] for name in names]).all():
                fault = "not determined by such a run"
            tilted, _ = _or_why_not(errors, (*freed, *({"tilt"} - {*freed})))
            unit_errors = dict.fromkeys(names, np.nan) | unit_errors | {"tilt": tilted.get("tilt", np.nan)}
            for case, sigma, off in with_each_sensor(setup, model, duration, angle, rate, choices):
                known = {name: np.nan if off else error * sigma for name, error in unit_errors.items()}
                tilt_deg, note = math.degrees(known["tilt"]), fault or off
                rows += [
                    (*case, name, values[name], known[name], unit_of(name), tilt_deg, note) for name in names
                ]
    return _in_order_of_appearance(pd.DataFrame(rows, columns=COLUMNS))


def plan_rivals(setups: Iterable[Setup], choices: Choices) -> pd.DataFrame:
    """Which rivals the runs of a campaign will tell from what is expected.

    Parameters
    ----------
    setups, choices
        As for `plan`.

    Returns
    -------
    pandas.DataFrame
        A row per case and rival: those of `plan` up to sigma_theta_deg, then rival, bic_difference (Δ of
        `freerock.planning.rivals`), epsilon_theta (between the expected motion and the rival's best,
        as a fraction), told_apart (Δ is at least 10, and ε_θ is larger than the error expected of the right
        law), note (why there is none).
    """
    rows: list[tuple[Any, ...]] = []
    for setup, model, duration, angle in cases_of(setups, choices):
        motion = expected_of(setup, model, duration, angle, choices)
        seen = [
            (rate, *each)
            for rate in choices.sampling_rates_hz
            for each in with_each_sensor(setup, model, duration, angle, rate, choices)
        ]
        for rival in rivals_of(model, choices.laws, choices.kinematics, choices.free):
            best = (
                motion
                if isinstance(motion, FreerockError)
                else best_rival(rival, setup.laboratory.block, motion, choices.settings_of(rival))
            )
            for rate, case, sigma, off in seen:
                if isinstance(best, FreerockError) or off:
                    note = best.what if isinstance(best, FreerockError) else off
                    rows.append((*case, rival, np.nan, np.nan, False, note))
                    continue
                delta = best.bic_difference(n_freed(model, choices.free), sigma, rate)
                apart = best.told_apart(delta, choices.model_error)
                rows.append((*case, rival, delta, best.epsilon_theta, apart, ""))
    return _in_order_of_appearance(pd.DataFrame(rows, columns=RIVALS))


def cases_of(setups: Iterable[Setup], choices: Choices) -> Iterator[tuple[Setup, str, float, float]]:
    """The first setup of each name, each model expected of it, length of a run [s] and release angle [°]."""
    first = {setup.names: setup for setup in reversed(list(setups))}
    for setup in reversed(first.values()):
        for case in product(setup.expected, choices.durations_s, setup.release_angles_deg):
            yield setup, *case


def _in_order_of_appearance(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows sorted case by case, the names of a case by when they first appear."""
    appearance = [pd.factorize(frame[name])[0] for name in reversed(CASE_COLUMNS)]
    return frame.iloc[np.lexsort(appearance)].reset_index(drop=True)


def _or_why_not(errors: Callable[..., dict[str, float]], free: Sequence[str]) -> tuple[dict[str, float], str]:
    """Standard errors with such nuisances, or none and why."""
    try:
        return errors(free=free), ""
    except FreerockError as error:
        return {}, error.what


def expected_of(
    setup: Setup, model: str, duration_s: float, angle_deg: float, choices: Choices
) -> Motion | FreerockError:
    """The expected motion, or why there is none."""
    theta0, span_s = math.radians(angle_deg), (choices.finger_s, duration_s)
    block, parameters = setup.worn(model), setup.expected[model]
    return attempt(expected_motion, model, block, parameters, theta0, span_s, choices.debonding)


def with_each_sensor(
    setup: Setup, model: str, duration_s: float, angle_deg: float, rate_hz: float, choices: Choices
) -> Iterator[tuple[tuple[Any, ...], float, str]]:
    """Rows of a case up to sigma_theta_deg, that noise [rad], and why the sensor won't do."""
    block, laser = setup.laboratory.block, setup.laboratory.lasers[setup.names[2]]
    for name, sensor in choices.sensors.items():
        sigma, off = sigma_theta_of(sensor, math.radians(angle_deg), block, laser)
        case = *setup.names, name, duration_s, rate_hz, angle_deg, model, math.degrees(sigma)
        yield case, sigma, off
