"""The noise of a signal: σ of a sample, interference of the mains, rests that move, while it stands still.

The spectrum of the noise of θ, on which errors of fits rest, is that of `noise.spectrum`.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from freerock.arrays import Floats
from freerock.noise.converter import scatter
from freerock.noise.lines import MOST_SEGMENTS, SEGMENT_S
from freerock.noise.mains import Mains, fit_mains, mains_ratio
from freerock.noise.still import Phase, stationary_phases

SURE = 5.0  # standard errors by which a rest level differs from another, an interference from none
MAINS_KEEP = 0.005  # of their frequency: the mains stay so close to it
MAINS_HZ = (50.0, 60.0)  # anywhere on earth
COARSE_STEP = 1.5  # times the noise: a step that differences of neighbours no longer see through
FAINT = 0.1  # of the noise of one sample: an interference below this is not worth a word


@dataclass(frozen=True)
class StillSignal:
    """A signal, NaN where invalid, sampled every `step` seconds, and its phases of stillness.

    Samples closer than half the window to the end of a phase are not taken as still.

    Parameters
    ----------
    time_s, values : ndarray, shape (n_time,)
        Time [s], and the signal in its own unit.
    step, window_s : float
        Sampling interval, and window of `still.stationary_phases` [s].
    lattice : float
        Step of the converter, in the signal's unit; 0 where there is none.
    """

    time_s: Floats
    values: Floats
    step: float
    window_s: float
    lattice: float = 0.0

    @cached_property
    def phases(self) -> list[Phase]:
        """The phases of stillness."""
        return stationary_phases(self.time_s, self.values, window_s=self.window_s)

    @cached_property
    def rests(self) -> list[Phase]:
        """The phases in which θ is zero."""
        return [phase for phase in self.phases if phase.kind == "rest"]

    @cached_property
    def inside(self) -> tuple[Floats, Floats]:
        """Instants of the valid samples within the phases, and their deviations from a phase's level."""
        margin, times, deviations = self.window_s / 2, [np.empty(0)], [np.empty(0)]
        for phase in self.phases:
            part = slice(*np.searchsorted(self.time_s, (phase.start_s + margin, phase.end_s - margin)))
            valid = np.isfinite(self.values[part])
            times.append(self.time_s[part][valid])
            deviations.append(self.values[part][valid] - phase.level)
        return np.concatenate(times), np.concatenate(deviations)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a sample's white noise, rounding by the converter included.

        From differences of neighbours, those beyond 6 MADs left out; where the converter hides the noise,
        from the samples about the level of their phase (`converter.scatter`).
        """
        if not self.phases:
            return math.nan
        time_s, deviation = self.inside
        difference = np.diff(deviation)[np.diff(time_s) < 1.5 * self.step]
        limit = max(6 * np.median(np.abs(difference)) / 0.6745, COARSE_STEP * self.lattice)
        white = float(np.sqrt(np.mean(difference[np.abs(difference) <= limit] ** 2) / 2))
        if self.lattice > COARSE_STEP * white:
            of_all = scatter([self.values[first:last] for first, last in self.quiet()], self.lattice)
            return of_all if self.lattice > COARSE_STEP * of_all else white
        return white

    def quiet(self) -> Iterator[tuple[int, int]]:
        """First and last sample of the phases; of a rest after a motion, of its second half."""
        margin = self.window_s / 2
        for phase in self.phases:
            swung = phase.kind != "held" and phase.start_s > self.time_s[0] + margin
            start = phase.mid_s if swung else phase.start_s + margin
            first, last = np.searchsorted(self.time_s, (start, phase.end_s - margin)).tolist()
            yield first, last

    @property
    def untouched(self) -> Floats:
        """The rest with which the record begins; empty where there is none, or a gap in it."""
        margin = self.window_s / 2
        first = next(iter(self.phases), None)
        if first is None or first.kind != "rest" or first.start_s > self.time_s[0] + margin:
            return np.empty(0)
        found = self.values[slice(*np.searchsorted(self.time_s, (first.start_s, first.end_s - margin)))]
        return found if np.isfinite(found).all() else np.empty(0)

    def segments(self) -> Floats:
        """Whole quiet stretches of one length, at most `MOST_SEGMENTS`, shape (n_segments, n_samples)."""
        n = round(SEGMENT_S / self.step)
        found = [slice(i, i + n) for first, last in self.quiet() for i in range(first, last - n + 1, n)]
        kept = found[:: -(-len(found) // MOST_SEGMENTS) or 1]
        parts = [self.values[part] for part in kept if np.isfinite(self.values[part]).all()]
        return np.array(parts).reshape(-1, n)


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
    """As `mains.mains_ratio`, of the longest quiet stretch; mains that wander differ between its halves."""
    if not signal.phases:
        return None
    first, last = max(signal.quiet(), key=lambda ends: ends[1] - ends[0])
    middle = (first + last) // 2
    parts = slice(first, last), slice(first, middle), slice(middle, last)
    whole, *halves = (mains_ratio(signal.time_s[each], signal.values[each], mains_hz) for each in parts)
    seen = [each[0] for each in halves if each]
    return whole and (whole[0], math.hypot(whole[1], float(np.std(seen)) if len(seen) == 2 else 0.0))
