"""What the fits of a run say: its misfit, its pulls, how its impacts scatter."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, stdtr

from freerock.arrays import Floats
from freerock.identification.fitted import Fit
from freerock.identification.scatter import Told, find_scatter
from freerock.identification.significance_levels import PULLED, WARNS
from freerock.identification.start import crossings_s
from freerock.models.laws import MODEL_LABELS
from freerock.noise.spectrum import tapered_power
from freerock.rotation.laboratory import UNITS
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason
from freerock.selection.choice import CHOICE, Choice


@dataclass(frozen=True)
class ReasonLimits:
    """When something is said of the impacts and of a residual.

    Parameters
    ----------
    trend : float
        Chance of a trend of δ by amplitude or side, below which it is said: one clean run of a thousand.
    pulled : float
        Pull of an input that warns where a law leaves more than the noise, and pulls the inputs as well: with
        edges rounded by 1 mm it is 4.5, and k 6 % off.
    release : float
        Standard uncertainties of the measured release, from which a fit has another one. By hand, with laws
        that are not true, up to 7; a hold beyond the range of the sensor gave 26.
    line : float
        Times the median power of its neighbours, from which a residual holds a line.
    neighbours : int
        Frequencies to either side.
    """

    trend: float = 1e-3
    pulled: float = 4.0
    release: float = 10.0
    line: float = 50.0
    neighbours: int = 15


REASONS = ReasonLimits()
FEWEST_IMPACTS = 6  # of which a trend can be told
LEAST_SCATTER = 1e-4  # of impacts beside a trend: the models of contact are no better


def reasons_of_fit(motion: Motion, fit: Fit | None, choice: Choice) -> Iterator[Reason]:
    """What is said of a run, of the fit by the law that its record needs.

    Parameters
    ----------
    motion : Motion
    fit : Fit or None
        By the selected candidate; None where no fit is to be used.
    choice : Choice
    """
    if motion.noise is None:
        yield Reason.of("no_rest", "no rest or hold shows the noise of the sensor: white noise is assumed")
    if fit is None:
        return
    label, evidence = MODEL_LABELS[fit.model], fit.evidence
    if not evidence.agrees:
        left = f"{label} leaves {evidence.residual_over_noise:.3g} times the noise within swings"
        band = f"most between {evidence.noise_low_hz:.2g} and {evidence.noise_high_hz:.2g} Hz"
        name = "unexplained" if choice.level == "rejected" else "model_error"
        yield Reason.of(name, f"{left}, {band}; u holds it")
        line = line_hz(fit)
        if line:
            yield Reason.of("line_in_residual", f"a line of {line:.3g} Hz in the residual")
    yield from _of_nuisances(fit)
    yield from _of_impacts(motion, fit)


def _of_nuisances(fit: Fit) -> Iterator[Reason]:
    """Inputs that are pulled, and a release elsewhere than the hold and the first motion put it."""
    known = fit.uncertainty.contributions
    for source, by, pull in zip(known.inputs, known.moved, known.pulls, strict=True):
        if abs(pull) > PULLED:
            off = f"{by * source.u:+.3g} {UNITS[source.name]}".removesuffix(" 1")
            text = f"{source.label} off by {off}, pull {abs(pull):.1f}"
            # where the law leaves more than the noise, it pulls the inputs as well
            unlikely = 2 * len(known.pulls) * float(ndtr(-abs(pull))) < WARNS
            warns = (unlikely and fit.evidence.agrees) or abs(pull) > REASONS.pulled
            yield Reason.of("pulled_input", text, "warn" if warns else "ok", float(abs(pull)), PULLED, "1")

    for name, measured, u in fit.posterior.posed.release if fit.posterior else ():
        pull = abs(fit.values[name] - measured) / u
        if pull > REASONS.release:
            text = f"the fit puts {name} at {fit.values[name]:.3g}, {pull:.0f} u from where it was measured"
            yield Reason.of("pulled_release", text, None, pull, REASONS.release, "1")


def _of_impacts(motion: Motion, fit: Fit) -> Iterator[Reason]:
    scatter = fit.scatter.of_record
    if not scatter.sigma_r or fit.posterior is None:
        return
    if scatter.low > CHOICE.scatters:
        text = f"impacts scatter by {100 * scatter.low:.2g} to {100 * scatter.high:.2g} %"
        yield Reason.of("large_scatter", text, None, scatter.low, CHOICE.scatters, "1")
    amplitude, side = of_swings(motion, len(fit.scatter.delta))
    tests = (
        ("loss_by_amplitude", amplitude, "the loss depends on amplitude otherwise: δ {:+.2g} %"),
        ("loss_by_side", side, "the loss differs by side: δ {:+.2g} % between the right and the left"),
    )
    for name, regressor, text in tests:
        slope, p = trend(fit, regressor)
        if p < REASONS.trend:
            told = f"{text.format(100 * slope * float(np.ptp(regressor)))} (chance {p:.1g})"
            yield Reason.of(name, told, None, p, REASONS.trend, "1")


def of_swings(motion: Motion, n_impacts: int) -> tuple[Floats, Floats]:
    """Of the swing before each impact its largest |θ| [rad] and its side, shape (n_impacts,)."""
    known = np.isfinite(motion.theta)
    time_s, theta = motion.time_s[known], motion.theta[known]
    ends = np.searchsorted(time_s, crossings_s(motion)[:n_impacts])
    parts = np.split(theta, ends)[:n_impacts]
    tops = np.array([part[np.argmax(np.abs(part))] if len(part) else 0.0 for part in parts])
    tops = np.append(tops, np.zeros(n_impacts - len(tops)))
    return np.abs(tops), np.sign(tops)


def trend(fit: Fit, regressor: Floats) -> tuple[float, float]:
    """Slope of δ over a number of each impact, and its chance; 0 and 1 where there is none to tell.

    δ_i = slope · x_i + ε_i beside what the samples tell of δ. The scatter of ε is that which is left beside
    the slope, so that a slope does not hide in σ_r.
    """
    posterior = fit.posterior
    x = regressor - regressor.mean()
    if posterior is None or len(x) < FEWEST_IMPACTS or not x.any():
        return 0.0, 1.0
    told, sigma_r = posterior.told, fit.scatter.of_record.sigma_r
    slope = u = 0.0
    for _ in range(3):
        # generalised least squares beside a scatter
        of_x, with_prior = told.precision @ x, told.precision + np.eye(len(x)) / sigma_r**2
        by_x, by_towards = np.linalg.solve(with_prior, np.column_stack([of_x, told.towards])).T
        information = float(x @ of_x - of_x @ by_x)
        if information <= 0:
            return 0.0, 1.0
        slope, u = float(x @ told.towards - of_x @ by_towards) / information, information**-0.5
        beside = find_scatter([Told(told.precision, told.towards - told.precision @ x * slope)])
        sigma_r = max(beside.sigma_r, LEAST_SCATTER)
    return slope, 2 * float(stdtr(len(x) - 3, -abs(slope) / u))


def line_hz(fit: Fit) -> float:
    """Frequency of a line in the residual of a fit [Hz]; 0 without one."""
    posterior = fit.posterior
    if posterior is None:
        return 0.0
    frequency, power = tapered_power(posterior.residual)
    n = REASONS.neighbours
    if len(power) < 4 * n:
        return 0.0
    windows = np.lib.stride_tricks.sliding_window_view(power, 2 * n + 1)
    over = power[n:-n] / np.median(windows, axis=1)
    best = int(np.argmax(over))
    return float(frequency[n + best] * posterior.noise.rate_hz) if over[best] > REASONS.line else 0.0
