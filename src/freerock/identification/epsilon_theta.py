"""ε_θ: relative mean square discrepancy of a model's θ(t) from the measured one."""

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
