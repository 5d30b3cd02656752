"""Interference in a still signal: that of the mains, its fit and its frequency where the rate is wrong.

Other lines in the spectrum do not come from the mains: they are folded, or a vibration.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.fft import fft, ifft, next_fast_len, rfft

from freerock.arrays import Complexes, Floats
from freerock.noise.signal_noise import StillSignal
from freerock.noise.spectrum import tapered_power

BAND_HZ = 0.25  # the mains frequency is sought this far either side of its nominal value
SOUGHT = 0.18  # of the nominal frequency, either side; short of the step from 50 to 60 Hz
FALSE_ALARM = 1e-6
HARMONICS = 3
AVERAGED_S = 0.1  # the beat with the mains is averaged over this long, which keeps it sharp and cheap
MOST_BLOCKS = 400  # of that length suffice for a fit
PER_BIN = 4  # frequencies tried in the width of a spectral line
SURE = 5.0  # standard errors by which a rest level differs from another, an interference from none
MAINS_KEEP = 0.005  # of their frequency: the mains stay so close to it
MAINS_HZ = (50.0, 60.0)  # anywhere on earth
FAINT = 0.1  # of the noise of one sample: an interference below this is not worth a word
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
        turned = np.exp(2j * np.pi * self.frequency_hz * time_s)
        total = np.zeros_like(turned)
        for weight in self.weights[::-1]:
            total += weight
            total *= turned
        return np.asarray(total.real)


def fit_mains(
    time_s: Floats, deviation: Floats, mains_hz: float, step: float, white: float = 0.0
) -> Mains | None:
    """Fit the interference of the mains to the deviations of a still signal from its level.

    The frequency is the peak of the periodogram within `BAND_HZ` of the nominal one. With it, amplitudes and
    phases of the fundamental and its harmonics below the Nyquist frequency follow by linear least squares.
    Whether the phase wanders is seen as by von Neumann (1941, doi:10.1214/aoms/1177731677).

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
    per_s = PER_BIN * (t[-1, -1] - t[0, 0])  # frequencies tried in one Hz
    reach = int(np.ceil(per_s * BAND_HZ))
    offsets = np.arange(-reach - 1, reach + 2) / per_s
    power = np.abs(np.exp(-2j * np.pi * np.outer(offsets, centre)) @ beat) ** 2
    top = 1 + int(np.argmax(power[1:-1]))
    found_hz = float(mains_hz + offsets[top] + _vertex(power[top - 1 : top + 2]) / per_s)
    steady = beat * np.exp(-2j * np.pi * (found_hz - mains_hz) * centre)
    near = np.diff(centre) < 2 * AVERAGED_S
    if near.sum() >= 3:  # a beat wanders that scatters more than its neighbours do (von Neumann 1941)
        quick = float(np.mean(np.abs(np.diff(steady)[near]) ** 2)) / 2
        slow = float(np.var(steady, ddof=1)) - quick
        steadily = MOST_LOST * float(abs(steady.mean())) ** 2
        if slow > max(steadily, 5 * quick / math.sqrt(float(near.sum()))):
            return None
    angle = 2 * np.pi * found_hz * np.outer(m, t)
    basis = np.vstack([np.cos(angle), np.sin(angle)])
    parts = np.linalg.lstsq(basis @ basis.T, basis @ y.ravel(), rcond=None)[0]
    weights = parts[: m.size] - 1j * parts[m.size :]
    of_amplitude = math.sqrt(2 * max(float(np.var(steady, ddof=2)), white**2 / block) / beat.size)
    return Mains(found_hz, float(abs(weights[0])), weights, math.sqrt(2 * m.size / t.size), of_amplitude)


def _vertex(power: Floats) -> float:
    """Where the parabola through three neighbours is highest, from the middle one, in their distance."""
    below, peak, above = power.tolist()
    curvature = below - 2 * peak + above
    return float(np.clip(0.5 * (below - above) / curvature, -0.5, 0.5)) if curvature < 0 else 0.0


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
    if not seen.all():
        values = np.interp(time, time[seen], values[seen])  # across gaps, lest their edges hide the line
    weighted = window * (values - (window @ values) / window.sum())
    window = np.where(seen, window, 0.0)
    step = (time[-1] - time[0]) / (time.size - 1)
    frequency, power = _power_near(mains_hz, weighted, step)
    band = np.flatnonzero(np.abs(frequency - mains_hz) < SOUGHT * mains_hz)
    if band.size < 16 * PER_BIN or 0.5 / step < (1 + SOUGHT) * mains_hz:
        return None
    noise = np.median(power[band]) / math.log(2)
    top = band[np.argmax(power[band])]
    if not power[top] > noise * math.log(band.size / PER_BIN / FALSE_ALARM):
        return None
    line_hz = frequency[top] + _vertex(power[top - 1 : top + 2]) * (frequency[1] - frequency[0])
    amplitude = 2 * math.sqrt(power[top]) / window.sum()
    centred = time - (window @ time) / window.sum()
    spread = 2 * noise / (window @ window) * ((window * centred) @ (window * centred))
    stderr = math.sqrt(spread) / (amplitude * (window @ centred**2)) / (2 * math.pi)
    return float(line_hz / mains_hz), float(stderr / mains_hz)


