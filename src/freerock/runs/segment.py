"""θ(t) of a record -> its free-rocking runs: held, released, rocking to rest.

No time is set by hand. Where the block stands still comes from `phases`; the instant of release is the start
of a motion from rest that matches the data after the finger has left, so it does not hang on how it left.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import leastsq

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.faults import FAULT_VERDICTS, Fault
from freerock.rotation.flags import FLAGS
from freerock.rotation.still import stationary_phases
from freerock.runs.verdict import Level, Reason, Verdict

FALL, FALL_MOST = 0.25, 0.8  # of θ0: the early motion is fitted until the block has fallen by this
UNSTEADY = 3e-3  # of the range of θ: an angle that wanders no more than this is still held
SMOOTH_S = 0.005  # averaging time in which the last of the motion is told from noise
OUT_OF_NOISE = 5.0  # standard deviations
SURE = 4.0  # standard errors
SWING = 10.0  # standard deviations a swing rises above zero
SLOWER = 1.1  # by this factor may a swing last longer than the one before: soft bases even swings out
SQUAT = math.radians(
    30
)  # from this critical angle on a block may bounce, and swing higher or longer by itself
EARLY_SAMPLES = 300  # of the early motion suffice
NOISE_SAMPLES = 50_000  # suffice to know the noise
BLOCK_S, MIN_BLOCKS = 0.025, 4  # means over this long are taken as independent; fewer are no hold


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
        Held angle and its standard error, which includes creep of the hold and error of the zero [rad].
    sigma_theta : float
        Standard deviation of the noise of θ, from the rest that follows (else the hold) [rad].
    n_impacts : int
        Sign changes of θ that stand out of the noise.
    verdict : Verdict
        What speaks against the run, and what was set by hand.
    excluded, overridden : bool
        Left out by hand; release and end set by hand.
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
    excluded: bool = False
    overridden: bool = False


def find_runs(
    time_s,
    theta,
    sigma_theta,
    flags,
    block: Block | None = None,
    zero_stderr: float = 0.0,
    faults: Sequence[Fault] = (),
    *,
    overrides: Sequence[tuple[int, float, float, str]] = (),
    exclusions: Sequence[tuple[int, str]] = (),
    window_s: float = 0.25,
    held_s: float = 1.0,
    finger_s: float = 0.03,
    min_impacts: int = 3,
    max_flagged_fraction: float = 0.02,
    max_push_fraction: float = 0.02,
    max_hold_drift_deg: float = 0.05,
    max_rest_shift_deg: float = 0.05,
    max_growth_fraction: float = 0.05,
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
    zero_stderr : float
        Standard error of the zero of θ [rad].
    faults : sequence of Fault
        What is wrong with the signal, and when: counts against the runs that it meets.
    overrides : sequence of (run, release_s, end_s, reason)
        Release and end of a run, set by hand.
    exclusions : sequence of (run, reason)
        Runs left out by hand: kept in the list and marked.
    window_s : float
        Window of `phases.stationary_phases` [s].
    held_s : float
        θ0 is read over this long before the release [s].
    finger_s : float
        Time the finger takes to leave [s]: no sample is used from as long before the release to as long
        after it. Also the standard error of a release set by hand.
    min_impacts : int
        Fewer impacts are a fail.
    max_flagged_fraction : float
        A larger share of invalid samples from the end of the hold to rest is a fail, a smaller one a warning.
    max_push_fraction : float
        Warning when the motion is that from an angle which differs from θ0 by more than this share, because
        the block was pushed or held back.
    max_hold_drift_deg : float
        Warning when the held angle moves by more than this over `held_s` [degree].
    max_rest_shift_deg : float
        Warning when the rest positions before and after differ by more than this [degree].
    max_growth_fraction : float
        A swing higher than the one before by a larger share, or one that lasts clearly longer, is not free:
        the block was touched, a fail.

    Returns
    -------
    list of Run

    Raises
    ------
    FreerockError
        No release found, a run overridden or excluded that is not there, or overridden beyond the record.
    """
    t, theta = np.asarray(time_s, float), np.asarray(theta, float)
    theta = np.where(np.asarray(flags) == 0, theta, np.nan)
    sigma = np.broadcast_to(np.asarray(sigma_theta, float), theta.shape)
    phases = stationary_phases(t, theta, window_s=window_s)
    holds = _holds(phases, stationary_phases(t, theta, window_s=window_s, floor_fraction=UNSTEADY))
    if not holds:
        raise _no_release(phases, block, flags, faults)
    _refuse_unknown("override", [number for number, *_ in overrides], len(holds))
    _refuse_unknown("exclude", [number for number, _ in exclusions], len(holds))
    by_hand = {number: (release, end, reason) for number, release, end, reason in overrides}
    left_out = dict(exclusions)

    runs = []
    for number, hold in enumerate(holds, 1):
        rest = next((phase for phase in phases if phase.start_s > hold.mid_s and phase is not hold), None)
        still = slice(*np.searchsorted(t, _core(rest or hold, window_s)))
        sigma_run = _scatter(theta[still])
        reasons = []
        if number in by_hand:
            release, end, why = by_hand[number]
            if not hold.start_s + finger_s + MIN_BLOCKS * BLOCK_S < release < end:
                raise FreerockError(
                    "override",
                    f"run {number}, held from {hold.start_s:.2f} s, is released at {release:g} s",
                    f"give a release at least {finger_s + MIN_BLOCKS * BLOCK_S:.2f} s later, then the end",
                )
            if end > t[-1]:
                raise FreerockError(
                    "override",
                    f"run {number} ends at {end:g} s, the record at {t[-1]:.3f} s",
                    "give an end within the record",
                )
            release_stderr, watched = finger_s, release + finger_s
            reasons.append(Reason("ok", "overridden", f"overridden: {why}"))
        else:
            end = _end_of_motion(t, theta, still, hold.end_s, rest.start_s + window_s) if rest else t[-1]
            release, release_stderr, push = _release(t, theta, sigma, hold, end, held_s, finger_s)
            watched = min(hold.end_s, release)
            if math.isnan(release_stderr):
                release_stderr = finger_s
                what = "the release can't be timed from the early motion"
                reasons.append(Reason("warn", "release_not_timed", what))
            if abs(push) > max_push_fraction:
                how = "pushed" if push > 0 else "held back"
                what = f"{how}: it moves as if released from an angle {push:+.1%} off θ0"
                reasons.append(Reason("warn", how.replace(" ", "_"), what))
        theta0, theta0_stderr, wander = _held_angle(t, theta, sigma, hold, release, held_s, finger_s)
        start = release + finger_s
        during = theta[slice(*np.searchsorted(t, (start, end)))]
        side = np.sign(during[np.abs(during) > OUT_OF_NOISE * sigma_run])
        n_impacts = int(np.count_nonzero(np.diff(side)))

        if block is not None and abs(theta0) >= block.theta_cr:
            angles = f"θ0 = {math.degrees(theta0):.2f}° is beyond θ_cr = {math.degrees(block.theta_cr):.2f}°"
            reasons.append(Reason("fail", "beyond_critical_angle", angles))
        if n_impacts < min_impacts:
            what = f"{n_impacts} impacts, fewer than {min_impacts}"
            reasons.append(Reason("fail", "few_impacts", what))
        watch = theta[slice(*np.searchsorted(t, (watched, end)))]
        flagged = float(np.mean(np.isnan(watch))) if watch.size else 1.0
        if flagged > 0:
            level: Level = "fail" if flagged > max_flagged_fraction else "warn"
            names = _names(np.asarray(flags)[slice(*np.searchsorted(t, (watched, end)))])
            what = f"{flagged:.2%} of its samples are invalid{names}"
            reasons.append(Reason(level, "invalid_samples", what))
        touched = _touched(t, theta, (start, end), theta0, sigma_run, max_growth_fraction)
        if touched and block is not None and block.theta_cr > SQUAT:
            what = f"swing {touched} than before: the block was touched, or it bounces"
            reasons.append(Reason("warn", "touched", what))
        elif touched:
            what = f"swing {touched} than before: the block was touched"
            reasons.append(Reason("fail", "touched", what))
        if math.degrees(wander) > max_hold_drift_deg:
            what = f"the held angle wanders by {math.degrees(wander):.3f}°"
            reasons.append(Reason("warn", "hold_wanders", what))
        if rest is None:
            reasons.append(Reason("warn", "cut_short", "the record ends before the block is at rest"))
        elif rest.kind != "rest":
            over = block is not None and abs(rest.level) >= block.theta_cr
            name, how = ("overturned", "it overturns and lies") if over else ("stopped", "it stops")
            what = f"{how} at {math.degrees(rest.level):.2f}° instead of at rest"
            reasons.append(Reason("fail", name, what))
        else:
            before = [p.level for p in phases if p.kind == "rest" and p.end_s <= hold.start_s]
            shift = math.degrees(rest.level - before[-1]) if before else 0.0
            if abs(shift) > max_rest_shift_deg:
                what = f"the rest position has moved by {shift:+.3f}°"
                reasons.append(Reason("warn", "rest_shift", what))
        for fault in faults:
            if fault.start_s < end and fault.end_s > hold.start_s:
                reasons += _charge(fault, max_rest_shift_deg)
        if number in left_out:
            reasons.append(Reason("ok", "excluded", f"excluded: {left_out[number]}"))
        runs.append(
            Run(
                number=number,
                hold_start_s=hold.start_s,
                release_s=float(release),
                release_stderr_s=float(release_stderr),
                fit_start_s=float(start),
                end_s=float(end),
                theta0=theta0,
                theta0_stderr=math.hypot(theta0_stderr, zero_stderr),
                sigma_theta=sigma_run,
                n_impacts=n_impacts,
                verdict=Verdict(tuple(reasons)),
                excluded=number in left_out,
                overridden=number in by_hand,
            )
        )
    return runs


