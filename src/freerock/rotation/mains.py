"""Lines in the spectrum of a signal that stands still: the hum of the mains, and those of no known source."""

import math
from typing import NamedTuple

import numpy as np

MAINS_BAND_HZ = 0.25  # the mains frequency is sought this far either side of its nominal value
MAINS_SEARCH = 0.18  # of the nominal frequency, either side; short of the step from 50 to 60 Hz
MAINS_FALSE_ALARM = 1e-6
HARMONICS = 3
AVERAGED_S = 0.1  # the beat with the mains is averaged over this long, which keeps it sharp and cheap
MOST_BLOCKS = 400  # of that length suffice for a fit
PER_BIN = 4  # frequencies tried in the width of a spectral line
WANDER_S, MOST_LOST = (
    10.0,
    0.05,
)  # the phase is followed over so long where a steady one loses this much power
SEGMENT_S, MOST_SEGMENTS = 0.5, 200  # of the mean spectrum in which other lines are sought
LOWEST_HZ = 15.0  # below lie tremor, drift and the block itself
NEIGHBOURS = 20  # bins on either side whose median is the floor
SURE = 5.5  # standard deviations above the floor


class Hum(NamedTuple):
    """A hum fitted to the phases at rest.

    Its fundamental and harmonics are the real part of Σ weight · exp(im (2π f t + φ)); the phase φ is linear
    between the instants of `phase`, two rows (0 throughout for a steady hum). `stderr` is the standard error
    of its value at any instant, and `amplitude_stderr` that of its fundamental, both per unit of white noise.
    """

    frequency_hz: float
    amplitude: float
    weights: np.ndarray
    phase: np.ndarray
    stderr: float
    amplitude_stderr: float

    def over(self, start_s: float, step: float, n: int):
        """The hum at n instants, evenly spaced."""
        length = min(n, max(1, round(AVERAGED_S / step)))
        m = np.arange(1, self.weights.size + 1)[:, None]
        turn = 2j * np.pi * self.frequency_hz
        within = np.exp(turn * m * step * np.arange(length))
        begins = start_s + step * length * np.arange(-(-n // length))
        phase = np.interp(begins + step * length / 2, *self.phase)
        at = self.weights * np.exp(m * (turn * begins + 1j * phase)).T
        blocks = np.hstack([at.real, -at.imag]) @ np.vstack([within.real, within.imag])
        return blocks.ravel()[:n]


def fit_hum(time_s, deviation, mains_hz: float, step: float) -> Hum | None:
    """Fit mains hum to the deviations of a still signal from its level.

    The frequency is the peak of the periodogram within `MAINS_BAND_HZ` of the nominal one; where it wanders,
    the phase is followed. With them, amplitudes and phases of the fundamental and its harmonics below the
    Nyquist frequency follow by linear least squares.

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
    reach = int(np.ceil(PER_BIN * span * MAINS_BAND_HZ))
    offsets = np.arange(-reach - 1, reach + 2) / (PER_BIN * span)
    fine = math.isqrt(offsets.size)  # offsets are sums of a coarse and a fine one
    turns = (
        np.exp(-2j * np.pi * np.outer(o, centre)) for o in (offsets[::fine], offsets[:fine] - offsets[0])
    )
    power = (np.abs((next(turns) * beat) @ next(turns).T) ** 2).ravel()[: offsets.size]
    top = 1 + int(np.argmax(power[1:-1]))
    below, peak, above = power[top - 1 : top + 2]
    curvature = below - 2 * peak + above
    shift = np.clip(0.5 * (below - above) / curvature, -0.5, 0.5) if curvature < 0 else 0.0
    hum_hz = float(mains_hz + offsets[top] + shift / (PER_BIN * span))
    phase, together = _followed(centre, beat * np.exp(-2j * np.pi * (hum_hz - mains_hz) * centre))

    angle = 2 * np.pi * hum_hz * t.ravel() + np.interp(t.ravel(), *phase)
    basis = np.stack([part(k * angle) for k in m for part in (np.cos, np.sin)], axis=1)
    weights = np.linalg.lstsq(basis.T @ basis, basis.T @ y.ravel(), rcond=None)[0]
    weights = weights[::2] - 1j * weights[1::2]
    n = t.size
    stderr = math.sqrt(2 * m.size / n + (2 / (together * block) if together < len(beat) else 0.0))
    return Hum(hum_hz, float(abs(weights[0])), weights, phase, stderr, math.sqrt(2 / n))


def _followed(centre, beat):
    """Phase of a beat over time, as rows of instants and phases, and the beats in one mean of it.

    It is 0 throughout where the beat is steady: where means over `WANDER_S` hold no more power than that of
    all, but for what noise adds.
    """
    steady = np.array([[centre[0], centre[-1]], [0.0, 0.0]]), len(beat)
    edges = np.searchsorted(centre, np.arange(centre[0], centre[-1], WANDER_S))
    edges = edges[np.diff(edges, prepend=-len(beat)) > 1]
    count = np.diff(np.append(edges, len(beat)))
    if count.size < 4 or count.min() < 2 or not (np.diff(centre) < WANDER_S / 4).any():
        return steady
    means = np.add.reduceat(beat, edges) / count
    noise = (
        float(np.mean(np.abs(beat - np.repeat(means, count)) ** 2)) * count.size / (len(beat) - count.size)
    )
    power = float(np.mean(np.abs(means) ** 2)) - noise
    of_all = abs(beat.mean()) ** 2
    chance = math.sqrt((2 * of_all + noise) * noise / count.size)
    if power - of_all < max(MOST_LOST * of_all, 5 * chance):
        return steady
    near = np.diff(centre) < WANDER_S / 4
    turn = np.angle((beat[1:] * beat[:-1].conj())[near].sum()) / np.diff(centre)[near].mean()  # on average
    means = np.add.reduceat(beat * np.exp(-1j * turn * centre), edges)
    at = np.add.reduceat(centre, edges) / count
    return np.array([at, turn * at + np.unwrap(np.angle(means))]), int(count.min())


def other_line(segments, step: float, mains_hz: float | None) -> tuple[float, float] | None:
    """The strongest line in the spectrum of a still signal that is no harmonic of the mains.

    The mean spectrum of the segments (Hann window) stands above the median of its neighbourhood by more than
    chance allows: `SURE` standard deviations of the mean of as many exponential variables, in the
    approximation of Wilson and Hilferty (1931, doi:10.1073/pnas.17.12.684).

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


def mains_ratio(time_s, signal, mains_hz: float) -> tuple[float, float] | None:
    """Frequency of the mains hum in a signal over the nominal one: the declared sampling rate over the true.

    The hum is the highest line of the periodogram (Hann window) within MAINS_SEARCH of the nominal frequency.
    It counts as seen when noise of the level around it would be as high with a probability P below
    MAINS_FALSE_ALARM: the power of white noise in a bin is exponential, its mean the median over ln 2, and
    the highest of n exceeds ln(n/P) means with probability P. The maximum of the windowed periodogram, with
    weights w over centred times t, has the variance 2 σ² Σw²t² / (A Σwt²)² of its angular frequency, for the
    amplitude A in white noise of variance σ² (for even weights the Cramér–Rao bound): there the slope of the
    power vanishes, so to first order the error is the noise of the slope, over the curvature.

    Parameters
    ----------
    time_s : array, shape (n,)
        Evenly spaced instants [s].
    signal : array, shape (n,)
        Any unit; NaN where missing. A phase at rest shows the hum best.
    mains_hz : float
        Nominal frequency [Hz].

    Returns
    -------
    (float, float) or None
        Ratio and its standard error; None when no hum is visible. The mains themselves stay within about
        0.4 % of the nominal frequency.
    """
    time, signal = np.asarray(time_s, float), np.asarray(signal, float)
    seen = np.isfinite(signal)
    if seen.sum() < 16:
        return None
    window = np.hanning(time.size)
    signal = np.interp(time, time[seen], signal[seen])  # across gaps, lest their edges hide the hum
    weighted = window * (signal - (window @ signal) / window.sum())
    window = np.where(seen, window, 0.0)
    step = (time[-1] - time[0]) / (time.size - 1)
    frequency = np.fft.rfftfreq(time.size, step)
    power = np.abs(np.fft.rfft(weighted)) ** 2
    band = np.flatnonzero(np.abs(frequency - mains_hz) < MAINS_SEARCH * mains_hz)
    if band.size < 16 or frequency[-1] < (1 + MAINS_SEARCH) * mains_hz:
        return None
    noise = np.median(power[band]) / math.log(2)
    peak = band[np.argmax(power[band])]
    if not power[peak] > noise * math.log(band.size / MAINS_FALSE_ALARM):
        return None

    centred = time - (window @ time) / window.sum()
    near = _demodulated(weighted, centred, frequency[peak])
    offset = _maximum(*near, 1 / (time[-1] - time[0]))
    amplitude = 2 * math.sqrt(_power(*near, offset)) / window.sum()
    variance = noise / (window @ window)
    spread = 2 * variance * ((window * centred) @ (window * centred))
    stderr = math.sqrt(spread) / (amplitude * (window @ centred**2)) / (2 * math.pi)
    return float((frequency[peak] + offset) / mains_hz), float(stderr / mains_hz)


def _demodulated(weighted, time, frequency_hz, blocks=4096):
    """Signal shifted down by a frequency and summed in blocks, with the blocks' mean times."""
    edges = np.unique(np.linspace(0, time.size, blocks + 1).astype(int))[:-1]
    shifted = np.add.reduceat(weighted * np.exp(-2j * np.pi * frequency_hz * time), edges)
    return np.add.reduceat(time, edges) / np.diff(np.append(edges, time.size)), shifted


def _power(time, shifted, offset_hz):
    return abs(shifted @ np.exp(-2j * np.pi * offset_hz * time)) ** 2


def _maximum(time, shifted, bin_hz):
    """Offset of the highest power [Hz], within one bin of 0, by ternary search."""
    low, high = -bin_hz, bin_hz
    while high - low > 1e-7 * bin_hz:
        third = (high - low) / 3
        if _power(time, shifted, low + third) < _power(time, shifted, high - third):
            low += third
        else:
            high -= third
    return (low + high) / 2
