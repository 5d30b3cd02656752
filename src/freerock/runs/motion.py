"""A run of a record as fits and predictions take it: θ(t) since its release, and what is known of it."""

from dataclasses import dataclass

from freerock.arrays import Floats
from freerock.runs.segment import Run


@dataclass(frozen=True)
class Motion:
    """One measured free-rocking run, as the fits take it.

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
    """

    time_s: Floats
    theta: Floats
    sigma_theta: float
    theta0: float
    theta0_stderr: float = 0.0
    t0_stderr: float = 0.0
    fit_start_s: float = 0.0


def motion_of(run: Run, time_s: Floats, theta: Floats) -> Motion:
    """What a fit takes of a run.

    Parameters
    ----------
    run : Run
    time_s, theta : ndarray, shape (n_time,)
        The record's clock [s] and rotation [rad].
    """
    during = (time_s >= run.release_s) & (time_s <= run.end_s)
    return Motion(
        time_s[during] - run.release_s,
        theta[during],
        sigma_theta=run.sigma_theta,
        theta0=run.theta0,
        theta0_stderr=run.theta0_stderr,
        t0_stderr=run.release_stderr_s,
        fit_start_s=run.fit_start_s - run.release_s,
    )