def _power_near(mains_hz: float, signal: Floats, step: float) -> tuple[Floats, Floats]:
    """Frequencies [Hz] within twice `SOUGHT` of the nominal one, `PER_BIN` to a bin, and the power at each.

    The transform takes a length without large prime factors. Its bins near the mains are those of a signal
    that lasts as long and has few samples. This one is padded with zeros, which gives the power between bins.
    """
    size = next_fast_len(signal.size, real=True)
    width = 1 / (size * step)
    first = math.ceil((1 - 2 * SOUGHT) * mains_hz / width)
    near = rfft(signal, size)[first : math.floor((1 + 2 * SOUGHT) * mains_hz / width) + 1]
    fine = fft(ifft(near), PER_BIN * near.size) if near.size else near
    return (first + np.arange(fine.size) / PER_BIN) * width, np.abs(fine) ** 2


def significant_mains(signal: StillSignal, mains_hz: float) -> Mains | None:
    """The interference of the mains, None where it is not significant or too faint to matter."""
    if not (signal.phases and mains_hz * signal.step < 0.5):
        return None
    mains = fit_mains(*signal.inside, mains_hz, signal.step, signal.noise)
    if mains and mains.amplitude > max(SURE * mains.amplitude_stderr, FAINT * signal.noise):
        return mains
    return None


def other_mains(signal: StillSignal, mains_hz: float) -> tuple[float, Mains] | None:
    """The mains at the other nominal frequency [Hz] of `MAINS_HZ`, and their interference; None if not seen.

    They are the highest line near it and as close to it as the mains stay.
    """
    for other_hz in MAINS_HZ:
        if abs(other_hz - mains_hz) < 2 * MAINS_KEEP * mains_hz:
            continue
        found = significant_mains(signal, other_hz)
        seen = seen_mains(signal, other_hz) if found else None
        if found and seen and abs(seen[0] - 1) < MAINS_KEEP + SURE * seen[1]:
            return other_hz, found
    return None


def seen_mains(signal: StillSignal, mains_hz: float) -> tuple[float, float] | None:
    """As `mains_ratio`, of the longest quiet stretch; mains that wander differ between its halves."""
    if not signal.phases:
        return None
    first, last = max(signal.quiet(), key=lambda ends: ends[1] - ends[0])
    middle = (first + last) // 2
    parts = slice(first, last), slice(first, middle), slice(middle, last)
    whole, *halves = (mains_ratio(signal.time_s[each], signal.values[each], mains_hz) for each in parts)
    seen = [each[0] for each in halves if each]
    return whole and (whole[0], math.hypot(whole[1], float(np.std(seen)) if len(seen) == 2 else 0.0))


SEGMENT_S, MOST_SEGMENTS = 0.5, 200  # of the mean spectrum in which lines are sought
LOWEST_HZ = 15.0  # below lie tremor, drift and the block itself
NEIGHBOURS = 20  # bins on either side whose median is the floor
ABOVE = 5.5  # standard deviations above the floor
LONGEST_S = 10.0  # of a rest in which a slow line is sought
WIDE, BESIDE = 3, 16  # bins on either side that a slow line fills, and next to these, whose median it exceeds
FEWEST = 6  # of the latter towards zero
CLEAR = 12.0  # times that median


def other_line(signal: StillSignal, mains_hz: float | None) -> tuple[float, float] | None:
    """The strongest line in the spectrum of a still signal that is no harmonic of the mains.

    The mean spectrum of the segments (Hann window), all made equally loud, stands above the median of its
    neighbourhood by more than chance allows: `ABOVE` standard deviations of the mean of as many exponential
    variables, in the approximation of Wilson and Hilferty (1931, doi:10.1073/pnas.17.12.684).

    Parameters
    ----------
    signal : StillSignal
        Its quiet stretches are cut into segments of `SEGMENT_S`, of which `MOST_SEGMENTS` are taken.
    mains_hz : float or None
        Frequency [Hz] whose harmonics are passed over.

    Returns
    -------
    (frequency_hz, amplitude) or None
    """
    n = round(SEGMENT_S / signal.step)
    found = [slice(i, i + n) for first, last in signal.quiet() for i in range(first, last - n + 1, n)]
    parts = [signal.values[part] for part in found[:: -(-len(found) // MOST_SEGMENTS) or 1]]
    segments = np.array([part for part in parts if np.isfinite(part).all()]).reshape(-1, n)
    k = len(segments)
    if k < 2 or n < 4 * NEIGHBOURS:
        return None
    window = np.hanning(n)
    level = segments - segments.mean(axis=1, keepdims=True)
    square = np.mean(level**2, axis=1, keepdims=True)
    level *= np.sqrt(square.mean() / np.where(square > 0, square, 1.0))
    power = (np.abs(np.fft.rfft(level * window, axis=1)) ** 2).mean(axis=0)
    frequency = np.fft.rfftfreq(n, signal.step)
    width = frequency[1]
    padded = np.pad(power, NEIGHBOURS, mode="reflect")
    floor = np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1), axis=1)
    limit = floor * k / (k - 1 / 3) * (1 - 1 / (9 * k) + ABOVE / (3 * np.sqrt(k))) ** 3
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
    lowest = 1 + FEWEST + WIDE
    if still.size < lowest:
        return None
    time = np.arange(still.size) - (still.size - 1) / 2
    level = still - still.mean()
    frequency, power = tapered_power(level - time * (time @ level) / (time @ time))
    frequency, highest = frequency / step, int(np.searchsorted(frequency / step, LOWEST_HZ))
    if highest <= lowest or highest + WIDE + BESIDE > frequency.size:
        return None
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
