"""θ(t) of a record -> its free-rocking runs: held, released, rocking to rest; with their impacts.

Where the block stands still comes from `noise.still_phases`, the beginning from `beginning`, the end of the
motion from `signal`, the verdict from `reasons_as_measured`. Corrections by hand (`hand_corrections`)
replace or add runs.
"""

import math
from bisect import bisect, bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats
from freerock.config.processing import IMPACT_LIMITS, RUN_LIMITS, ImpactLimits, RunLimits
from freerock.models.block import Block
from freerock.noise.rotation_noise import AtRest, at_rest
from freerock.noise.signal_noise import scatter
from freerock.noise.spectrum import Noise, stderr_of_mean
from freerock.noise.still_phases import Phase
from freerock.rotation.flags import SignalQuality, signal_quality
from freerock.runs.beginning import Beginning, begun_by_hand, find_holds, from_hold, no_release, unseen
from freerock.runs.hand_corrections import NOTHING_BY_HAND, ByHand, Planned
from freerock.runs.impacts import IMPACT_COLUMNS, Impacts, find_impacts
from freerock.runs.reasons_as_measured import Facts, reasons_of_impacts, verdict_on
from freerock.runs.signal import OUT_OF_NOISE, Signal, end_of_motion, signal_of
from freerock.runs.verdict import Reason, Verdict

if TYPE_CHECKING:
    import xarray as xr


UNKNOWN = SignalQuality()


@dataclass(frozen=True)
class Run:
    """One free-rocking run of a record.

    Parameters
    ----------
    number : int
        Counted from 1 in the order of time.
    hold_start_s : float
        Start of the held phase [s].
    release_s, release_stderr_s : float
        Instant at which a motion at rest at θ0 began that matches the data after the finger has left, and its
        standard error [s]. A finger that fades symmetrically began to do so half its fading time earlier.
    fit_start_s : float
        First instant that a fit uses, after the finger has left the block [s].
    end_s : float
        Rest: from here the motion is lost in the noise [s].
    theta0, theta0_stderr : float
        Release angle and its standard error, which includes creep of the hold and error of the zero [rad].
    sigma_theta : float
        Standard deviation of the noise of θ, from the rest that follows (else the hold) [rad].
    n_impacts : int
        Sign changes of θ that stand out of the noise.
    verdict : Verdict
        What speaks against the run, and what was set by hand.
    zero_stderr : float
        Standard error of the zero of θ during the run by the noise of the rests, which all its peaks share;
        without what a drift between them may do, which theta0_stderr has as well [rad].
    """

    number: int
    hold_start_s: float
    release_s: float
    release_stderr_s: float
    fit_start_s: float
    end_s: float
    theta0: float
    theta0_stderr: float
    sigma_theta: float
    n_impacts: int
    verdict: Verdict = field(default_factory=Verdict)
    zero_stderr: float = 0.0

    @property
    def excluded(self) -> bool:
        """Whether it was left out by hand."""
        return "excluded" in self.verdict.names