def _holds(steady, loose):
    """Phases that end with a release: the steady ones, and those too unsteady to be among them."""
    holds = []
    for phase in [*steady, *loose]:
        apart = all(phase.end_s < hold.start_s or phase.start_s > hold.end_s for hold in holds)
        if phase.kind == "held" and phase.level and apart:
            holds.append(phase)
    return sorted(holds, key=lambda hold: hold.start_s)


def _names(flags):
    """The flags of some samples, in brackets."""
    names = [name.replace("_", " ") for name, mask in FLAGS.items() if (flags & mask).any()]
    return f" ({', '.join(names)})" if names else ""


def _charge(fault, max_rest_shift_deg):
    """What a fault says against a run that it meets."""
    angle = math.degrees(fault.angle)
    if fault.name in FAULT_VERDICTS:
        text = f"{fault.name.replace('_', ' ')}: {fault.note}"
        yield Reason(FAULT_VERDICTS[fault.name], fault.name, text)
    elif fault.name == "rest_shift" and abs(angle) > max_rest_shift_deg:
        text = f"the rest position has moved by {angle:+.3f}°: the block may have slid or twisted"
        yield Reason("warn", "rest_shift", text)
    elif fault.name == "drift" and abs(angle) > max_rest_shift_deg:
        yield Reason("warn", "drift", f"the zero drifts by {angle:+.3f}°")


