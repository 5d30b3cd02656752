"""Noise of the sensor and the converter of the virtual laboratory."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats

Disturbance = Callable[[Floats, Floats, Any], Floats]
"""A fault of the signal: (time_s, volts, generator) → volts, between sensor and converter."""


@dataclass(frozen=True)
class AddedNoise:
    """What sensor and converter add: white noise, mains interference, slow drift, the converter's resolution.

    Amplitudes and the span of the converter in V.
    """

    white_v: float = 2e-3
    mains_v: float = 1e-3
    mains_hz: float = 50.0
    drift_v: float = 1e-3
    drift_period_s: float = 120.0
    bits: int = 24
    span_v: float = 10.5

    @property
    def volts_per_count(self) -> float:
        """Resolution of the converter [V]."""
        return self.span_v / self.counts

    @property
    def counts(self) -> int:
        """Counts of the converter's span."""
        return int(2 ** (self.bits - 1))


def converted(
    time_s: Floats, volts: Floats, noise: AddedNoise, generator: Any, faults: Sequence[Disturbance]
) -> NDArray[np.int32]:
    """The converter's counts of a sensor's volts, with noise and faults.

    `generator` is a RandomState: its streams, unlike a Generator's, never change with NumPy.
    """
    phases = generator.uniform(0, 2 * np.pi, 2)
    volts += noise.mains_v * np.sin(2 * np.pi * noise.mains_hz * time_s + phases[0])
    volts += noise.drift_v * np.sin(2 * np.pi * time_s / noise.drift_period_s + phases[1])
    volts += noise.white_v * generator.standard_normal(time_s.size)
    for fault in faults:
        volts = fault(time_s, volts, generator)
    top = noise.counts
    return np.clip(np.rint(volts * (top / noise.span_v)), -top, top - 1).astype(np.int32)
