"""How a sensor shows a motion: with a corner that sinks, and with the response of the sensor."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.contact import static_depth
from freerock.models.laws import Foundation
from freerock.rotation import beam_kernel
from freerock.rotation.beam import beam_of, mirrored
from freerock.rotation.sensor import Laser, lasers_of, moments

KEYS = ("beam", "position_m", "face", "release_side", "response_ms")


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
        """Instants beside that of a sample [s] and their weights: the sensor gives their mean."""
        return moments(self.laser.response_ms / 1e3)

    def is_plain(self, block: Block, foundation: Foundation | None) -> bool:
        """Whether the rotation of such a block is seen as it is."""
        sees_corners = self.laser.beam is not None and (foundation is not None or block != self.block)
        return len(self.moments[0]) == 1 and not sees_corners

    def seen(self, theta: Floats, z_cb: Floats, block: Block, foundation: Foundation | None) -> Floats:
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
        """
        weights = self.moments[1]
        if self.laser.beam is None:
            return np.asarray(weights @ theta)
        out = np.empty(theta.shape[1])
        rests = math.nan if foundation is None else self._rests(block, foundation)
        beam_kernel.seen(theta, z_cb, weights, rests, self._sign, *self._beams(block), out)
        return out

    def released(self, theta0: float, block: Block, foundation: Foundation | None) -> float:
        """Rotation [rad] of a block at rest that is seen at an angle [rad], found by secants."""
        if self.laser.beam is None or theta0 == 0:
            return theta0
        bed = foundation or Foundation(0.0)
        rests, law = self._rests(block, bed) if bed.k else 0.0, bed.constants(block)
        return float(self._sign * beam_kernel.released(self._sign * theta0, law, rests, *self._beams(block)))

    @cached_property
    def at_once(self) -> "View":
        """The same of a sensor that takes no time."""
        return View(self.block, self.laser.moved(response_ms=0.0))

    @cached_property
    def _sign(self) -> float:
        return -1.0 if mirrored(self.laser) else 1.0

    def _beams(self, block: Block) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The beam on the block, and that with the corners expected."""
        beam = beam_of(block, self.laser)
        return beam, (*beam[:4], self.block.b)

    def _rests(self, block: Block, foundation: Foundation) -> float:
        """Depth from which the beam counts [m]: see `beam.displaced`."""
        return static_depth(block, foundation, 0.0) if self.laser.beam == "vertical" else 0.0


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


def sensor_attributes(view: View | None) -> dict[str, Any]:
    """How a dataset tells what `view_in` reads; texts and numbers."""
    found = {f"sensor_{key}": getattr(view.laser, key) for key in KEYS} if view else {}
    return {key: value for key, value in found.items() if value is not None}


def view_in(attrs: Mapping[Any, Any], block: Block) -> View:
    """The view of a dataset with such attributes, of the block expected."""
    own = {key: attrs[f"sensor_{key}"] for key in KEYS if f"sensor_{key}" in attrs}
    return View(block, Laser(**own, units="" if "beam" in own else "rad"))
