"""Reasons that a fit finds in the set-up, base, release and sensor, in words."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from freerock.identification.fit import Fit
from freerock.identification.inputs_with_priors import Posterior
from freerock.identification.problem import release_bounds
from freerock.identification.significance_levels import EFFECTS, NORMAL_95, PULLED, SLOWER_RESPONSE, WARNS
from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS, MODELS
from freerock.runs.motion import Motion
from freerock.runs.uneven_restitution import EVEN
from freerock.runs.verdict import Level, Reason
from freerock.selection.allowed_hypotheses import Hypothesis
from freerock.selection.causes import Cause
from freerock.selection.quick import blur_of


@dataclass(frozen=True)
class ReasonLimits:
    """What is reported of base and release, and from where on it is a warning.

    Parameters
    ----------
    least_deg, least_mm : float
        Smallest reported tilt, since its standard error omits that of the reading at rest; smallest reported
        radius of edges.
    rounded : float
        Of b, radius of edges that is a warning: with sharp ones k would be off by percents.
    pushed : float
        Share of the release angle from which another one is a warning, as `max_push_fraction`.
    late_ms : float
        From which a block held back was braked. Eight fingers that left over 80 ms were late by 5 to 9 ms,
        seven brakes by a fifth that such a release seemed to explain, k up to 4.2 standard errors off, by 12
        to 21.
    narrowest : float
        Of the stated contact width, a fitted one below which a scale is wrong rather than a corner worn.
        Worn corners of simulated blocks leave 0.8 and more; half a range, 0.5.
    """

    least_deg: float = 1e-3
    least_mm: float = 0.01
    rounded: float = 0.01
    pushed: float = 0.02
    late_ms: float = 10.0
    narrowest: float = 0.7


REASON_LIMITS = ReasonLimits()
SET_IT = "find out, and set the laser's response_ms"


def notes_on_scene(fit: Fit, block: Block, motion: Motion) -> list[Reason]:
    """How far the base is off level, and what the finger did, where a fit had to find them."""
    notes = []
    if "tilt" in fit.parameters:
        notes.append(_of_base(fit, block))
    if "edge_radius" in fit.parameters:
        notes.append(_of_edges(fit, block))
    measured, half = {"theta0": motion.theta0, "t0": 0.0}, release_bounds(motion)
    if any(abs(fit.values[name] - value) > half[name] for name, value in measured.items()):
        notes.append(_of_release(fit, block, motion))
    return notes


def explains_as_well(
    other: Hypothesis, as_well: Fit, fit: Fit, possible: Collection[str], widened: Sequence[str] = ()
) -> Iterator[Reason]:
    """That a hypothesis with other priors, or with an input beyond its prior, explains a run as well, with
    another k or r. Its name is that of what differs. It is a warning where that k or r lies beyond 1.96 u of
    the named fit, or its law is none of those that explain the run otherwise.

    Parameters
    ----------
    other : Hypothesis
    as_well : Fit
        Under it.
    fit : Fit
        Of the hypothesis that is named, before its u took up any other.
    possible : collection of str
        Candidates that explain the run beside the same priors as it.
    widened : sequence of str
        Priors that the hypotheses of the run widen where they may.
    """
    name, values = fit.parameters[0], as_well.values
    change = values.get(name, math.inf) / fit.value[0] - 1
    apart = abs(values.get(name, math.inf) - fit.value[0]) / fit.u_total[0]
    if not apart > 1 and other.model in possible:
        return
    said, reason, freed = list[str](), "", {*values, *fit.values, *widened}
    unlike = {*other.widened} ^ {*widened}
    differs = unlike if "release" in unlike else freed
    if "tilt" in freed:
        tilt = math.degrees(values.get("tilt", 0.0))
        reason = "off_level" if "tilt" in differs else reason
        if tilt or not any(each.startswith("levelled_deg") for each in other.widened):
            said.append(f"a base off level by {tilt:.3f} degrees" if tilt else "a level base")
    if "edge_radius" in freed:
        radius = 1e3 * values.get("edge_radius", 0.0)
        reason = "rounded_edges" if "edge_radius" in differs else reason
        said.append(f"edges rounded by {radius:.2f} mm" if radius else "sharp edges")
    if "release" in other.widened:
        said.append("another release")
    known = as_well.contributions
    for source, by in zip(known.inputs, known.moved, strict=True) if known else ():
        if source.label in other.widened:
            off = f"{by * source.u:+.3g} {source.unit}".removesuffix(" 1")
            said, reason = [*said, f"{source.label} off by {off}"], "pulled_input"
    if not reason:  # the release, which one of the two takes as measured
        measured, other_release = (fit, as_well) if "release" in other.widened else (as_well, fit)
        angles = [abs(each.values.get("theta0", each.theta_model[0])) for each in (measured, other_release)]
        reason = _name_of_release(angles[1] > angles[0])
    moved = f"{name} {100 * change:+.2g} %" if math.isfinite(change) else f"no {name}"
    text = f"{MODEL_LABELS[other.model]} with {' and '.join(said) or 'the release as measured'}"
    verdict: Level = "ok" if apart < NORMAL_95 and other.model in possible else "warn"
    yield Reason(verdict, reason, f"{text} explains the run as well, with {moved}: measure what differs")


def pulled_inputs(fit: Fit) -> Iterator[Reason]:
    """The inputs that a fit moved by more than two standard deviations; a warning where that is no chance."""
    found = fit.contributions
    if found is None:
        return
    beyond = found.p_of_pulls < WARNS
    for source, moved, pull in zip(found.inputs, found.moved, found.pulls, strict=True):
        if abs(pull) > PULLED:
            by = f"{moved * source.u:+.2g}" + (f" {source.unit}" if source.unit != "1" else "")
            text = f"{source.label} fitted {by} off, a pull of {pull:.1f}"
            text += ": measure it again" if beyond else ""
            yield Reason("warn" if beyond else "ok", "pulled_input", text, float(abs(pull)), PULLED, "1")


def odd_contact(fit: Fit, block: Block) -> Iterator[Reason]:
    """A warning where a freed contact width is none of corners: wider than the block, or far narrower."""
    if "width" not in fit.parameters:
        return
    share = fit.values["width"] / (2 * block.b)
    if share < REASON_LIMITS.narrowest:
        text = f"contact width fitted {100 * share:.0f} % of the stated one: measure width, and check scale, "
        text += "range and height of the beam"
        yield Reason("warn", "pulled_input", text, share, REASON_LIMITS.narrowest, "1")
    found = fit.contributions
    if found is None:
        return
    known = zip(found.inputs, found.moved, found.remaining, strict=True)
    of_width = [(by * each.u, left * each.u) for each, by, left in known if each.name == "width_m"]
    moved, u = of_width[0] if of_width else (0.0, 0.0)
    off = fit.values["width"] - block.width_m - moved
    pull = off / math.hypot(fit.u_total[fit.parameters.index("width")], u)
    if pull > PULLED:
        text = f"contact width fitted {off:.2g} m wider than the block, a pull of {pull:.1f}: measure width, "
        text += "height of the beam and scale again"
        yield Reason("warn", "pulled_input", text, float(pull), PULLED, "1")


def slow_sensor(best: Posterior, motion: Motion) -> Iterator[Reason]:
    """A warning where the run is blurred, by where its fit ended.

    A sensor or filter that averages over a few milliseconds leaves no more than noise, and k too small.
    """
    off_zero, more_s = blur_of(best)
    if off_zero > SLOWER_RESPONSE:
        stated_ms = motion.view.laser.response_ms if motion.view else 0.0
        text = f"blurred as by a sensor that averages over {1e3 * more_s:.1f} ms, beside the {stated_ms:g} ms"
        width = "width" in best.problem.names
        text += " stated: " + ("measure the contact width first, which is fitted too" if width else SET_IT)
        yield Reason("warn", "slow_sensor", text, float(off_zero), SLOWER_RESPONSE, "1")


def unmodelled_effect(fit: Fit, effect: Cause) -> Reason:
    """A warning where a run that a law explains requires an effect that no law or input contains."""
    shifts = [
        f"{name} {100 * effect.shifts[name] / fit.values[name]:+.2g} %"
        for name in MODELS[fit.model]
        if effect.shifts.get(name)
    ]
    text = f"requires {effect.name}, {effect.what}" + f": it would change {' and '.join(shifts)}" * bool(
        shifts
    )
    return Reason("warn", "unmodelled_effect", text, effect.deviations, EFFECTS, "1")


def _of_base(fit: Fit, block: Block) -> Reason:
    """A warning where the restitution alternates by more than that of clean runs scatters."""
    tilt, error = (math.degrees(number[fit.parameters.index("tilt")]) for number in (fit.value, fit.stderr))
    level = math.degrees(EVEN[0].scatter * block.b / block.h)
    matters = abs(tilt) > level
    side = "right" if tilt > 0 else "left"
    error = max(error, REASON_LIMITS.least_deg)
    text = f"base off level by {abs(tilt):.3f} ± {error:.3f} degrees, lower on the {side}"
    twins = ": level it; an off-centre mass or unequal corners have nearly the same effect"
    text += ", and fitted so" + twins * matters
    return Reason("warn" if matters else "ok", "off_level", text, abs(tilt), level, "degree")


def _of_edges(fit: Fit, block: Block) -> Reason:
    """A warning where sharp edges would have made k wrong by much."""
    radius, error = (
        1e3 * float(number[fit.parameters.index("edge_radius")]) for number in (fit.value, fit.stderr)
    )
    text = f"edges rounded by {radius:.2f} ± {max(error, REASON_LIMITS.least_mm):.2f} mm, and fitted so"
    limit = 1e3 * REASON_LIMITS.rounded * block.b
    text += ": measure them" * (radius > limit)
    return Reason("warn" if radius > limit else "ok", "rounded_edges", text, radius, limit, "mm")


def _of_release(fit: Fit, block: Block, motion: Motion) -> Reason:
    """What the finger did, from the energy that the block had beyond that of the hold."""
    angle, late = abs(fit.values["theta0"]), 1e3 * fit.values["t0"]
    more = _rise(block, angle) - _rise(block, abs(motion.theta0))
    rate = block.p * math.sqrt(2 * abs(more) / math.hypot(block.b, block.h))
    did = f"pushed, by about {rate:.2g} rad/s" if more > 0 else "held back by a slow finger"
    when = f"{abs(late):.1f} ms {'later' if late > 0 else 'earlier'}"
    text = (
        f"{did}: the block moves as if let go from rest at {math.degrees(angle):.3f} degrees instead of "
        f"{math.degrees(abs(motion.theta0)):.3f}, {when}"
    )
    off = angle / abs(motion.theta0) - 1
    name, text = _name_of_release(more > 0), f"{text}, and is fitted so"
    far, slow = abs(off) > REASON_LIMITS.pushed, more < 0 and late > REASON_LIMITS.late_ms
    if slow and not far:
        return Reason("warn", name, text, late, REASON_LIMITS.late_ms, "ms")
    return Reason("warn" if far else "ok", name, text, off, REASON_LIMITS.pushed, "1")


def _name_of_release(higher: bool) -> str:
    """Of a reason on a block that moves as if let go from a higher angle than it was held at, or a lower."""
    return "pushed" if higher else "held_back"


def _rise(block: Block, theta: float) -> float:
    """Of the centre of mass [m] when a rigid block has turned by θ about a corner."""
    return block.b * math.sin(theta) - 2 * block.h * math.sin(theta / 2) ** 2
