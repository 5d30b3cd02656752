"""How a sensor shows a motion: with a corner that sinks, and with the response of the sensor.

`as_measured` is a model's θ(t) as the sensor would show it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.block_on_bed import static_depth
from freerock.models.laws import GEOMETRIC, LAWS, Foundation, Rules
from freerock.models.simulate import NO_PASSAGES, SOLVER, Solver, simulate_fitted
from freerock.rotation import beam_kernel
from freerock.rotation.beam import beam_of, mirrored
from freerock.rotation.sensor import Laser, lasers_of

AT, WEIGHT = np.polynomial.legendre.leggauss(3)  # moments of a blur, and their weights
ONE_MOMENT = np.ones(1)  # weight where a sensor takes no time
KEYS = ("beam", "position_m", "face", "release_side", "response_ms")  # of a laser, in datasets as sensor_KEY


@dataclass(frozen=True)
class View:
    """How the rotation of a record came about.

    Parameters
    ----------
    block : Block
        By whose corners a displacement became a rotation.
    laser : Laser
        Its beam and the time it takes. Without a beam what is measured is the rotation itself, or depends on
        no depth, as what two lasers do.
    """

    block: Block
    laser: Laser

    @cached_property
    def moments(self) -> tuple[Floats, Floats]:
        """Instants beside that of a sample [s], its delay taken off, and their weights.

        The sensor gives their mean over a preceding time T: a delay by T/2, and a blur about it. The blur of
        a motion is its mean over a few moments, by the rule of Gauss and Legendre: exact for polynomials of
        fifth degree in time.
        """
        if self.laser.response_ms == 0:
            return np.zeros(1), ONE_MOMENT
        return AT * (self.laser.response_ms / 1e3) / 2, WEIGHT / 2

    def sees_corners(self, block: Block, foundation: Foundation | None) -> bool:
        """Whether corners that sink, or are not those expected, change the reading of such a block."""
        return self.laser.beam is not None and (foundation is not None or block != self.block)

    def seen(
        self,
        theta: Floats,
        z_cb: Floats,
        block: Block,
        foundation: Foundation | None,
        weights: Floats = ONE_MOMENT,
        by: tuple[float, tuple[float, ...]] | None = None,
    ) -> Floats:
        """Rotation as the record has it [rad], shape (n_time,).

        The reading of each moment by (F30) to (F32), the mean of the readings, and the rotation that a block
        would have to which this reading belongs and whose corners are those expected and do not sink.

        Parameters
        ----------
        theta, z_cb : ndarray, shape (n_moments, n_time)
            Rotation [rad] and depth of the base centre [m].
        block : Block
            The block that turns; it may have other corners than the one expected.
        foundation : Foundation or None
            What its corners sink into.
        weights : ndarray, shape (n_moments,), optional
            Of the moments, whose sum is 1.
        by : (float, tuple), optional
            Another laboratory that finds the rotation: what it multiplies a reading with, and its beam.
        """
        if self.laser.beam is None:
            return np.asarray(weights @ theta)
        out = np.empty(theta.shape[1])
        rests, sign, beam, expected = self._reading(block, foundation)
        rests = math.nan if foundation is None else rests
        if by is not None:
            weights, expected = by[0] * weights, by[1]
        beam_kernel.seen(theta, z_cb, weights, rests, sign, beam, expected, out)
        return out

    def released(self, theta0: float, block: Block, foundation: Foundation | None) -> float:
        """Rotation [rad] of a block at rest that is seen at an angle [rad], found by secants."""
        if self.laser.beam is None or theta0 == 0:
            return theta0
        law = (foundation or Foundation(0.0)).constants(block)
        rests, sign, beam, expected = self._reading(block, foundation)
        return float(sign * beam_kernel.released(sign * theta0, law, rests, beam, expected))

    def _reading(self, block: Block, foundation: Foundation | None) -> tuple[Any, ...]:
        """What a reading depends on, as `beam_kernel` takes it.

        The depth from which the beam counts [m], see `beam.displaced`; the sign of the face; the beam on the
        block, and that with the corners expected.
        """
        down = self.laser.beam == "vertical"
        rests = static_depth(block, foundation, 0.0) if foundation and down else 0.0
        beam = beam_of(block, self.laser)
        return rests, -1.0 if mirrored(self.laser) else 1.0, beam, (*beam[:4], self.block.b)


def view_of(lasers: Laser | Sequence[Laser], block: Block) -> View | None:
    """How one or two lasers show the rotation; None if the channel is the rotation itself.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> view = freerock.view_of(laser, block)
    >>> freerock.WinklerModel(block, view=view).param_names
    ['k', 'c', 'theta0', 't0']
    """
    lasers = lasers_of(lasers)
    first = lasers[0]
    if len(lasers) > 1 or first.beam is None:
        first = first.moved(beam=None, position_m=None, units="rad")
    view = View(block, first)
    return None if view.laser.beam is None and len(view.moments[0]) == 1 else view


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
    if view is None or (len(view.moments[0]) == 1 and not view.sees_corners(turning, foundation)):
        return simulate_fitted(law, turning, values, time_s, **how)
    moments_s, weights = view.moments
    beside = moments_s[:, None]
    values = as_released(law, turning, values, view)
    every = (time_s + beside).ravel()
    back: Any = slice(None)
    if len(beside) > 1:
        every, back = np.unique(every, return_inverse=True)
    rates = None if foundation is None else np.empty((every.size, 3))
    theta = simulate_fitted(law, turning, values, every, rates=rates, **how)[back]
    theta = np.ascontiguousarray(theta.reshape(len(beside), -1))
    z_cb = theta if rates is None else np.ascontiguousarray(rates[back, 0]).reshape(theta.shape)
    return view.seen(theta, z_cb, turning, foundation, weights)