def find_runs(
    time_s: ArrayLike,
    theta: ArrayLike,
    sigma_theta: ArrayLike,
    flags: ArrayLike,
    block: Block | None = None,
    quality: SignalQuality = UNKNOWN,
    by_hand: ByHand = NOTHING_BY_HAND,
    limits: RunLimits = RUN_LIMITS,
    still: AtRest | None = None,
) -> list[Run]:
    """Find the runs of a record.

    Parameters
    ----------
    time_s : array_like, shape (n_time,)
        Evenly spaced time [s].
    theta : array_like, shape (n_time,)
        Rotation [rad], zero at rest; NaN where flagged.
    sigma_theta : float or array_like, shape (n_time,)
        Standard deviation of the white noise of θ [rad].
    flags : array_like of int, shape (n_time,)
        0 where a sample is valid.
    block : Block, optional
        Judges whether θ0 is below θ_cr.
    quality : SignalQuality, optional
        Error of the zero of θ, step of the converter, and faults of the signal, which count against the runs
        that they meet; see `flags.signal_quality`.
    by_hand : ByHand, optional
        Runs set or left out by hand.
    limits : RunLimits, optional
    still : AtRest, optional
        What the record shows while it stands still, where it is known.

    Returns
    -------
    list of Run

    Raises
    ------
    FreerockError
        No release found, and none set by hand.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    >>> volts = freerock.read_record("raw/palermo_virtual/config2_marble.tdms")["laser"]
    >>> data = freerock.find_rotation(volts["time"], volts, laser, block, volts.units)
    >>> signal = (data[name] for name in ("time", "theta", "sigma_theta", "flags"))
    >>> [round(run.release_s, 2) for run in freerock.find_runs(*signal, block)]
    [5.83, 19.53, 34.48]
    """
    signal = signal_of(time_s, theta, sigma_theta, flags, quality.converter_step)
    own = still or at_rest(signal.t, signal.theta, signal.sigma, signal.converter_step, limits.window_s)
    signal = signal._replace(relative_noise=own.relative or signal.relative_noise)
    rests = [each for each in own.phases if each.kind == "rest"]
    search = _Search(signal, own.phases, rests, block, quality, limits)
    holds = find_holds(signal, own.phases, limits.window_s)
    found = search.with_unseen([search.found(hold) for hold in holds])
    record_end_s = float(signal.t[-1])
    planned = by_hand.merged([(run.begins.release.instant_s, run.end_s) for run in found], record_end_s)
    if not planned:
        raise no_release(own.phases, block, signal)
    reasons = by_hand.reasons_of_corrections(planned, record_end_s)
    return [
        search.run(number, search.set_by_hand(each, found), own)
        for number, (each, own) in enumerate(zip(planned, reasons, strict=True), 1)
    ]


class _Motion(NamedTuple):
    """A run before it is judged: times in s, the rest that follows, the noise of θ in rad."""

    begins: Beginning
    end_s: float
    rest: Phase | None
    sigma_theta: float


