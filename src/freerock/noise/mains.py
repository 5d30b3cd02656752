"""Interference of the mains in a still signal: its fit, and its frequency where the rate is wrong."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from freerock.arrays import Complexes, Floats, Indices

BAND_HZ = 0.25  # the mains frequency is sought this far either side of its nominal value
SOUGHT = 0.18  # of the nominal frequency, either side; short of the step from 50 to 60 Hz
FALSE_ALARM = 1e-6
HARMONICS = 3
AVERAGED_S = 0.1  # the beat with the mains is averaged over this long, which keeps it sharp and cheap
MOST_BLOCKS = 400  # of that length suffice for a fit
PER_BIN = 4  # frequencies tried in the width of a spectral line
WANDER_S = 10.0  # the phase is followed over so long
MOST_LOST = 0.05  # where a steady phase would lose a larger share of the power


class Mains(NamedTuple):
    """Interference of the mains, fitted to the phases at rest.

    Its fundamental and harmonics are the real part of Σ weight · exp(im (2π f t + φ)); the phase φ is linear
    between the instants of `phase`, two rows (0 throughout where it is steady). `stderr` is the standard
    error of its value at any instant per unit of white noise, and `amplitude_stderr` that of its fundamental
    in the noise as it is within 5 Hz of it.
    """

    frequency_hz: float
    amplitude: float
    weights: Complexes
    phase: Floats
    stderr: float
    amplitude_stderr: float

    def over(self, start_s: float, step: float, n: int) -> Floats:
        """Its values at n instants, evenly spaced."""
        length = min(n, max(1, round(AVERAGED_S / step)))
        m = np.arange(1, self.weights.size + 1)[:, None]
        turn = 2j * np.pi * self.frequency_hz
        within = np.exp(turn * m * step * np.arange(length))
        begins = start_s + step * length * np.arange(-(-n // length))
        phase = np.interp(begins + step * length / 2, *self.phase)
        at = self.weights * np.exp(m * (turn * begins + 1j * phase)).T
        blocks: Floats = np.hstack([at.real, -at.imag]) @ np.vstack([within.real, within.imag])
        return blocks.ravel()[:n]


def mains_samples(n: int, step: float) -> Indices:
    """Numbers of those of n samples, `step` seconds apart, that a fit of the mains takes: blocks of them."""
    block = max(1, round(AVERAGED_S / step))
    n_blocks = n // block
    kept = np.unique(np.linspace(0, n_blocks - 1, min(n_blocks, MOST_BLOCKS)).astype(np.intp))
    return (kept[:, None] * block + np.arange(block)).ravel()


def fit_mains(
    time_s: Floats, deviation: Floats, mains_hz: float, step: float, white: float = 0.0
) -> Mains | None:
    """Fit the interference of the mains to the deviations of a still signal from its level.

    The frequency is the peak of the periodogram within `BAND_HZ` of the nominal one; where it wanders,
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
    white : float
        Standard deviation of the white noise of a sample: near the mains there is no less.

    Returns
    -------
    Mains or None
        None where there are too few samples to distinguish a sinusoid from noise, and where the phase wanders
        faster than it is followed: what a rest shows of it says nothing of a motion.
    """
    block = max(1, round(AVERAGED_S / step))
    n_blocks = time_s.size // block
    m = np.arange(1, HARMONICS + 1)
    m = m[m * mains_hz * 1.01 * step < 0.5]
    if n_blocks < 3 or m.size == 0:
        return None
    kept = mains_samples(time_s.size, step)
    t, y = (each[kept].reshape(-1, block) for each in (time_s, deviation))
    nominal = 2 * np.pi * mains_hz * t  # sines are a fifth of the work of a complex exponential
    beat = (y * np.cos(nominal)).mean(axis=1) - 1j * (y * np.sin(nominal)).mean(axis=1)
    centre = t.mean(axis=1)
    found_hz = _highest(mains_hz, centre, beat, t[-1, -1] - t[0, 0])
    beat = beat * np.exp(-2j * np.pi * (found_hz - mains_hz) * centre)
    phase, together = _followed(centre, beat)
    steady = beat * np.exp(-1j * np.interp(centre, *phase))
    if _wanders(centre, steady):
        return None

    angle = 2 * np.pi * found_hz * t.ravel() + np.interp(t.ravel(), *phase)
    turns = np.empty((m.size, 2, t.size))  # cosine and sine of each harmonic
    cosine, sine = np.cos(angle, out=turns[0, 0]), np.sin(angle, out=turns[0, 1])
    for before, after in pairwise(turns):
        np.subtract(before[0] * cosine, before[1] * sine, out=after[0])
        np.add(before[1] * cosine, before[0] * sine, out=after[1])
    basis = turns.reshape(-1, t.size)
    parts = np.linalg.lstsq(basis @ basis.T, basis @ y.ravel(), rcond=None)[0]
    weights = parts[::2] - 1j * parts[1::2]
    n = t.size
    stderr = math.sqrt(2 * m.size / n + (2 / (together * block) if together < len(beat) else 0.0))
    of_amplitude = math.sqrt(2 * max(float(np.var(steady, ddof=2)), white**2 / block) / beat.size)
    return Mains(found_hz, float(abs(weights[0])), weights, phase, stderr, of_amplitude)


def _highest(mains_hz: float, centre: Floats, beat: Complexes, span: float) -> float:
    """Frequency [Hz] of the highest power of a beat with the mains, within `BAND_HZ` of theirs."""
    reach = int(np.ceil(PER_BIN * span * BAND_HZ))
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
    return float(mains_hz + offsets[top] + shift / (PER_BIN * span))


def _followed(centre: Floats, beat: Complexes) -> tuple[Floats, int]:
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


def _wanders(centre: Floats, steady: Complexes) -> bool:
    """Whether a beat scatters more than its neighbours do (von Neumann 1941, doi:10.1214/aoms/1177731677)."""
    near = np.diff(centre) < 2 * AVERAGED_S
    if near.sum() < 3:
        return False
    quick = float(np.mean(np.abs(np.diff(steady)[near]) ** 2)) / 2
    slow = float(np.var(steady, ddof=1)) - quick
    return slow > max(MOST_LOST * float(abs(steady.mean())) ** 2, 5 * quick / math.sqrt(float(near.sum())))


def mains_ratio(time_s: ArrayLike, signal: ArrayLike, mains_hz: float) -> tuple[float, float] | None:
    """Frequency of the mains in a signal over the nominal one: the declared sampling rate over the true.

    They are the highest line of the periodogram (Hann window) within `SOUGHT` of the nominal frequency. It
    counts as seen when noise of the level around it would be as high with a probability P below
    `FALSE_ALARM`: the power of white noise in a bin is exponential, its mean the median over ln 2, and
    the highest of n exceeds ln(n/P) means with probability P.

    Parameters
    ----------
    time_s : array, shape (n,)
        Evenly spaced instants [s].
    signal : array, shape (n,)
        Any unit; NaN where missing. A phase at rest shows the mains best.
    mains_hz : float
        Nominal frequency [Hz].

    Returns
    -------
    (float, float) or None
        Ratio and its standard error; None when no interference is visible. The mains themselves stay within
        about 0.4 % of the nominal frequency.
    """
    time, values = np.asarray(time_s, float), np.asarray(signal, float)
    seen = np.isfinite(values)
    if seen.sum() < 16:
        return None
    window = np.hanning(time.size)
    values = np.interp(time, time[seen], values[seen])  # across gaps, lest their edges hide the line
    weighted = window * (values - (window @ values) / window.sum())
    window = np.where(seen, window, 0.0)
    step = (time[-1] - time[0]) / (time.size - 1)
    frequency = np.fft.rfftfreq(time.size, step)
    power = np.abs(np.fft.rfft(weighted)) ** 2
    band = np.flatnonzero(np.abs(frequency - mains_hz) < SOUGHT * mains_hz)
    if band.size < 16 or frequency[-1] < (1 + SOUGHT) * mains_hz:
        return None
    noise = np.median(power[band]) / math.log(2)
    peak = band[np.argmax(power[band])]
    if not power[peak] > noise * math.log(band.size / FALSE_ALARM):
        return None
    line_hz, stderr = _line(time, weighted, window, frequency[peak], noise)
    return float(line_hz / mains_hz), float(stderr / mains_hz)


def _line(
    time: Floats, weighted: Floats, window: Floats, near_hz: float, noise: float
) -> tuple[float, float]:
    """Frequency of a line near another [Hz], and its standard error.

    The maximum of the windowed periodogram, with weights w over centred times t, has the variance
    2 σ² Σw²t² / (A Σwt²)² of its angular frequency, for the amplitude A in white noise of variance σ² (for
    even weights the Cramér–Rao bound): there the slope of the power vanishes, so to first order the error is
    the noise of the slope, over the curvature.
    """
    centred = time - (window @ time) / window.sum()
    near = _demodulated(weighted, centred, near_hz)
    offset = _maximum(*near, 1 / (time[-1] - time[0]))
    amplitude = 2 * math.sqrt(_power(*near, offset)) / window.sum()
    variance = noise / (window @ window)
    spread = 2 * variance * ((window * centred) @ (window * centred))
    stderr = math.sqrt(spread) / (amplitude * (window @ centred**2)) / (2 * math.pi)
    return near_hz + offset, stderr


def _demodulated(
    weighted: Floats, time: Floats, frequency_hz: float, blocks: int = 4096
) -> tuple[Floats, Complexes]:
    """Signal shifted down by a frequency and summed in blocks, with the blocks' mean times."""
    edges = np.unique(np.linspace(0, time.size, blocks + 1).astype(int))[:-1]
    shifted = np.add.reduceat(weighted * np.exp(-2j * np.pi * frequency_hz * time), edges)
    return np.add.reduceat(time, edges) / np.diff(np.append(edges, time.size)), shifted


def _power(time: Floats, shifted: Complexes, offset_hz: float) -> float:
    return float(abs(shifted @ np.exp(-2j * np.pi * offset_hz * time)) ** 2)


def _maximum(time: Floats, shifted: Complexes, bin_hz: float) -> float:
    """Offset of the highest power [Hz], within one bin of 0."""
    found = minimize_scalar(
        lambda offset_hz: -_power(time, shifted, offset_hz),
        bounds=(-bin_hz, bin_hz),
        method="bounded",
        options={"xatol": 1e-7 * bin_hz},
    )
    return float(found.x)
