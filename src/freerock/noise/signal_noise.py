"""Returns σ of a sample of a signal, from where it stands still, and the step of the converter.

The noise of θ, on which errors of fits rest, is found by `rotation_noise`; mains by `interference`.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from freerock.arrays import Floats, Indices
from freerock.noise.still_phases import Phase, stationary_phases

COARSE_STEP = 1.5  # times the noise: a step that differences of neighbours no longer see through


@dataclass(frozen=True)
class StillSignal:
    """A signal, NaN where invalid, sampled every `step` seconds, and its phases of stillness.

    Samples closer than half the window to the end of a phase are not taken as still.

    Parameters
    ----------
    time_s, values : ndarray, shape (n_time,)
        Time [s], and the signal in its own unit.
    step, window_s : float
        Sampling interval, and window of `still_phases.stationary_phases` [s].
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
        from the samples about the level of their phase (`scatter`).
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


STEP_SAMPLES = 20_000  # suffice to see the step
CLOSE = 0.05  # share of the gaps between values that are smaller than the one taken for the step
ON_LATTICE = 0.98  # share of the gaps that are whole steps, each within `OFF` of a step
OFF = 0.02
FINE = 0.02  # of the scatter: rounding by a smaller step moves no quantile by a hundredth of it
PER_STEP, PER_SCATTER = 16, 40  # classes of samples: so many in a step, or in their scatter
OUTLIERS = 0.003  # share of samples that the likelihood leaves to anything but noise
SMALLEST = 1 / 12  # of a step: a smaller scatter adds nothing to the error of rounding
ZOOMS, TRIED = 4, 13  # of the search for the greatest likelihood: rounds, and values of a parameter in each
ALIKE = 0.5  # less than this in the logarithm of the likelihood tells no scatter from another


def lattice_step(recorded: Floats) -> float:
    """Step of the converter, in the unit of the signal; 0 where values lie on no lattice.

    It is 0, too, where it is so fine that most samples have a value of their own.

    Parameters
    ----------
    recorded : ndarray, shape (n_time,)
        As recorded; NaN where there is no sample.
    """
    known = recorded[np.isfinite(recorded)]
    some = known[:: max(1, known.size // STEP_SAMPLES)]
    values = np.unique(some)
    if values.size < 2 or values.size > some.size / 2:
        return 0.0
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * np.abs(values).max()]  # the last digits of a float
    if not gaps.size:
        return 0.0
    near = gaps[gaps < 1.5 * np.quantile(gaps, CLOSE)]
    counts = gaps / np.median(near)
    whole = np.rint(counts)
    few = whole < OFF / 1e-3  # of many steps the error of one adds up
    on = np.abs(counts - whole) < OFF
    if not (few.any() and np.mean(on[few]) >= ON_LATTICE):
        return 0.0
    return float(np.mean(gaps[few] / whole[few])) if (whole[few] > 0).all() else 0.0


def scatter(x: Floats | Sequence[Floats], step: float = 0.0) -> float:
    """Standard deviation of one sample's error, robust against outliers; NaN samples are left out.

    Where the converter's step is fine it is the median absolute deviation, scaled for a normal one.
    Else it is sqrt(σ² + step²/12), with σ of the noise before rounding: that of greatest likelihood of a
    normal variable of which each sample says only to what step it rounds (Heitjan 1989,
    doi:10.1214/ss/1177012601). Of what the samples can't tell apart the middle is taken: where only one value
    is seen, about a seventh of a step.

    Parameters
    ----------
    x : ndarray, shape (n_time,), or sequence of such
        A still signal; or several, each about a level of its own. Values need not lie on one lattice: those
        of a rest whose hum was removed do not.
    step : float
        Of the converter, in the same unit.
    """
    known = [each[np.isfinite(each)] for each in ([x] if isinstance(x, np.ndarray) else x)]
    about = [each - np.median(each) for each in known if each.size]
    if not about:
        return math.nan
    together = about[0] if len(about) == 1 else np.concatenate(about)
    robust = 1.4826 * float(np.median(np.abs(together)))
    if step <= FINE * robust or not step:
        return robust or float(np.std(together))
    return math.hypot(_before_rounding(about, robust + step, step), step / math.sqrt(12))


def _before_rounding(about: Sequence[Floats], wide: float, step: float) -> float:
    """Scatter of a normal variable before it is rounded by a step; `wide` is a scale it does not exceed."""
    size = max(step / PER_STEP, wide / PER_SCATTER)
    counted = [np.unique(np.rint(each / size), return_counts=True) for each in about]
    least, most = math.log(SMALLEST * step), math.log(2 * wide)
    levels, reach = np.zeros(len(counted)), step / 2 + wide / 4
    log_sigma, half = (least + most) / 2, (most - least) / 2
    for _ in range(ZOOMS):
        near = levels[:, None] + np.linspace(-reach, reach, TRIED)
        tried = np.clip(log_sigma + np.linspace(-half, half, TRIED), least, most)
        likely = np.array(
            [
                _likelihood(kinds * size, number, own, np.exp(tried), step, wide)
                for (kinds, number), own in zip(counted, near, strict=True)
            ]
        )
        of_sigma = likely.max(axis=1).sum(axis=0)
        alike = np.flatnonzero(of_sigma > of_sigma.max() - ALIKE)
        log_sigma = float(tried[alike].mean())
        levels = near[np.arange(len(near)), likely[:, :, alike[alike.size // 2]].argmax(axis=1)]
        reach, half = reach / 4, half / 4
    return math.exp(log_sigma)


def _likelihood(
    at: Floats, number: Indices, levels: Floats, sigmas: Floats, step: float, wide: float
) -> Floats:
    """Its logarithm for each level and scatter, of so many samples at some values."""
    from scipy.special import ndtr  # a tenth of a second, which pages of quality do without

    off, scale = at - levels[:, None, None], sigmas[:, None]
    chance = ndtr((off + step / 2) / scale) - ndtr((off - step / 2) / scale)
    anywhere = OUTLIERS * step / max(20 * wide, float(np.ptp(at)))
    return np.asarray(np.log((1 - OUTLIERS) * chance + anywhere) @ number)