@dataclass(frozen=True)
class _Search:
    """What the runs of a record have in common."""

    signal: Signal
    phases: Sequence[Phase]
    rests: Sequence[Phase]
    block: Block | None
    quality: SignalQuality
    limits: RunLimits

    def found(self, hold: Phase) -> _Motion:
        """The run that begins with a hold."""
        signal, limits = self.signal, self.limits
        later = bisect(self.phases, hold.mid_s, key=lambda each: each.start_s)
        rest = next((each for each in self.phases[later : later + 2] if each is not hold), None)
        still = (rest or hold).core(signal.t, limits.window_s)
        end_s = float(signal.t[-1])
        if rest:
            end_s = end_of_motion(signal, still, hold.end_s, rest.start_s + limits.window_s)
        begins = from_hold(signal, hold, end_s, limits)
        return _Motion(begins, end_s, rest, signal.noise(still))

    def with_unseen(self, found: Sequence[_Motion]) -> list[_Motion]:
        """The runs found, and those whose hold the sensor did not see, in the order of time."""
        signal, limits = self.signal, self.limits
        again = [*(run.begins.hold_start_s for run in found[1:]), math.inf]
        # from a hold the block may only come to the next
        all_runs = [
            run for run, held_s in zip(found, again, strict=False) if run.begins.release.instant_s < held_s
        ]
        in_order = sorted(found, key=lambda run: run.begins.hold_start_s)
        starts_s = [run.begins.hold_start_s for run in in_order]
        latest_s = [-math.inf, *accumulate((run.end_s for run in in_order), max)]
        for before, rest in pairwise(self.phases):
            apart = latest_s[bisect_left(starts_s, rest.start_s)] <= before.end_s
            if rest.kind != "rest" or before.kind == "held" or not apart:
                continue
            still = rest.core(signal.t, limits.window_s)
            end_s = end_of_motion(signal, still, before.end_s, rest.start_s + limits.window_s)
            if begins := unseen(signal, (before.end_s, end_s), limits):
                all_runs.append(_Motion(begins, end_s, rest, signal.noise(still)))
        return sorted(all_runs, key=lambda run: run.begins.release.instant_s)

    def set_by_hand(self, planned: Planned, found: Sequence[_Motion]) -> _Motion:
        """A run as a person wants it; as it was found where nobody does."""
        its = found[planned.found] if planned.found is not None else None
        override, signal, limits = planned.override, self.signal, self.limits
        if override is None:
            assert its is not None
            return its
        begins = begun_by_hand(signal, override, its.begins if its else None, planned.end_s, limits)
        follow = [each for each in self.phases if each.start_s > override.release_s]
        rest = follow[0] if follow else None
        if rest and rest.start_s > planned.end_s + (limits.window_s if rest.kind == "rest" else 0.0):
            rest = None
        sigma = its.sigma_theta if its else self._noise_near(planned.end_s)
        return _Motion(begins, planned.end_s, rest, sigma)

    def _noise_near(self, time_s: float) -> float:
        """Standard deviation of the noise of θ [rad], from the rest nearest to an instant [s]."""
        if not self.rests:
            return float(np.nanmedian(self.signal.sigma))
        nearest = min(self.rests, key=lambda each: abs(each.mid_s - time_s))
        return self.signal.noise(nearest.core(self.signal.t, self.limits.window_s))

    def run(self, number: int, motion: _Motion, by_hand: Sequence[Reason]) -> Run:
        """A run with its verdict; `by_hand` says what was set by hand."""
        signal, begins, end_s = self.signal, motion.begins, motion.end_s
        zero_stderr = self._zero_stderr(begins.hold_start_s)
        free = signal.theta[signal.during(begins.release.instant_s + self.limits.finger_s, end_s)]
        side = np.sign(free[np.abs(free) > OUT_OF_NOISE * motion.sigma_theta])
        later = bisect(self.rests, begins.hold_start_s, key=lambda each: each.end_s)
        facts = Facts(
            signal=signal,
            faults=self.quality.faults,
            block=self.block,
            limits=self.limits,
            beginning=begins,
            rest=motion.rest,
            level_before=self.rests[later - 1].level if later else None,
            end_s=end_s,
            sigma_theta=motion.sigma_theta,
            n_impacts=int(np.count_nonzero(np.diff(side))),
            by_hand=by_hand,
        )
        return Run(
            number=number,
            hold_start_s=begins.hold_start_s,
            release_s=float(begins.release.instant_s),
            release_stderr_s=float(begins.release.stderr_s),
            fit_start_s=float(begins.fit_start_s),
            end_s=float(end_s),
            theta0=begins.held.theta0,
            theta0_stderr=math.hypot(begins.held.stderr, max(zero_stderr, self.quality.zero_stderr)),
            sigma_theta=motion.sigma_theta,
            n_impacts=facts.n_impacts,
            verdict=verdict_on(facts),
            zero_stderr=zero_stderr,
        )

    def _zero_stderr(self, time_s: float) -> float:
        """Standard error of the zero of θ [rad] at an instant [s], by the noise of the rests beside it."""
        signal, later = self.signal, bisect(self.rests, time_s, key=lambda each: each.mid_s)
        near = self.rests[max(later - 1, 0) : later + 1]
        if not near:
            return self.quality.zero_stderr
        share, noise = 1.0, signal.relative_noise
        if len(near) == 2:
            share = (near[1].mid_s - time_s) / (near[1].mid_s - near[0].mid_s)
        usual = float(np.nanmedian(signal.sigma[near[0].core(signal.t, self.limits.window_s)]))
        variance = noise.stuck * usual**2  # one place between two steps, in all rests
        for each, weight in zip(near, (share, 1 - share), strict=False):
            part = each.core(signal.t, self.limits.window_s)
            n = (part.stop - part.start) // noise.averaged
            apart = abs(each.mid_s - time_s) * noise.rate_hz
            level = stderr_of_mean(noise, n) ** 2
            wander = noise.wander(apart, noise.rate_hz * self.limits.held_s)
            own = weight**2 * level + weight * wander
            variance += own * float(np.nanmedian(signal.sigma[part])) ** 2
        return math.sqrt(variance)


TILTS = "alternating_restitution"
PEAK_S = 0.02  # about as long as the top of a swing on which its height rests
AFTER_S, FEWEST = 0.4, 10  # of a rest in which their scatter is seen, and means that show it


class Measured(NamedTuple):
    """What θ(t) of a record shows: its runs, the impacts of each, and the noise at rest [rad] if seen."""

    runs: tuple[Run, ...]
    impacts: tuple[Impacts, ...]
    noise: Noise | None


