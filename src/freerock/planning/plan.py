"""A campaign before any test: how well each block, angle, sensor and sampling rate will determine a law, and
which rivals they will tell from it."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from freerock.config.defaults import FitSettings
from freerock.errors import FreerockError
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

BUDGET_CASE = ["block", "foundation", "laser", "duration_s", "release_angle_deg", "model"]
CASE = [*BUDGET_CASE[:3], "sensor", "duration_s", "sampling_rate_hz", *BUDGET_CASE[4:]]
COLUMNS = [*CASE, "sigma_theta_deg", "parameter", "value", "stderr", "unit", "tilt_stderr_deg", "note"]
RIVALS = [*CASE, "sigma_theta_deg", "rival", "bic_difference", "epsilon_theta", "told_apart", "note"]


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
        model: parameter: value [SI]; of a model that frees the contact width also width_fraction, that width
        over the block's.
    release_angles_deg : sequence of float
        Release angles of the block [°].
    laboratory : Laboratory, optional
        What it is measured with, and how well that is known.
    """

    block_name: str
    foundation: str
    laser_name: str
    block: Block
    laser: Laser
    expected: Mapping[str, Mapping[str, float]]
    release_angles_deg: Sequence[float]
    laboratory: Laboratory | None = None

    @property
    def names(self) -> tuple[str, str, str]:
        """Of its block, foundation and laser."""
        return self.block_name, self.foundation, self.laser_name

    def worn(self, model: str) -> Block:
        """The block with the contact width that a model expects."""
        if not CANDIDATES[model].width:
            return self.block
        return replace(
            self.block, contact_width_m=self.expected[model]["width_fraction"] * self.block.width_m
        )


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
    model_error : float
        ε_θ that even the right law is expected to leave beyond the noise, as a fraction.
    """

    sensors: Mapping[str, Sensor]
    sampling_rates_hz: Sequence[float] = (2000.0,)
    durations_s: Sequence[float] = (8.0,)
    finger_s: float = 0.03
    model_error: float = 0.0


Nuisances = Mapping[str, Sequence[str]]
"""What is fitted of each law besides its parameters."""


def plan(
    setups: Iterable[Setup],
    choices: Choices,
    *,
    free: Nuisances = BY_DEFAULT.free,
    debonding: str = "geometric",
) -> pd.DataFrame:
    """Predicted standard errors of a campaign, for every combination of what it may choose.

    Parameters
    ----------
    setups : iterable of Setup
        Those with the names of an earlier one are left out.
    choices : Choices
    free : mapping of str to sequence of str, optional
        Nuisances fitted besides the parameters of each law; θ₀ and t₀ by default.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    pandas.DataFrame
        A row per case and parameter: block, foundation, laser, sensor, duration_s, sampling_rate_hz,
        release_angle_deg, model, sigma_theta_deg (of one sample, at the release angle), parameter, value,
        stderr, unit, tilt_stderr_deg (of a base off level, were a fit of this model to find it), note (why
        there is no standard error).
    """
    rows: list[tuple[Any, ...]] = []
    for setup in different(setups):
        for model in setup.expected:
            rows += _rows(setup, model, choices, free[CANDIDATES[model].law], debonding)
    return _in_order_of_appearance(pd.DataFrame(rows, columns=COLUMNS))


def plan_rivals(
    setups: Iterable[Setup],
    choices: Choices,
    *,
    laws: Sequence[str] = PAPER_MODELS,
    kinematics: Sequence[str] = KINEMATICS,
    free: Nuisances = BY_DEFAULT.free,
    debonding: str = "geometric",
) -> pd.DataFrame:
    """Which rivals the runs of a campaign will tell from what is expected.

    Parameters
    ----------
    setups, choices, free, debonding
        As for `plan`.
    laws, kinematics : sequence of str
        Those that rivals may have (`freerock.planning.rivals.rivals_of`).

    Returns
    -------
    pandas.DataFrame
        A row per case and rival: those of `plan` up to sigma_theta_deg, then rival, bic_difference (Δ of
        `freerock.planning.rivals`), epsilon_theta (between the expected motion and the rival's best,
        as a fraction), told_apart (Δ is at least 10, and ε_θ is larger than the error expected of the right
        law), note (why there is none).
    """
    rows: list[tuple[Any, ...]] = []
    for setup in different(setups):
        for model in setup.expected:
            rows += _rival_rows(
                setup, model, rivals_of(model, laws, kinematics, free), choices, free, debonding
            )
    return _in_order_of_appearance(pd.DataFrame(rows, columns=RIVALS))


def different(setups: Iterable[Setup]) -> list[Setup]:
    """The first setup of each name."""
    return list({setup.names: setup for setup in reversed(list(setups))}.values())[::-1]


def _in_order_of_appearance(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows sorted case by case, the names of a case by when they first appear."""
    appearance = [pd.factorize(frame[name])[0] for name in reversed(CASE)]
    return frame.iloc[np.lexsort(appearance)].reset_index(drop=True)


