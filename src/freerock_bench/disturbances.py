"""Faults for the records of the virtual laboratory: what cables, converters and operators do to a signal.

Each function gives a fault for `virtual_record.simulate_record`: (time_s, volts, generator) → volts, between
sensor and converter.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from freerock.arrays import Floats
from freerock.virtual_lab.added_noise import Disturbance


def error_level(at_s: float, lasts_s: float, *, level_v: float = 10.2) -> Disturbance:
    """No target for a while."""
    return lambda time_s, volts, _: np.where(_within(time_s, at_s, lasts_s), level_v, volts)


def frozen(at_s: float, lasts_s: float) -> Disturbance:
    """The converter repeats its last value for a while."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        gone = _within(time_s, at_s, lasts_s)
        return np.where(gone, volts[max(int(np.argmax(gone)) - 1, 0)], volts)

    return spoil


def disconnected(at_s: float, lasts_s: float, *, noise_v: float = 2e-4) -> Disturbance:
    """The cable is off for a while: zero volts, and the converter's noise."""

    def spoil(time_s: Floats, volts: Floats, generator: Any) -> Floats:
        return np.where(
            _within(time_s, at_s, lasts_s), noise_v * generator.standard_normal(volts.size), volts
        )

    return spoil


def spike(at_s: float, height_v: float) -> Disturbance:
    """One sample that is off."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        spoilt = volts.copy()
        spoilt[np.searchsorted(time_s, at_s)] += height_v
        return spoilt

    return spoil


def saturated(share: float) -> Disturbance:
    """The amplifier goes no further than a share of the largest reading, counted from that at rest."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        rest, far = _rest_and_farthest(volts)
        end = rest + share * (far - rest)
        return np.minimum(volts, end) if far > rest else np.maximum(volts, end)

    return spoil


def target_lost(share: float, *, level_v: float = 10.2) -> Disturbance:
    """The sensor sees no target beyond a share of the largest reading, counted from that at rest."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        rest, far = _rest_and_farthest(volts)
        return np.where((volts - rest) / (far - rest) > share, level_v, volts)

    return spoil


def ac_coupled(cutoff_hz: float) -> Disturbance:
    """A first-order high pass, settled at the start."""

    def spoil(time_s: Floats, volts: Floats, _: Any) -> Floats:
        step = time_s[1] - time_s[0]
        keep = 1 / (1 + 2 * math.pi * cutoff_hz * step)
        return np.asarray(lfilter([keep, -keep], [1, -keep], volts - volts[0]))

    return spoil


def drift(range_v: float) -> Disturbance:
    """The sensor warms up: its zero moves by so much over the record."""
    return lambda time_s, volts, _: volts + range_v * (time_s - time_s[0]) / (time_s[-1] - time_s[0])


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


def slid(at_s: float, by_v: float) -> Disturbance:
    """The block has slid or twisted: another reading from an instant on."""
    return lambda time_s, volts, _: np.where(time_s >= at_s, volts + by_v, volts)


def _within(time_s: Floats, at_s: float, lasts_s: float) -> NDArray[np.bool_]:
    return (time_s >= at_s) & (time_s < at_s + lasts_s)


def _rest_and_farthest(volts: Floats) -> tuple[float, float]:
    rest = float(np.median(volts[: volts.size // 20]))
    far = float(np.percentile(volts, 99)), float(np.percentile(volts, 1))
    return rest, max(far, key=lambda reading: abs(reading - rest))


def correlated(n: int, time_s: float, rate_hz: float, generator: np.random.Generator) -> Floats:
    """Noise of variance 1, autoregressive of the first order, shape (n,)."""
    a = math.exp(-1 / (rate_hz * time_s))
    drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
    return np.asarray(lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0])