def measured(
    record: "xr.Dataset",
    block: Block,
    by_hand: ByHand = NOTHING_BY_HAND,
    of_runs: RunLimits = RUN_LIMITS,
    of_impacts: ImpactLimits = IMPACT_LIMITS,
) -> Measured:
    """The runs of a record with their impacts, and the noise at rest: the same for workflow and Python.

    `record` is as `freerock.find_rotation` gives it; all else, and the errors, as in `find_runs` and
    `impacts.find_impacts`.
    """
    time_s, theta, sigma, flags = (record[name].values for name in ("time", "theta", "sigma_theta", "flags"))
    quality = signal_quality(record)
    still = at_rest(time_s, theta, sigma, quality.converter_step, of_runs.window_s)
    find = partial(find_impacts, block=block, limits=of_impacts, noise=still.relative)
    judged, all_impacts = list[Run](), list[Impacts]()
    runs = find_runs(time_s, theta, sigma, flags, block, quality, by_hand, of_runs, still)
    notes = by_hand.reasons_of_stretches([(run.hold_start_s, run.end_s) for run in runs])
    for run, own in zip(runs, notes, strict=True):
        impacts = _impacts_of(run, by_hand.stretches, (time_s, theta, sigma), find)
        # A peak is known as well as means at rest after the run. Rounded samples have rounded means.
        peak_stderr = quality.converter_step / math.sqrt(12) * (quality.converter_step > run.sigma_theta)
        after = theta[slice(*np.searchsorted(time_s, (run.end_s, run.end_s + AFTER_S)))]
        size = max(1, round(PEAK_S / (time_s[1] - time_s[0])))
        means = after[: after.size // size * size].reshape(-1, size).mean(axis=1)
        means = means[np.isfinite(means)]
        if means.size >= FEWEST:
            peak_stderr = max(peak_stderr, scatter(means))
        found = reasons_of_impacts(impacts, block, of_impacts, peak_stderr)
        verdict = _as_of_a_tilt(run.verdict) if any(each.name == TILTS for each in found) else run.verdict
        judged.append(replace(run, verdict=Verdict((*verdict.reasons, *found, *own))))
        all_impacts.append(impacts)
    return Measured(tuple(judged), on_one_bed(all_impacts), still.noise)


def on_one_bed(impacts: Sequence[Impacts]) -> tuple[Impacts, ...]:
    """Impacts of the runs of a record: where a tail does not show the bed, it is that of the other runs."""
    seen = [each.theta_uplift for each in impacts if each.theta_uplift > 0]
    usual = float(np.median(seen)) if seen else 0.0
    return tuple(replace(each, theta_uplift=each.theta_uplift or usual) for each in impacts)


def _impacts_of(
    run: Run,
    stretches: Sequence[tuple[float, float, str]],
    samples: tuple[Floats, Floats, Floats],
    find: Callable[..., Impacts],
) -> Impacts:
    """The impacts of a run, with one of NaN in place of those that a stretch left out hides.

    No peak and no restitution spans what is hidden: `find_impacts` looks at time, θ and its noise of each
    part.
    """
    hidden = sorted(each[:2] for each in stretches if each[1] > run.release_s and each[0] < run.end_s)
    begins = np.maximum.accumulate([run.release_s, *(to_s for _, to_s in hidden)]).tolist()
    ends = [*(from_s for from_s, _ in hidden), run.end_s]
    parts = list[Impacts]()
    for i, (from_s, to_s) in enumerate(zip(begins, ends, strict=True)):
        if i and from_s >= to_s:
            continue
        first = np.searchsorted(samples[0], from_s)
        last = np.searchsorted(samples[0], max(from_s, to_s), "right")
        part = (each[first:last] for each in samples)
        theta0 = None if i else run.theta0
        errors = {"theta0_stderr": run.theta0_stderr, "zero_stderr": run.zero_stderr}
        parts.append(find(*part, theta0=theta0, **errors))
    known = [each for i, each in enumerate(parts) if i == 0 or each.time_s.size]
    columns = {
        name: np.concatenate([value for each in known for value in ([np.nan], getattr(each, name))][1:])
        for name in IMPACT_COLUMNS
    }
    return Impacts(**columns, theta_uplift=max(each.theta_uplift for each in known))


def _as_of_a_tilt(verdict: Verdict) -> Verdict:
    """On a base off level swings to its side are higher than those before: the fits may tell."""
    return Verdict(
        tuple(each._replace(verdict="warn") if each.name == "touched" else each for each in verdict.reasons)
    )