def _touched(t, theta, span, theta0, sigma, max_growth_fraction):
    """Which swing is not free, and why, "" if none: swings of a free block get lower and shorter."""
    first, last = np.searchsorted(t, span)
    index = first + np.flatnonzero(np.abs(theta[first:last]) > SWING * sigma)
    if index.size == 0:
        return ""
    begins = np.flatnonzero(np.diff(theta[index] > 0)) + 1
    starts, ends = index[np.concatenate(([0], begins))], index[np.concatenate((begins - 1, [-1]))]
    passages = (t[ends[:-1]] + t[starts[1:]]) / 2
    height, longest = abs(theta0), (math.inf, math.inf)  # a moved zero makes one side's swings longer
    for number, (i, j) in enumerate(zip(starts[1:-1], ends[1:-1], strict=True), 1):
        top = float(np.nanmax(np.abs(theta[i : j + 1])))
        time = float(passages[number] - passages[number - 1])
        told = ""
        if top > (1 + max_growth_fraction) * height + 2 * SWING * sigma:
            told = f"is {top / height - 1:.0%} higher"
        elif top > 3 * SWING * sigma and time > SLOWER * max(longest) + 2 * (t[1] - t[0]):
            told = f"lasts {time / max(longest) - 1:.0%} longer"
        if told:
            return f"{number} {told}"
        height, longest = top, (longest[1], time)
    return ""


