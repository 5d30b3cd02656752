"""Interference of the mains in a still signal: its fit, and its frequency where the rate is wrong."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Complexes, Floats

BAND_HZ = 0.25  # the mains frequency is sought this far either side of its nominal value
SOUGHT = 0.18  # of the nominal frequency, either side; short of the step from 50 to 60 Hz
FALSE_ALARM = 1e-6
HARMONICS = 3
AVERAGED_S = 0.1  # the beat with the mains is averaged over this long, which keeps it sharp and cheap
MOST_BLOCKS = 400  # of that length suffice for a fit
PER_BIN = 4  # frequencies tried in the width of a spectral line
MOST_LOST = 0.05  # where a steady phase would lose a larger share of the power, it wanders


class Mains(NamedTuple):
    """Interference of the mains, fitted to the phases at rest.

    Its fundamental and harmonics are the real part of Σ weight · exp(im 2π f t). `stderr` is the standard
    error of its value at any instant per unit of white noise, and `amplitude_stderr` that of its fundamental
    in the noise as it is within 5 Hz of it.
    """

    frequency_hz: float
    amplitude: float
    weights: Complexes
    stderr: float
    amplitude_stderr: float

    def over(self, time_s: Floats) -> Floats:
        """Its values at some instants [s]."""
        turn = 2j * np.pi * self.frequency_hz * np.arange(1, self.weights.size + 1)
        return np.asarray((self.weights @ np.exp(np.outer(turn, time_s))).real)


def fit_mains(
    time_s: Floats, deviation: Floats, mains_hz: float, step: float, white: float = 0.0
) -> Mains | None:
    """Fit the interference of the mains to the deviations of a still signal from its level.

    The frequency is the peak of the periodogram within `BAND_HZ` of the nominal one. With it, amplitudes and
    phases of the fundamental and its harmonics below the Nyquist frequency follow by linear least squares.

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
        None where there are too few samples to distinguish a sinusoid from noise, and where the phase
        wanders: what a rest shows of it says nothing of a motion.
    """
    block = max(1, round(AVERAGED_S / step))
    n_blocks = time_s.size // block
    m = np.arange(1, HARMONICS + 1)
    m = m[m * mains_hz * 1.01 * step < 0.5]
    if n_blocks < 3 or m.size == 0:
        return None
    kept = np.arange(n_blocks)
    kept = kept[kept // 2 % -(-n_blocks // MOST_BLOCKS) == 0]  # neighbours in pairs
    t, y = (each[: n_blocks * block].reshape(-1, block)[kept] for each in (time_s, deviation))
    nominal = 2 * np.pi * mains_hz * t  # sines are a fifth of the work of a complex exponential
    beat = (y * np.cos(nominal)).mean(axis=1) - 1j * (y * np.sin(nominal)).mean(axis=1)
    centre = t.mean(axis=1)
    found_hz = _highest(mains_hz, centre, beat, t[-1, -1] - t[0, 0])
    steady = beat * np.exp(-2j * np.pi * (found_hz - mains_hz) * centre)
    if _wanders(centre, steady):
        return None
    angle = 2 * np.pi * found_hz * np.outer(m, t)
    basis = np.vstack([np.cos(angle), np.sin(angle)])
    parts = np.linalg.lstsq(basis @ basis.T, basis @ y.ravel(), rcond=None)[0]
    weights = parts[: m.size] - 1j * parts[m.size :]
    of_amplitude = math.sqrt(2 * max(float(np.var(steady, ddof=2)), white**2 / block) / beat.size)
    return Mains(found_hz, float(abs(weights[0])), weights, math.sqrt(2 * m.size / t.size), of_amplitude)


def _highest(mains_hz: float, centre: Floats, beat: Complexes, span: float) -> float:
    """Frequency [Hz] of the highest power of a beat with the mains, within `BAND_HZ` of theirs."""
    reach = int(np.ceil(PER_BIN * span * BAND_HZ))
    offsets = np.arange(-reach - 1, reach + 2) / (PER_BIN * span)
    power = np.abs(np.exp(-2j * np.pi * np.outer(offsets, centre)) @ beat) ** 2
    top = 1 + int(np.argmax(power[1:-1]))
    return float(mains_hz + offsets[top] + _vertex(power[top - 1 : top + 2]) / (PER_BIN * span))


def _vertex(power: Floats) -> float:
    """Where the parabola through three neighbours is highest, from the middle one, in their distance."""
    below, peak, above = power.tolist()
    curvature = below - 2 * peak + above
    return float(np.clip(0.5 * (below - above) / curvature, -0.5, 0.5)) if curvature < 0 else 0.0


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

    With weights w over centred times t, the variance of its angular frequency is 2 σ² Σw²t² / (A Σwt²)², for
    the amplitude A in white noise of variance σ² (for even weights the Cramér–Rao bound): there the slope of
    the power vanishes, so to first order the error is the noise of the slope, over the curvature.

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
    step, padded = (time[-1] - time[0]) / (time.size - 1), PER_BIN * time.size
    frequency = np.fft.rfftfreq(padded, step)
    power = np.abs(np.fft.rfft(weighted, padded)) ** 2
    band = np.flatnonzero(np.abs(frequency - mains_hz) < SOUGHT * mains_hz)
    if band.size < 16 * PER_BIN or frequency[-1] < (1 + SOUGHT) * mains_hz:
        return None
    noise = np.median(power[band]) / math.log(2)
    top = band[np.argmax(power[band])]
    if not power[top] > noise * math.log(band.size / PER_BIN / FALSE_ALARM):
        return None
    line_hz = frequency[top] + _vertex(power[top - 1 : top + 2]) * frequency[1]
    amplitude = 2 * math.sqrt(power[top]) / window.sum()
    centred = time - (window @ time) / window.sum()
    spread = 2 * noise / (window @ window) * ((window * centred) @ (window * centred))
    stderr = math.sqrt(spread) / (amplitude * (window @ centred**2)) / (2 * math.pi)
    return float(line_hz / mains_hz), float(stderr / mains_hz)
