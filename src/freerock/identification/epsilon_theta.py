"""A model's θ(t) against the measured one: as the sensor would show it, ε_θ, whiteness of the residual."""

from collections.abc import Mapping

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.contact import Foundation
from freerock.models.laws import GEOMETRIC, LAWS, Rules
from freerock.models.simulate import SOLVER, Solver, simulate_fitted
from freerock.rotation.view import View


def as_measured(
    law: str,
    block: Block,
    values: Mapping[str, float],
    time_s: Floats,
    view: View | None,
    *,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    theta_rate: Floats | None = None,
    step_s: float = 1e-5,
) -> Floats:
    """Rotation [rad], shape (n_time,), under what a fit finds, as the sensor would have it.

    theta0 in `values` is the angle at which the block is seen before its release. `theta_rate`, shape
    (n_time,), receives the rate of what is seen [rad/s] if given, a difference quotient over `step_s` [s].
    All else as in `freerock.models.simulate.simulate_fitted`; without a view it is that.
    """
    turning = block.as_found(values)
    foundation = Foundation.of(values) if view and LAWS[law].is_foundation else None
    if view is None or view.is_plain(turning, foundation):
        rates = None if theta_rate is None else np.empty((len(time_s), 1))
        theta = simulate_fitted(law, turning, values, time_s, rules=rules, solver=solver, rates=rates)
        if theta_rate is not None and rates is not None:
            theta_rate[:] = rates[:, 0]
        return theta
    beside = view.moments[0][:, None]
    values = {**values, "theta0": view.released(values["theta0"], turning, foundation)}
    every = (time_s + beside).ravel() if len(beside) > 1 else time_s
    rates = None if foundation is None and theta_rate is None else np.empty((every.size, 3))
    if len(beside) == 1:
        theta = simulate_fitted(law, turning, values, every, rules=rules, solver=solver, rates=rates)
    else:
        order = np.argsort(every, kind="stable")
        theta = simulate_fitted(law, turning, values, every[order], rules=rules, solver=solver, rates=rates)
        back = np.argsort(order, kind="stable")
        theta, rates = theta[back], None if rates is None else rates[back]
    theta = theta.reshape(len(beside), -1)
    if rates is None:
        return view.seen(theta, theta, turning, foundation)
    z_cb = np.ascontiguousarray(rates[:, 0]).reshape(theta.shape)
    if theta_rate is not None:
        z_cb_rate, rate = rates[:, 1].reshape(theta.shape), rates[:, 2].reshape(theta.shape)
        later, earlier = (
            view.seen(theta + step * rate, z_cb + step * z_cb_rate, turning, foundation)
            for step in (step_s, -step_s)
        )
        theta_rate[:] = (later - earlier) / (2 * step_s)
    return view.seen(theta, z_cb, turning, foundation)


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
    """Whether a residual agrees with white noise: Bartlett's test of the cumulative periodogram.

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