def _no_release(phases, block, flags, faults):
    """The error of a record without a release, with what can be told of it."""
    remedy = "check that the channel, the sign and the laser are those of this record"
    if not phases:
        what, remedy = "no release found: the signal never stands still", "record a rest and a held phase"
    else:
        held = max((phase.level for phase in phases), key=abs)
        what = "no release found: nothing rocks freely to rest after being held"
        if block is not None and abs(held) >= block.theta_cr:
            what = (
                f"no release found: held at {math.degrees(held):.2f}°, beyond the block's critical angle "
                f"{math.degrees(block.theta_cr):.2f}°, it overturns"
            )
            remedy = "check the block's height and width and the laser's position"
    share = float(np.mean(np.asarray(flags) != 0))
    lost = next((fault.note for fault in faults if fault.name == "target_lost"), "")
    if lost:
        what += f", the target is lost {lost}"
    elif share > 0.02 and "overturns" not in what:
        what += f", {share:.0%} of the samples are invalid{_names(np.asarray(flags))}"
    return FreerockError("record", what, remedy)


def _refuse_unknown(key, numbers, n_runs):
    """Refuse to override or exclude runs that are not there."""
    unknown = sorted(set(numbers) - set(range(1, n_runs + 1)))
    if unknown:
        raise FreerockError(
            key,
            f"there is no run {', '.join(map(str, unknown))}",
            "name run 1, the only one" if n_runs == 1 else f"name one of runs 1 to {n_runs}",
        )


def _core(phase, window_s):
    """Start and end of a phase without its uncertain ends [s]."""
    trim = min(window_s / 2, (phase.end_s - phase.start_s) / 4)
    return phase.start_s + trim, phase.end_s - trim


