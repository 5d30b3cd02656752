"""Reasons why a run is `warn` after its fits, with likely causes.

A block at a peak starts as one that is let go from rest there. What was done to it before leaves no trace but
the height of the peak, so a part of the run tells what the whole of it can't: whether the law is wrong, or
something else than the law acted on the block, and when.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from freerock.config.fit_settings import FitSettings
from freerock.identification.fit import Fit
from freerock.identification.start import from_top, tops_of
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, DEBONDING, MODEL_LABELS, MODELS, law_of
from freerock.rotation.beam import displaced, turned
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.allowed_hypotheses import Hypotheses, contains
from freerock.selection.hypotheses_tried import Identified
from freerock.selection.quick import leaves_noise
from freerock.selection.reasons_of_set_up import (
    explains_as_well,
    notes_on_scene,
    odd_contact,
    pulled_inputs,
    slow_sensor,
    unmodelled_effect,
)

UNEXPLAINED = "no candidate explains the run"
WOULD = "would fit with {}: {} then agrees with the noise"


def reasons_of_noise(motion: Motion) -> list[Reason]:
    """Of a run in whose record nothing rests long enough to show the noise, that its errors know less."""
    text = (
        "no rest or hold is long enough to show the noise of the sensor: the standard errors use the noise "
        "of the residual"
    )
    return [Reason("warn", "no_rest", text)] if motion.noise is None else []


def reasons_of_fits(
    measured: Verdict, block: Block, motion: Motion, found: Identified, hypotheses: Hypotheses
) -> list[Reason]:
    """Of a run that a candidate explains, what it found of base, release, inputs and further effects; else
    that none does, under which setting one would, or what acted on the block when, and the likeliest causes.

    Parameters
    ----------
    measured : Verdict
        On the run before it was fitted.
    block : Block
    motion : Motion
        The run.
    found : Identified
        Its fits.
    hypotheses : Hypotheses
        Those of the campaign.
    """
    if found.explained:
        choice = found.choice(hypotheses)
        chosen, possible = choice.selected, (choice.selected, *choice.also_possible)
        notes = notes_on_scene(found.fits[chosen], block, motion) if found.widened else []
        for other, fit in found.alternatives.items():
            notes += explains_as_well(other, fit, found.before or found.fits[chosen], possible, found.widened)
        notes += pulled_inputs(found.fits[chosen])
        notes += odd_contact(found.fits[chosen], block)
        notes += slow_sensor(found.at_best(chosen, block, motion, hypotheses), motion)
        notes += _smaller_law(found, chosen, block, motion, hypotheses)
        if chosen in found.effects and not any(note.verdict == "warn" for note in notes):
            notes.append(unmodelled_effect(found.fits[chosen], found.effects[chosen]))
        return notes
    if not found.fits:
        return []

    def settings(model: str) -> FitSettings:
        return hypotheses.settings(model, found.widened)

    nearest = found.fits.get(_nearest(found) or found.choice(hypotheses).selected)
    contact = list(odd_contact(nearest, block)) if nearest is not None else []
    hints = list(hints_for(block, motion, found.fits, settings))
    if hints:
        return [*hints, *contact, Reason("warn", "unexplained", UNEXPLAINED)]
    disturbance = None
    if "alternating_restitution" not in measured.names:  # its cause acts all through the run
        disturbance = find_disturbance(block, motion, found.fits, settings)
    unexplained = Reason("warn", "unexplained", UNEXPLAINED + _causes_of(found))
    if disturbance is None:
        return [*contact, unexplained]
    start_s, end_s = disturbance
    if start_s == 0:  # any effect that grows with the angle looks like it: the causes come first
        what = f"free rocking may begin only {end_s:.2f} s after the release, if the block was let go "
        what += "slowly, pushed, hit, braked, or caught and let go again: then leave the run out"
        return [*contact, unexplained, Reason("warn", "disturbed_release", what)]
    what = f"something acted on the block between {start_s:.2f} and {end_s:.2f} s after its release: a "
    what += "hit, a hand, or a slip: leave the run out"
    return [Reason("warn", "disturbed", what), *contact, unexplained]


def _nearest(found: Identified) -> str:
    """The candidate of which the first cause of its misfit leaves least; "" where none has a cause."""
    return min(found.causes, key=lambda model: found.causes[model][0].left, default="")


def _causes_of(found: Identified) -> str:
    """The numbered causes of a misfit of the nearest candidate; none where no laboratory is known."""
    best = _nearest(found)
    if not best:
        return ""
    told = ", ".join(f"({i}) {cause.text}" for i, cause in enumerate(found.causes[best], 1))
    beside = f" with free {' and '.join(found.widened).replace('_', ' ')}" if found.widened else ""
    return (
        f". {MODEL_LABELS[best]}{beside} comes nearest if one further cause acts. Possible causes, with "
        f"their share of its misfit (measure a cause before you change its setting): {told}"
    )


def hints_for(
    block: Block, motion: Motion, fits: Mapping[str, Fit], settings: Callable[[str], FitSettings]
) -> Iterator[Reason]:
    """The other rule of debonding, and the other sign of the laser, where a law then agrees with the noise.

    Parameters
    ----------
    block : Block
    motion : Motion
        The run.
    fits : mapping of str to Fit
        Of the run, by candidate; none of them explains it.
    settings : callable
        Of the fit of each candidate.
    """
    laws = [model for model in fits if not law_of(model).cases and not CANDIDATES[model].width]
    as_mirrored = with_other_sign(motion)
    for model in laws:
        own, start = settings(model), {name: fits[model].values[name] for name in MODELS[model]}
        if law_of(model).is_foundation:
            yield from _other_debonding(model, block, motion, own, start)
        if as_mirrored is not None and leaves_noise(model, block, own, None, as_mirrored):
            yield Reason(
                "warn", "other_sign", WOULD.format("the other sign of the laser", MODEL_LABELS[model])
            )


def _other_debonding(
    model: str, block: Block, motion: Motion, own: FitSettings, start: Mapping[str, float]
) -> Iterator[Reason]:
    """The other rule of debonding, where a law of a foundation then agrees with the noise."""
    (other,) = {*DEBONDING} - {own.debonding}
    free = tuple(name for name in own.free if name != "edge_radius")  # of the geometric rule alone
    if leaves_noise(model, block, replace(own, debonding=other, free=free), start, motion):
        yield Reason("warn", "other_debonding", WOULD.format(f"fits.debonding: {other}", MODEL_LABELS[model]))


def _smaller_law(
    found: Identified, chosen: str, block: Block, motion: Motion, hypotheses: Hypotheses
) -> Iterator[Reason]:
    """The other rule of debonding, where a case of the chosen law then agrees with the noise.

    What a bed that can't pull changes, a further parameter of a law may take up.
    """
    values = found.fits[chosen].values
    for model, candidate in CANDIDATES.items():
        if contains(chosen, model) and candidate.law != CANDIDATES[chosen].law and not candidate.width:
            start = {name: values[name] for name in MODELS[model]}
            yield from _other_debonding(
                model, block, motion, hypotheses.settings(model, found.widened), start
            )


def with_other_sign(motion: Motion) -> Motion | None:
    """A run as it would be under the other sign of its laser; None where no such rotation is possible.

    A face that tilts takes the beam further on one side than on the other, so the two signs differ by more
    than the sign of θ.
    """
    view = motion.view
    if view is None or view.laser.beam is None:
        return None
    theta, theta0 = (
        turned(-displaced(angle, view.block, view.laser), view.block, view.laser)
        for angle in (motion.theta, np.array([motion.theta0]))
    )
    if not np.isfinite(theta0[0]) or np.isnan(theta).sum() > np.isnan(motion.theta).sum():
        return None
    return replace(motion, theta=theta, theta0=float(theta0[0]))


class Disturbance(NamedTuple):
    """From when to when [s] since the release something else than the law acted on the block."""

    start_s: float
    end_s: float


def find_disturbance(
    block: Block,
    motion: Motion,
    fits: Mapping[str, Fit],
    settings: Callable[[str], FitSettings],
    louder: float = 1.1,
) -> Disturbance | None:
    """What lies between two parts of a run that one set of parameters explains, or before the first of them.

    Parameters
    ----------
    block : Block
    motion : Motion
        The run.
    fits : mapping of str to Fit
        Of the whole run, by candidate; none of them explains it.
    settings : callable
        Those of the fit of a candidate.
    louder : float
        Times the noise, from which a residual of the whole run is worth a search: of a squat block on a soft
        bed, whose record is short, four hits of 0.02 rad/s left 1.14 to 1.20 times the noise.
    """
    nearest = sorted(fits, key=lambda model: np.nan_to_num(fits[model].epsilon_theta, nan=np.inf))
    if not fits[nearest[0]].diagnostics["residual_over_sigma"] > louder:
        return None
    laws = [model for model in nearest if not CANDIDATES[model].is_rival]
    tops = tops_of(motion)
    for model in dict.fromkeys([*laws, *nearest[:1]]):
        found = fits[model].values
        start = {name: found[name] for name in (*MODELS[model], "width") if name in found}
        explained = partial(leaves_noise, model, block, settings(model), start)
        first = _first([from_top(motion, top) for top in tops], explained)
        if first == 0:
            return Disturbance(0.0, tops[0].time_s)
        if first is not None and explained(
            _until(motion, tops[first - 1].time_s), from_top(motion, tops[first])
        ):
            return Disturbance(tops[first - 1].time_s, tops[first].time_s)
    return None


def _first(parts: Sequence[Motion], explained: Callable[[Motion], bool]) -> int | None:
    """The first part that is explained, as all later ones are; None where the last one is not."""
    if not parts or not explained(parts[-1]):
        return None
    low, high = -1, len(parts) - 1  # that at low is not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if explained(parts[middle]) else (middle, high)
    return high


def _until(motion: Motion, end_s: float) -> Motion:
    """A run up to an instant [s]."""
    before = motion.time_s < end_s
    return replace(motion, time_s=motion.time_s[before], theta=motion.theta[before])
