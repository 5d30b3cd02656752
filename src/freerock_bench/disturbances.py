"""Faults for the records of the virtual laboratory: what cables, converters and operators do to a signal.

Each function gives a fault for `virtual_record.simulate_record`: (time_s, volts, generator) → volts, between
sensor and converter.
"""

import math
from typing import Any

import numpy as np
from scipy.signal import lfilter

from freerock.arrays import Floats
from freerock.virtual_lab.added_noise import Disturbance


def saturated(share: float) -> Disturbance:
    """The amplifier goes no further than a share of the largest reading, counted from that at rest."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        rest, far = _rest_and_farthest(volts)
        end = rest + share * (far - rest)
        return np.minimum(volts, end) if far > rest else np.maximum(volts, end)

    return spoil


def tone(frequency_hz: float, amplitude_v: float) -> Disturbance:
    """A sinusoid: interference of the mains, or one from above the Nyquist frequency, folded below it."""

    def spoil(time_s: Floats, volts: Floats, generator: Any) -> Floats:
        phase = generator.uniform(0, 2 * np.pi)
        disturbed: Floats = volts + amplitude_v * np.sin(2 * np.pi * frequency_hz * time_s + phase)
        return disturbed

    return spoil


def averaged(window_s: float) -> Disturbance:
    """The sensor gives the mean over the time before."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        from scipy.ndimage import uniform_filter1d

        n = max(1, round(window_s / (time_s[1] - time_s[0])))
        return np.asarray(uniform_filter1d(volts, n, mode="nearest", origin=(n - 1) // 2))

    return spoil


def _rest_and_farthest(volts: Floats) -> tuple[float, float]:
    rest = float(np.median(volts[: volts.size // 20]))
    far = float(np.percentile(volts, 99)), float(np.percentile(volts, 1))
    return rest, max(far, key=lambda reading: abs(reading - rest))


def correlated(n: int, time_s: float, rate_hz: float, generator: np.random.Generator) -> Floats:
    """Noise of variance 1, autoregressive of the first order, shape (n,)."""
    a = math.exp(-1 / (rate_hz * time_s))
    drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
    return np.asarray(lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0])
