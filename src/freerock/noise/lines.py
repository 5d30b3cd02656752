"""Lines in the spectrum of a still signal that do not come from the mains: folded, or a vibration."""

import numpy as np

from freerock.arrays import Floats
from freerock.noise.spectrum import frequencies, tapered_power

SEGMENT_S, MOST_SEGMENTS = 0.5, 200  # of the mean spectrum in which lines are sought
LOWEST_HZ = 15.0  # below lie tremor, drift and the block itself
NEIGHBOURS = 20  # bins on either side whose median is the floor
SURE = 5.5  # standard deviations above the floor
LONGEST_S = 10.0  # of a rest in which a slow line is sought
WIDE, BESIDE = 3, 16  # bins on either side that a slow line fills, and next to these, whose median it exceeds
FEWEST = 6  # of the latter towards zero
CLEAR = 12.0  # times that median


def other_line(segments: Floats, step: float, mains_hz: float | None) -> tuple[float, float] | None:
    """The strongest line in the spectrum of a still signal that is no harmonic of the mains.

    The mean spectrum of the segments (Hann window), all made equally loud, stands above the median of its
    neighbourhood by more than chance allows: `SURE` standard deviations of the mean of as many exponential
    variables, in the approximation of Wilson and Hilferty (1931, doi:10.1073/pnas.17.12.684).

    Parameters
    ----------
    segments : ndarray, shape (n_segments, n_samples)
        Stretches of a still signal.
    step : float
        Sampling interval [s].
    mains_hz : float or None
        Frequency [Hz] whose harmonics are passed over.

    Returns
    -------
    (frequency_hz, amplitude) or None
    """
    k, n = segments.shape
    if k < 2 or n < 4 * NEIGHBOURS:
        return None
    window = np.hanning(n)
    level = segments - segments.mean(axis=1, keepdims=True)
    square = np.mean(level**2, axis=1, keepdims=True)
    level *= np.sqrt(square.mean() / np.where(square > 0, square, 1.0))
    power = (np.abs(np.fft.rfft(level * window, axis=1)) ** 2).mean(axis=0)
    frequency = np.fft.rfftfreq(n, step)
    width = frequency[1]
    padded = np.pad(power, NEIGHBOURS, mode="reflect")
    floor = np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1), axis=1)
    limit = floor * k / (k - 1 / 3) * (1 - 1 / (9 * k) + SURE / (3 * np.sqrt(k))) ** 3
    near = np.abs(frequency / mains_hz - np.round(frequency / mains_hz)) * mains_hz if mains_hz else np.inf
    open_bins = (frequency > max(LOWEST_HZ, 5 * width)) & (near > 2.5 * width)
    excess = np.where(open_bins & (power > limit), power, 0.0)
    top = int(np.argmax(excess))
    if excess[top] == 0:
        return None
    return float(frequency[top]), float(2 * np.sqrt(power[top]) / window.sum())


def slow_line(rest: Floats, step: float) -> tuple[float, float] | None:
    """The strongest line below `LOWEST_HZ` in a rest that no motion came before.

    After a motion the block swings on below the noise, and a hand that holds it trembles: neither is looked
    at here. The power by sine tapers stands `CLEAR` times above the medians of the bins on both sides, so
    that noise that falls or rises with the frequency shows no line.

    Parameters
    ----------
    rest : ndarray, shape (n_time,)
        The signal.
    step : float
        Sampling interval [s].

    Returns
    -------
    (frequency_hz, amplitude) or None
        None as well where the rest is too short.
    """
    still = rest[: round(LONGEST_S / step)]
    frequency = frequencies(still.size) / step
    lowest, highest = 1 + FEWEST + WIDE, int(np.searchsorted(frequency, LOWEST_HZ))
    if highest <= lowest or highest + WIDE + BESIDE > frequency.size:
        return None
    time = np.arange(still.size) - (still.size - 1) / 2
    level = still - still.mean()
    power = tapered_power(level - time * (time @ level) / (time @ time))
    floor = np.array(
        [
            max(
                np.median(power[max(1, i - WIDE - BESIDE) : i - WIDE]),
                np.median(power[i + WIDE + 1 : i + WIDE + 1 + BESIDE]),
            )
            for i in range(lowest, highest)
        ]
    )
    top = int(np.argmax(power[lowest:highest] / np.maximum(floor, np.finfo(float).tiny)))
    if not power[lowest + top] > CLEAR * floor[top] > 0:
        return None
    line = power[lowest + top - WIDE : lowest + top + WIDE + 1] - floor[top]
    return float(frequency[lowest + top]), float(np.sqrt(4 * line.sum() / still.size))
