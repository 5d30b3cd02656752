"""Standard errors before any test: what a sensor, a rate, a block and a release angle will tell (Cramér-Rao).

No unbiased estimate from samples θ_i with independent normal noise of standard deviation σ has a covariance
below (JᵀJ)⁻¹σ², J = ∂θ_i/∂(parameters), the nuisances θ₀ and t₀ among them as in
`freerock.identification.fit` (Rao 1945, doi:10.1007/978-1-4612-0919-5_16).
The least-squares fits reach it where the model is true and the noise white.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS, MODELS, PARAMETERS, SYMBOLS, unit_of
from freerock.models.simulate import simulate_theta
from freerock.rotation.beam import displacement_from_rotation, sensitivity
from freerock.rotation.sensor import Laser

if TYPE_CHECKING:
    from freerock.config.campaign import Campaign

RTOL = 1e-10
UNDETERMINED = 1e-14  # smallest over largest eigenvalue of the scaled information
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


def standard_errors(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time_s: NDArray[np.float64],
    theta0: float,
    sigma_theta: float,
    *,
    free: Sequence[str] = ("theta0", "t0"),
    debonding: str = "geometric",
) -> dict[str, float]:
    """Smallest standard errors with which a run can tell the parameters of a model.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.LAWS`.
    block : Block
    parameters : mapping
        The true parameters [SI].
    time_s : ndarray, shape (n_time,)
        Instants of the samples since the release [s].
    theta0 : float
        Release angle [rad].
    sigma_theta : float
        Standard deviation of the white noise of one sample [rad].
    free : sequence of str
        What is fitted besides the parameters, of "theta0", "t0" and "width" (of the corners it rocks about).
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    dict of str to float
        Standard error of each parameter and freed nuisance, in its unit; inf where the samples do not
        determine them.

    Raises
    ------
    FreerockError
        The block overturns, or the motion can't be integrated.
    """
    names = (*MODELS[model], *free)
    if len(time_s) <= len(names):
        return dict.fromkeys(names, np.inf)
    width = block.contact_width_m or block.width_m
    values = {**parameters, "width": width, "theta0": theta0, "t0": 0.0}
    steps = {name: abs(PARAMETERS[name].step) for name in names}
    for name in names:
        if PARAMETERS[name].fitted_as != "value":
            steps[name] *= values[name]

    def theta(values: Mapping[str, float]) -> NDArray[np.float64]:
        own = replace(block, contact_width_m=values["width"]) if "width" in free else block
        given = {name: values[name] for name in MODELS[model]}
        instants, start = time_s - values["t0"], values["theta0"]
        found, outcome = simulate_theta(
            model, own, given, instants, theta0=start, debonding=debonding, rtol=RTOL
        )
        if outcome not in ("completed", "at_rest"):
            what = f"{model} released at {math.degrees(theta0):g}°: {outcome}"
            raise FreerockError("plan", what, "plan for a smaller angle or a stiffer foundation")
        return found

    def derivative(name: str) -> NDArray[np.float64]:
        above, below = (values | {name: values[name] + side * steps[name]} for side in (1, -1))
        return (theta(above) - theta(below)) / (2 * steps[name])

    jacobian = np.column_stack([derivative(name) for name in names])
    scale = np.linalg.norm(jacobian, axis=0)
    if not np.all(scale > 0):
        return dict.fromkeys(names, np.inf)
    eigenvalues, vectors = np.linalg.eigh((jacobian / scale).T @ (jacobian / scale))
    if eigenvalues[0] < UNDETERMINED * eigenvalues[-1]:
        return dict.fromkeys(names, np.inf)
    variances = (vectors**2 / eigenvalues).sum(axis=1) * (sigma_theta / scale) ** 2
    return dict(zip(names, np.sqrt(variances).tolist(), strict=True))


def plan(
    setups: Iterable[tuple[str, str, str]],
    blocks: Mapping[str, Block],
    lasers: Mapping[str, Laser],
    *,
    expected: Mapping[str, Mapping[Any, Mapping[str, float]]],
    sensors: Mapping[str, Sensor],
    release_angles_deg: Mapping[str, Sequence[float]],
    sampling_rates_hz: Sequence[float] = (2000.0,),
    durations_s: Sequence[float] = (8.0,),
    free: Mapping[str, Sequence[str]] | None = None,
    debonding: str = "geometric",
    finger_s: float = 0.03,
) -> pd.DataFrame:
    """Predicted standard errors of a campaign, for every combination of what it may choose.

    Parameters
    ----------
    setups : iterable of (str, str, str)
        Names of block, foundation and laser that stand together.
    blocks, lasers : mapping
        By their names.
    expected : mapping
        foundation: model: parameter: value [SI].
    sensors : mapping of str to Sensor
        Each takes the place of the setup's laser.
    release_angles_deg : mapping of str to sequence of float
        Release angles of each block [°].
    sampling_rates_hz, durations_s : sequence of float
        Sampling rates [Hz] and lengths of a run from its release [s].
    free : mapping of str to sequence of str, optional
        Nuisances fitted besides the parameters of each model; both by default.
    debonding : str
        "geometric" or "tensionless".
    finger_s : float
        Time the finger takes to leave the block, whose samples don't count [s].

    Returns
    -------
    pandas.DataFrame
        A row per case and parameter: block, foundation, laser, sensor, duration_s, sampling_rate_hz,
        release_angle_deg, model, sigma_theta_deg (of one sample, at the release angle), parameter, value,
        stderr, unit, note (why there is no standard error).
    """
    rows = []
    for block_name, foundation, laser_name in dict.fromkeys(setups):
        block, laser = blocks[block_name], lasers[laser_name]
        choices = product(
            expected[foundation].items(), release_angles_deg[block_name], sampling_rates_hz, durations_s
        )
        for (model, parameters), angle, rate, duration in choices:
            time_s = np.arange(np.ceil(finger_s * rate), np.floor(duration * rate) + 1) / rate
            nuisances = ("theta0", "t0") if free is None else free[model]
            theta0 = math.radians(angle)
            try:
                unit_errors = standard_errors(
                    model, block, parameters, time_s, theta0, 1.0, free=nuisances, debonding=debonding
                )
                fault = "" if np.isfinite([*unit_errors.values()]).all() else "not determined by such a run"
            except FreerockError as error:
                unit_errors, fault = dict.fromkeys(parameters, np.nan), error.what
            for sensor_name, sensor in sensors.items():
                sigma, off = sensor.sigma_theta(theta0, block, laser)
                case = (block_name, foundation, laser_name, sensor_name, duration, rate, angle, model)
                for name in MODELS[model]:
                    stderr = np.nan if off else unit_errors[name] * sigma
                    rows.append(
                        (
                            *case,
                            math.degrees(sigma),
                            name,
                            parameters[name],
                            stderr,
                            unit_of(name),
                            fault or off,
                        )
                    )
    frame = pd.DataFrame(rows, columns=COLUMNS)
    appearance = [pd.factorize(frame[name])[0] for name in reversed(CASE)]
    return frame.iloc[np.lexsort(appearance)].reset_index(drop=True)


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
    free = {
        model: [name for name in names if name != "r_per_impact"]
        for model, names in campaign.fits.freed.items()
    }
    angles: dict[str, Sequence[float]] = {name: (angle,) for name, angle in nominal.items() if angle}
    return plan(
        [(each.block, each.foundation, laser) for each in campaign.records for laser in each.lasers],
        {name: block.block for name, block in campaign.blocks.items()},
        {name: Laser(**laser.model_dump(exclude={"calibration"})) for name, laser in campaign.lasers.items()},
        expected=section.expected,
        sensors={name: Sensor(**sensor.model_dump()) for name, sensor in section.sensors.items()},
        release_angles_deg=angles | section.release_angles_deg,
        sampling_rates_hz=section.sampling_rates_hz,
        durations_s=section.durations_s,
        free=free,
        debonding=campaign.fits.debonding,
        finger_s=campaign.processing.runs.finger_s,
    )


def plan_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """The plan as a reader sees it: standard errors in per cent of the values, and why some are missing.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `plan`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        A line per case with a column per parameter; then a line per reason.
    """
    frame = frame.replace({"block": labels or {}, "foundation": labels or {}})
    rows = frame.assign(
        duration=frame["duration_s"].map("{:g} s".format),
        rate=frame["sampling_rate_hz"].map("{:g} Hz".format),
        angle=frame["release_angle_deg"].map("{:g}°".format),
        parameter=frame["model"].map(MODEL_LABELS) + " " + frame["parameter"].map(SYMBOLS),
        percent=[_percent(*pair) for pair in zip(frame["stderr"], frame["value"], strict=True)],
    )
    case = ["block", "foundation", "laser", "sensor", "duration", "rate", "angle"]
    alike = [name for name in case if rows[name].nunique() == 1]
    shown = [name for name in case if name not in alike] or ["angle"]
    table = rows.set_index([*shown, "parameter"])["percent"].unstack(sort=False)
    title = ", ".join(["Standard errors in %", *rows[alike].iloc[0]])
    reasons = [
        f"{row.block} on {row.foundation} from {row.angle}: {row.note}"
        for row in rows.itertuples()
        if row.note
    ]
    return "\n".join([title, table.to_string(), *dict.fromkeys(reasons)])


def _percent(stderr: float, value: float) -> str:
    return f"{100 * stderr / value:.2g}" if np.isfinite(stderr) else "–"
