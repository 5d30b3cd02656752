"""A model's θ(t) as the sensor would show it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.laws import GEOMETRIC, LAWS, Foundation, Rules
from freerock.models.simulate import NO_PASSAGES, SOLVER, Solver, simulate_fitted
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
    passages: Floats = NO_PASSAGES,
) -> Floats:
    """Rotation [rad], shape (n_time,), under what a fit finds, as the sensor would have it.

    theta0 in `values` is the angle at which the block is seen before its release. All else as in
    `freerock.models.simulate.simulate_fitted`; without a view it is that.
    """
    turning = block.as_found(values)
    foundation = Foundation.of(values) if view and LAWS[law].is_foundation else None
    how: dict[str, Any] = {"rules": rules, "solver": solver, "passages": passages}
    if view is None or view.is_plain(turning, foundation):
        return simulate_fitted(law, turning, values, time_s, **how)
    beside = view.moments[0][:, None]
    values = {**values, "theta0": view.released(values["theta0"], turning, foundation)}
    every = (time_s + beside).ravel()
    back = np.arange(every.size)
    if len(beside) > 1:
        every, back = np.unique(every, return_inverse=True)
    rates = None if foundation is None else np.empty((every.size, 3))
    theta = simulate_fitted(law, turning, values, every, rates=rates, **how)[back]
    theta = np.ascontiguousarray(theta.reshape(len(beside), -1))
    z_cb = theta if rates is None else np.ascontiguousarray(rates[back, 0]).reshape(theta.shape)
    return view.seen(theta, z_cb, turning, foundation)
