"""The laboratory's knowledge of a record: block, lasers, clock and base; and the same with a moved input.

A `Laboratory` comes from `config.step_settings`; `identification.run_model` moves its inputs.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.rotation.beam import beam_of, displaced, mirrored
from freerock.rotation.beam_kernel import seen
from freerock.rotation.sensor import Laser

UNITS = dict.fromkeys(("height_m", "width_m", "contact_width_m", "com_height_m", "com_offset_m"), "m")
UNITS |= {"mass_kg": "kg", "inertia_kg_m2": "kg m2", "gravity_m_s2": "m s-2"}
OF_BLOCK = (*UNITS,)
UNITS |= {"position_m": "m", "scale_fraction": "1", "sampling_rate_fraction": "1", "response_ms": "ms"}
UNITS |= {"levelled_deg": "deg"}


@dataclass(frozen=True)
class Input:
    """A number that the results of a record rest on.

    Parameters
    ----------
    owner : str
        The block, laser or foundation it belongs to: records that name the same one share its error.
    name : str
        A key of `UNITS`, which has its unit.
    u : float
        Its standard uncertainty, in that unit.
    stated : bool
        Whether the laboratory stated it; False of a default.
    """

    owner: str
    name: str
    u: float
    stated: bool

    @property
    def label(self) -> str:
        """Its name and owner, in words."""
        return f"{self.name} of {self.owner}"


@dataclass(frozen=True)
class Laboratory:
    """What a record was measured with.

    Parameters
    ----------
    block : Block
    lasers : mapping of str to Laser
        The laser by its name, or the two.
    inputs : tuple of Input
    scales : tuple of float
        What the displacement of each laser is multiplied with (the rotation of a channel that holds it).
    clock : float
        What the time is multiplied with.
    tilt : float
        Of the base, to the right [rad].
    less_than_none_ms2 : float
        How far the square of the response of a laser is moved below zero [ms²]; such a sensor sharpens a
        motion as much as a slow one blurs it, so that fits are smooth where a sensor takes no time.
    """

    block: Block
    lasers: Mapping[str, Laser]
    inputs: tuple[Input, ...] = ()
    scales: tuple[float, ...] = (1.0, 1.0)
    clock: float = 1.0
    tilt: float = 0.0
    less_than_none_ms2: float = 0.0

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> Self:
        """From plain values: block, lasers by name, inputs."""
        lasers = {name: Laser(**each) for name, each in settings["lasers"].items()}
        return cls(Block(**settings["block"]), lasers, tuple(Input(**each) for each in settings["inputs"]))

    def moved(self, by: Mapping[Input, float]) -> Self:
        """The laboratory with each of some inputs moved by so many of its standard uncertainties."""
        of_block, lasers, scales = dict[str, float](), {**self.lasers}, [*self.scales]
        clock, tilt, less_ms2 = self.clock, self.tilt, self.less_than_none_ms2
        for source, n in by.items():
            more = n * source.u
            if source.name in OF_BLOCK:
                of_block[source.name] = more
            elif source.name == "levelled_deg":
                tilt += math.radians(more)
            elif source.name == "sampling_rate_fraction":
                clock /= 1 + more
            elif source.name == "response_ms":
                # what the time T of a sensor does to a motion grows with T²: the square is moved
                time_ms = next(iter(lasers.values())).response_ms
                square = time_ms**2 + n * ((time_ms + source.u) ** 2 - time_ms**2)
                response_ms, less_ms2 = math.sqrt(max(square, 0.0)), max(-square, 0.0)
                lasers = {name: each.moved(response_ms=response_ms) for name, each in lasers.items()}
            elif source.name == "position_m":
                laser = lasers[source.owner]
                lasers[source.owner] = laser.moved(position_m=laser.position + more)
            else:
                scales[[*lasers].index(source.owner)] *= 1 + more
        block = self.block.moved(of_block) if of_block else self.block
        return type(self)(block, lasers, self.inputs, tuple(scales), clock, tilt, less_ms2)

    def read_by(self, other: Self) -> tuple[float, tuple[float, ...]]:
        """Factor from a reading of the one laser to that of another laboratory, and the beam there."""
        return other.scales[0] / self.scales[0], beam_of(other.block, next(iter(other.lasers.values())))

    def reread(self, theta: Floats, by: Self) -> Floats:
        """Rotation [rad] that the readings behind a rotation would have given another laboratory.

        Parameters
        ----------
        theta : ndarray
            Rotation as found with this laboratory's numbers [rad].
        by : Laboratory
            The same with other numbers.
        """
        sensors, others = list(self.lasers.values()), list(by.lasers.values())
        if sensors[0].beam is None:  # the channel holds the rotation itself
            return theta * by.scales[0] / self.scales[0]
        beam, (gain, expected) = beam_of(self.block, sensors[0]), self.read_by(by)
        if (beam, self.scales, sensors) == (expected, by.scales, others):
            return theta
        if len(sensors) == 1:
            each, out = np.array(theta, ndmin=2), np.empty(theta.size)
            sign = -1.0 if mirrored(others[0]) else 1.0
            seen(each, each, np.array([gain]), math.nan, sign, beam, expected, out)
            return out
        readings = [
            displaced(theta, self.block, laser) * now / then
            for laser, then, now in zip(sensors, self.scales, by.scales, strict=True)
        ]
        angle = np.arctan((readings[0] - readings[1]) / (others[0].position - others[1].position))
        return -angle if mirrored(others[0]) else np.asarray(angle)