def _rows(
    setup: Setup, model: str, choices: Choices, free: Sequence[str], debonding: str
) -> Iterator[tuple[Any, ...]]:
    """Rows of one model on one setup."""
    block, parameters = setup.worn(model), setup.expected[model]
    names = CANDIDATES[model].parameters
    values = {"width": 2 * block.b, **parameters}
    cases = product(setup.release_angles_deg, choices.sampling_rates_hz, choices.durations_s)
    for angle, rate, duration in cases:
        time_s = np.arange(np.ceil(choices.finger_s * rate), np.floor(duration * rate) + 1) / rate
        theta0 = math.radians(angle)
        errors = partial(standard_errors, model, block, parameters, time_s, theta0, 1.0, debonding=debonding)
        unit_errors, fault = _or_why_not(errors, free)
        if not fault and not np.isfinite([unit_errors[name] for name in names]).all():
            fault = "not determined by such a run"
        tilted, _ = _or_why_not(errors, (*free, *({"tilt"} - {*free})))
        unit_errors = dict.fromkeys(names, np.nan) | unit_errors | {"tilt": tilted.get("tilt", np.nan)}
        for case, sigma, off in _with_each_sensor(setup, (model, duration, angle), (rate,), choices):
            known = {name: np.nan if off else error * sigma for name, error in unit_errors.items()}
            tilt_deg = math.degrees(known["tilt"])
            for name in names:
                yield (*case, name, values[name], known[name], unit_of(name), tilt_deg, fault or off)


def _or_why_not(errors: Callable[..., dict[str, float]], free: Sequence[str]) -> tuple[dict[str, float], str]:
    """Standard errors with such nuisances, or none and why."""
    try:
        return errors(free=free), ""
    except FreerockError as error:
        return {}, error.what


def _rival_rows(
    setup: Setup, model: str, rivals: Sequence[str], choices: Choices, free: Nuisances, debonding: str
) -> Iterator[tuple[Any, ...]]:
    """Rows of the rivals of one model on one setup."""
    n = n_freed(model, free)
    for duration, angle in product(choices.durations_s, setup.release_angles_deg):
        motion, fault = expected_of(setup, model, angle, (choices.finger_s, duration), debonding)
        for rival in rivals:
            settings = FitSettings(free[CANDIDATES[rival].law], debonding)
            best = best_rival(rival, setup.block, motion, settings) if motion else None
            where = model, duration, angle
            for case, sigma, off in _with_each_sensor(setup, where, choices.sampling_rates_hz, choices):
                rate = case[CASE.index("sampling_rate_hz")]
                if best is None or off:
                    yield (*case, rival, np.nan, np.nan, False, fault or off)
                else:
                    delta = best.bic_difference(n, sigma, rate)
                    apart = best.told_apart(delta, choices.model_error)
                    yield (*case, rival, delta, best.epsilon_theta, apart, "")


def expected_of(
    setup: Setup, model: str, angle: float, span_s: tuple[float, float], debonding: str
) -> tuple[Motion | None, str]:
    """The expected motion, or why there is none."""
    block, parameters = setup.worn(model), setup.expected[model]
    try:
        return expected_motion(model, block, parameters, math.radians(angle), span_s, debonding), ""
    except FreerockError as error:
        return None, error.what


def _with_each_sensor(
    setup: Setup, case: tuple[str, float, float], rates_hz: Sequence[float], choices: Choices
) -> Iterator[tuple[tuple[Any, ...], float, str]]:
    """Rows of a case (model, duration, angle) up to sigma_theta_deg, that noise [rad], why it won't do."""
    model, duration, angle = case
    for rate, (name, sensor) in product(rates_hz, choices.sensors.items()):
        sigma, off = sensor.sigma_theta(math.radians(angle), setup.block, setup.laser)
        yield (*setup.names, name, duration, rate, angle, model, math.degrees(sigma)), sigma, off
