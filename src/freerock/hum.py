"""Lines in the spectrum of a signal that stands still: the hum of the mains, and those of no known source."""

from typing import NamedTuple

import numpy as np

MAINS_BAND_HZ = 0.1  # the mains frequency is sought this far either side of its nominal value
HARMONICS = 3
AVERAGED_S = 0.1  # the beat with the mains is averaged over this long, which keeps it sharp and cheap
MOST_BLOCKS = 400  # of that length suffice for a fit
SEGMENT_S, MOST_SEGMENTS = 0.5, 200  # of the mean spectrum in which other lines are sought
LOWEST_HZ = 15.0  # below lie tremor, drift and the block itself
NEIGHBOURS = 20  # bins on either side whose median is the floor
SURE = 5.5  # standard deviations above the floor


class Hum(NamedTuple):
    """A hum fitted to the phases at rest.

    Its fundamental and harmonics are the real part of Σ weight · exp(2πi m f t). `stderr` is the standard
    error of its value at any instant, and `amplitude_stderr` that of its fundamental, both per unit of white
    noise.
    """

    frequency_hz: float
    amplitude: float
    weights: np.ndarray
    stderr: float
    amplitude_stderr: float

    def over(self, start_s: float, step: float, n: int):
        """The hum at n instants, evenly spaced."""
        length = min(n, 4096)
        m = np.arange(1, self.weights.size + 1)[:, None]
        turn = 2j * np.pi * self.frequency_hz
        within = np.exp(turn * m * step * np.arange(length))
        begins = start_s + step * length * np.arange(-(-n // length))
        at = self.weights * np.exp(turn * m * begins).T
        blocks = np.hstack([at.real, -at.imag]) @ np.vstack([within.real, within.imag])
        return blocks.ravel()[:n]


def fit_hum(time_s, deviation, mains_hz: float, step: float) -> Hum | None:
    """Fit mains hum to the deviations of a still signal from its level.

    The frequency is the peak of the periodogram within `MAINS_BAND_HZ` of the nominal one; with it,
    amplitudes and phases of the fundamental and its harmonics below the Nyquist frequency follow by linear
    least squares.

    Parameters
    ----------
    time_s, deviation : ndarray, shape (n,)
        Instants [s] and deviations, any unit, in the order of time; gaps are allowed.
    mains_hz : float
        Nominal frequency [Hz].
    step : float
        Sampling interval [s].

    Returns
    -------
    Hum or None
        None where there are too few samples to tell a sinusoid from noise.
    """
    block = max(1, round(AVERAGED_S / step))
    n_blocks = time_s.size // block
    m = np.arange(1, HARMONICS + 1)
    m = m[m * mains_hz * 1.01 * step < 0.5]
    if n_blocks < 3 or m.size == 0:
        return None
    kept = np.unique(np.linspace(0, n_blocks - 1, min(n_blocks, MOST_BLOCKS)).astype(int))
    t = time_s[: n_blocks * block].reshape(n_blocks, block)[kept]
    y = deviation[: n_blocks * block].reshape(n_blocks, block)[kept]

    span = t[-1, -1] - t[0, 0]
    beat, centre = (y * np.exp(-2j * np.pi * mains_hz * t)).mean(axis=1), t.mean(axis=1)
    reach = int(np.ceil(8 * span * MAINS_BAND_HZ))
    offsets = np.arange(-reach - 1, reach + 2) / (8 * span)
    power = np.array([abs(np.sum(beat * np.exp(-2j * np.pi * offset * centre))) ** 2 for offset in offsets])
    top = 1 + int(np.argmax(power[1:-1]))
    below, peak, above = power[top - 1 : top + 2]
    curvature = below - 2 * peak + above
    shift = np.clip(0.5 * (below - above) / curvature, -0.5, 0.5) if curvature < 0 else 0.0
    hum_hz = float(mains_hz + offsets[top] + shift / (8 * span))

    angle = 2 * np.pi * hum_hz * t.ravel()
    basis = np.stack([part(k * angle) for k in m for part in (np.cos, np.sin)], axis=1)
    weights = np.linalg.lstsq(basis.T @ basis, basis.T @ y.ravel(), rcond=None)[0]
    weights = weights[::2] - 1j * weights[1::2]
    n = t.size
    return Hum(hum_hz, float(abs(weights[0])), weights, float(np.sqrt(2 * m.size / n)), float(np.sqrt(2 / n)))


def other_line(segments, step: float, mains_hz: float | None) -> tuple[float, float] | None:
    """The strongest line in the spectrum of a still signal that is no harmonic of the mains.

    The mean spectrum of the segments (Hann window) stands above the median of its neighbourhood by more than
    chance allows: `SURE` standard deviations of the mean of as many exponential variables, in Wilson and
    Hilferty's approximation.

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
