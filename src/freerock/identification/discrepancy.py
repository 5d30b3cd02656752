"""How far a model's θ(t) is from the measured one: ε_θ, whiteness of the residual."""

import numpy as np

from freerock.arrays import Floats


def epsilon_theta(time_s: Floats, theta_model: Floats, theta_measured: Floats) -> float:
    """Relative mean square discrepancy ε_θ = ∫(θ_th - θ_ex)² dt / ∫θ_ex² dt.

    Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024. Samples that are not
    finite in either series are left out; the integrals are trapezoidal. Where time falls back, a
    further run begins, and the integrals add up.

    Parameters
    ----------
    time_s : array_like, shape (n_time,)
        Time [s]; the last valid instant is the t_f of the measure.
    theta_model, theta_measured : array_like, shape (n_time,)
        Rotation [rad].

    Returns
    -------
    float
        ε_θ as a fraction; NaN when fewer than two samples are valid or the measured motion is zero.
    """
    time_s, theta_model, theta_measured = np.broadcast_arrays(time_s, theta_model, theta_measured)
    valid = np.isfinite(theta_model) & np.isfinite(theta_measured)
    if valid.sum() < 2:
        return float("nan")
    time_s, theta_model, theta_measured = time_s[valid], theta_model[valid], theta_measured[valid]
    step = np.maximum(np.diff(time_s), 0.0)
    difference, energy = (
        step @ (square[1:] + square[:-1])
        for square in ((theta_model - theta_measured) ** 2, theta_measured**2)
    )
    return float(difference / energy) if energy > 0 else float("nan")


def is_white(residual: Floats, level: float = 1.63) -> bool:
    """Whether a residual passes for white noise: Bartlett's test of the cumulative periodogram.

    The cumulated periodogram of white noise rises along the diagonal; its greatest distance from it
    follows Kolmogorov's law (Durbin 1969, doi:10.1093/biomet/56.1.1).

    Parameters
    ----------
    residual : array_like, shape (n_time,)
        In any unit, equally spaced.
    level : float
        Greatest distance times the root of the number of frequencies: 1.63 is exceeded by chance once in a
        hundred times, 1.36 once in twenty.
    """
    transform = np.fft.rfft(residual - np.mean(residual))[1:]
    power = transform.real**2 + transform.imag**2
    share = np.cumsum(power) / np.sum(power)
    n = len(share)
    return bool(np.max(np.abs(share - np.arange(1, n + 1) / n)) * np.sqrt(n) < level)
