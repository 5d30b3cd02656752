"""A model's θ(t) as the sensor would show it."""

from collections.abc import Mapping

import numpy as np

from freerock.arrays import Floats, Indices
from freerock.models.block import Block
from freerock.models.contact import Foundation
from freerock.models.laws import GEOMETRIC, LAWS, Rules
from freerock.models.simulate import SOLVER, Solver, simulate_fitted
from freerock.rotation.view import View


def as_released(law: str, block: Block, values: Mapping[str, float], view: View | None) -> dict[str, float]:
    """What a fit found, with the angle at which the block lay before its release instead of that seen."""
    if view is None:
        return {**values}
    foundation = Foundation.of(values) if LAWS[law].is_foundation else None
    return {**values, "theta0": view.released(values["theta0"], block.as_found(values), foundation)}


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
    order: slice | Indices = slice(None)
    back: slice | Indices = order
    if len(beside) > 1:
        order = np.argsort(every, kind="stable")
        back = np.empty_like(order)
        back[order] = np.arange(order.size)
    rates = None if foundation is None and theta_rate is None else np.empty((every.size, 3))
    theta = simulate_fitted(law, turning, values, every[order], rules=rules, solver=solver, rates=rates)
    theta = theta[back].reshape(len(beside), -1)
    if rates is None:
        return view.seen(theta, theta, turning, foundation)
    columns = rates.T[: 1 if theta_rate is None else 3]  # z_cb, its rate and that of θ
    z_cb, *moving = (np.ascontiguousarray(each[back]).reshape(theta.shape) for each in columns)
    if theta_rate is not None:
        z_cb_rate, rate = moving
        later, earlier = (
            view.seen(theta + step * rate, z_cb + step * z_cb_rate, turning, foundation)
            for step in (step_s, -step_s)
        )
        theta_rate[:] = (later - earlier) / (2 * step_s)
    return view.seen(theta, z_cb, turning, foundation)
