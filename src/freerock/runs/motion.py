"""A run as the input of fits and predictions: θ(t) since its release, and its quality."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real

import numpy as np

from freerock.arrays import Floats, sampled
from freerock.errors import FreerockError, of_kind
from freerock.noise.rotation_noise import HIGH_SWING, in_motion, relative_noise
from freerock.noise.spectrum import Noise
from freerock.noise.still_phases import swings_of
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import View
from freerock.runs.runs import Run


@dataclass(frozen=True)
class Motion:
    """One measured free-rocking run, the input of a fit.

    Parameters
    ----------
    time_s : ndarray, shape (n_time,)
        Time since the measured release [s].
    theta : ndarray, shape (n_time,)
        Measured rotation [rad]; NaN where a sample is flagged.
    sigma_theta : float
        Standard deviation of the noise of theta [rad].
    theta0, theta0_stderr : float
        Release angle and its standard error [rad].
    t0_stderr : float
        Standard error of the measured release [s].
    fit_start_s : float
        First instant that a fit uses, after the finger has left the block [s since the release].
    noise : Noise, optional
        Noise of the sensor at rest; None if no rest was seen. Then white noise of sigma_theta is
        assumed.
    view : View, optional
        How the sensor shows a motion; None if it shows the rotation itself.
    laboratory : Laboratory, optional
        Block and sensors, whose inputs a fit moves within their uncertainties; None if these are
        exact.

    Raises
    ------
    FreerockError
        No numbers, arrays of two lengths, a time that does not increase, no noise, or other units.

    Examples
    --------
    >>> import freerock
    >>> import numpy as np
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> time = np.arange(0, 2, 1e-3)
    >>> theta = 0.17 * np.cos(3 * time)  # as measured from the release on, where no laser file is at hand
    >>> seen = freerock.view_of(laser, block)
    >>> motion = freerock.Motion(time, theta, sigma_theta=1e-4, theta0=0.17, fit_start_s=0.03, view=seen)
    >>> motion.theta.shape
    (2000,)
    """

    time_s: Floats
    theta: Floats
    sigma_theta: float
    theta0: float
    theta0_stderr: float = 0.0
    t0_stderr: float = 0.0
    fit_start_s: float = 0.0
    noise: Noise | None = None
    view: View | None = None
    laboratory: Laboratory | None = None

    def __post_init__(self) -> None:
        time_s, theta = sampled(self.time_s, self.theta)
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "theta", theta)
        of_kind("sigma_theta", self.sigma_theta, Real, "give one number, in rad")
        if not (self.sigma_theta > 0 and 0 < abs(self.theta0) < math.pi / 2):
            what = f"sigma_theta is {self.sigma_theta:g}, theta0 {self.theta0:g}"
            raise FreerockError("theta", what, "give both in rad, neither of them 0")


def motions_of(
    runs: Sequence[Run], samples: Mapping[str, Floats], view: View | None = None, noise: Noise | None = None
) -> dict[int, Motion]:
    """What a fit takes of each run of a record, by the run's number.

    Parameters
    ----------
    runs : sequence of Run
    samples : mapping of str to ndarray, shape (n_time,)
        The record's time [s], theta [rad] and, where there is a noise, sigma_theta [rad].
    view : View, optional
        What the sensor makes of a motion.
    noise : Noise, optional
        Of the sensor at rest; a run may be louder (`in_motion`).
    """
    time_s, motions, relative = samples["time"], dict[int, Motion](), np.ones(0)
    if noise is not None:
        sigma_theta = samples["sigma_theta"].astype("float32")  # as datasets of records hold it
        relative = relative_noise(sigma_theta)[1]
    for run in runs:
        during = slice(np.searchsorted(time_s, run.release_s), np.searchsorted(time_s, run.end_s, "right"))
        motion = Motion(
            time_s[during] - run.release_s,
            samples["theta"][during].copy(),  # the record is let go
            sigma_theta=run.sigma_theta,
            theta0=run.theta0,
            theta0_stderr=run.theta0_stderr,
            t0_stderr=run.release_stderr_s,
            fit_start_s=run.fit_start_s - run.release_s,
            view=view,
        )
        if noise is not None:
            at_rest = noise.scaled(float(np.median(relative[during])))
            swings = swings_of(motion.theta, HIGH_SWING * math.sqrt(at_rest.variance))[1:]
            own = in_motion(at_rest, motion.theta, np.ones(len(motion.theta)), swings)
            motion = replace(motion, noise=own)
        motions[run.number] = motion
    return motions
