"""A run as the input of fits and predictions: θ(t) since its release, and its quality."""

import math
from collections.abc import Iterable
from dataclasses import InitVar, dataclass, replace

import numpy as np

from freerock.arrays import Floats
from freerock.noise.at_rest import noise_at_rest, relative_noise
from freerock.noise.in_motion import HIGH_SWING, in_motion, swings_of
from freerock.noise.spectrum import Noise
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import View
from freerock.runs.segment import Run


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
    rests : iterable of ndarray, optional
        Stretches of θ at rest [rad], about any level, sampled as the motion is (`quiet.quiet_stretches`):
        they give `noise` where that is None.
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
    rests: InitVar[Iterable[Floats]] = ()

    def __post_init__(self, rests: Iterable[Floats]) -> None:
        stretches = [np.asarray(each, float) for each in rests]
        if self.noise is None and stretches:
            rate_hz = (len(self.time_s) - 1) / float(self.time_s[-1] - self.time_s[0])
            object.__setattr__(self, "noise", noise_at_rest(stretches, rate_hz))


def motion_of(
    run: Run, time_s: Floats, theta: Floats, noise: Noise | None = None, view: View | None = None
) -> Motion:
    """What a fit takes of a run.

    Parameters
    ----------
    run : Run
    time_s, theta : ndarray, shape (n_time,)
        The record's clock [s] and rotation [rad].
    noise : Noise, optional
        Of the sensor while the block moves (`heard`).
    view : View, optional
        What the sensor makes of a motion.
    """
    during = _during(run, time_s)
    return Motion(
        time_s[during] - run.release_s,
        theta[during].copy(),  # the record is let go
        sigma_theta=run.sigma_theta,
        theta0=run.theta0,
        theta0_stderr=run.theta0_stderr,
        t0_stderr=run.release_stderr_s,
        fit_start_s=run.fit_start_s - run.release_s,
        noise=noise,
        view=view,
    )


def heard(motion: Motion, at_rest: Noise | None) -> Motion:
    """A motion with the noise that a sensor has at rest, or as loud as in motion (`noise_in_motion`)."""
    if at_rest is None:
        return motion
    theta = motion.theta
    swings = swings_of(theta, HIGH_SWING * math.sqrt(at_rest.variance))
    return replace(motion, noise=in_motion(at_rest, theta, np.ones(len(theta)), swings))


def loud(run: Run, time_s: Floats, sigma_theta: Floats, usual: float) -> float:
    """How many times as loud as `quiet.usual_of` the noise is during a run; arrays are of shape (n_time,)."""
    return float(np.median(relative_noise(sigma_theta[_during(run, time_s)], usual)))


def _during(run: Run, time_s: Floats) -> slice:
    return slice(np.searchsorted(time_s, run.release_s), np.searchsorted(time_s, run.end_s, "right"))