def _scatter(x):
    """Standard deviation, robust against outliers; NaN samples are left out."""
    x = x[np.isfinite(x)]
    x = x[:: max(1, x.size // NOISE_SAMPLES)]
    return float(1.4826 * np.median(np.abs(x - np.median(x))) or np.std(x)) if x.size else math.nan


def _end_of_motion(t, theta, still, start, until):
    """Last instant at which θ, averaged over `SMOOTH_S`, stands out of what it is while still."""
    width = max(1, round(SMOOTH_S / (t[1] - t[0])))
    first, last = np.searchsorted(t, (start, until))
    origin = max(0, min(first, still.start) - width)
    part = theta[origin : max(last, still.stop) + width]
    valid = np.isfinite(part)
    sums, counts = (
        np.concatenate((np.zeros(width // 2 + 1), np.cumsum(each), np.full(width, each.sum())))
        for each in (np.where(valid, part, 0.0), valid)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (sums[width:] - sums[:-width]) / (counts[width:] - counts[:-width])
    rest = mean[still.start - origin : still.stop - origin]
    noise = max(_scatter(rest), np.finfo(float).eps)
    moving = np.abs(mean[first - origin : last - origin] - np.nanmedian(rest)) > OUT_OF_NOISE * noise
    return t[first + np.flatnonzero(moving).max(initial=0)]


def _held_angle(t, theta, sigma, hold, release, held_s, finger_s):
    """Held angle, its standard error and how far it wanders [rad], over the last part of the hold.

    Means over `BLOCK_S` that scatter clearly more than white noise lets them are taken as motion of the
    block, which may have been released from anywhere within it.
    """
    end = release - finger_s
    near = slice(*np.searchsorted(t, (max(hold.start_s, end - held_s), end)))
    held = theta[near][np.isfinite(theta[near])]
    size = max(1, round(BLOCK_S / (t[1] - t[0])))
    n = held.size // size
    if n < MIN_BLOCKS:
        return hold.level, hold.level_stderr, 0.0
    means = held[held.size - n * size :].reshape(n, size).mean(axis=1)
    variance, white = np.var(means, ddof=1), np.nanmean(sigma[near]) ** 2 / size
    stderr = math.sqrt(variance / n + (variance if variance > 3 * white else 0.0))
    return float(held.mean()), stderr, float(np.ptp(means))


def _release(t, theta, sigma, hold, end, held_s, finger_s):
    """Instant of release, its standard error [s], and the share of θ0 by which the motion began higher.

    The early motion is fitted twice: from the held angle, which gives the instant, and from any angle, which
    tells a push. The standard error is NaN where no fit succeeds.
    """
    first, last = np.searchsorted(t, (hold.mid_s, end))
    fallen = 1 - theta[first:last] / hold.level
    early, late, last = (t[first + int(np.argmax(fallen > share))] for share in (FALL / 4, FALL, FALL_MOST))
    release = guess = 2 * early - late  # a fall grows as time squared
    late = max(late, min(last, guess + 3 * finger_s))
    for _ in range(3):
        theta0, theta0_stderr, _ = _held_angle(t, theta, sigma, hold, release, held_s, finger_s)
        near = slice(*np.searchsorted(t, (release + finger_s, late)))
        motion = t[near], theta[near], sigma[near], release, theta0
        instant, instant_stderr, _, _ = _early_motion(*motion, theta0_stderr)
        if not abs(instant - guess) < max(finger_s, late - guess):
            return guess, math.nan, 0.0
        moved, release = abs(instant - release), instant
        if moved < 0.1 * instant_stderr:
            break
    _, _, top, top_stderr = _early_motion(*motion, math.inf)
    push = (top - theta0) / theta0
    return release, instant_stderr, push if abs(top - theta0) > SURE * top_stderr else 0.0


def _early_motion(t, theta, sigma, start, theta0, theta0_stderr):
    """Fit θ = θ_top - a/q² (cosh q(t - t0) - 1): t0, its standard error, θ_top, its standard error.

    That is any conservative motion from rest at θ_top to fourth order in t - t0; a and q stay free, so that
    neither a compliant base nor a width other than nominal matters. NaN where the fit fails.
    """
    valid = np.isfinite(theta) & np.isfinite(sigma)
    t, theta, noise = t[valid] - start, theta[valid], np.maximum(sigma[valid], 1e-6 * abs(theta0))
    if t.size < 6:
        return (math.nan,) * 4
    together = -(-t.size // EARLY_SAMPLES)  # samples in one mean: so short a time is straight
    n = t.size // together * together
    t, theta, noise = (x[:n].reshape(-1, together).mean(axis=1) for x in (t, theta, noise))
    noise = noise / math.sqrt(together)
    held = max(theta0_stderr, 1e-9 * abs(theta0))

    def residual(x):
        top, pull, q, t0 = x
        model = theta0 + top - pull / q**2 * (np.cosh(np.clip(q * (t - t0), -20, 20)) - 1)
        return np.append((model - theta) / noise, top / held)

    def slopes(x):
        _, pull, q, t0 = x
        angle = np.clip(q * (t - t0), -20, 20)
        fallen, rate = (np.cosh(angle) - 1) / q**2, np.sinh(angle) / q
        by = np.empty((t.size + 1, 4))
        by[:-1] = np.stack(
            [np.ones(t.size), -fallen, pull * (2 * fallen - rate * (t - t0)) / q, pull * rate]
        ).T
        by[:-1] /= noise[:, None]
        by[-1] = 1 / held, 0, 0, 0
        return by

    guess = (0.0, FALL * theta0 / 0.5 / t[-1] ** 2, 1 / t[-1], 0.0)
    x, *_ = leastsq(residual, guess, Dfun=slopes, full_output=True)
    scatter = max(1.0, float(np.sum(residual(x) ** 2)) / (t.size - len(guess)))
    by = slopes(x)
    stderr = np.sqrt(scatter * np.diag(np.linalg.pinv(by.T @ by)))
    return start + x[3], stderr[3], theta0 + x[0], stderr[0]
