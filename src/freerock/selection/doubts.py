"""What the fits of a run say against it, with its likely causes."""

from freerock.models.block import Block
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason, Verdict
from freerock.selection.disturbance import find_disturbance
from freerock.selection.hints import hints_for
from freerock.selection.hypotheses import Hypotheses
from freerock.selection.identified import Identified
from freerock.selection.scene_notes import (
    explains_as_well,
    notes_on_scene,
    pulled_inputs,
    slow_sensor,
)

UNEXPLAINED = "no candidate explains the run down to its noise"
CAUSES = (
    "the base may be off level, sign or face of the laser wrong, the corners rounded, the sensor slow or its "
    "beam lower than stated, or another law holds"
)
NO_REST = (
    "no rest or hold is long enough to show the noise of the sensor: the standard errors know the noise from "
    "what the fit leaves alone"
)
ALWAYS = "alternating_restitution"  # its cause acts all through the run: no part of it is undisturbed


def doubts_about_noise(motion: Motion) -> list[Reason]:
    """Of a run in whose record nothing rests long enough to show the noise, that its errors know less."""
    return [Reason("warn", "no_rest", NO_REST)] if motion.noise is None else []


def doubts_about(
    measured: Verdict, block: Block, motion: Motion, found: Identified, hypotheses: Hypotheses
) -> list[Reason]:
    """Of a run that a candidate explains, what it found of base and release; else that none does, under
    which setting one would, or what acted on the block when.

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
        chosen = found.choice(hypotheses).selected
        notes = notes_on_scene(found.fits[chosen], block, motion) if found.widened else []
        for other, fit in found.alternatives.items():
            notes += explains_as_well(other, fit, found.fits[chosen])
        notes += pulled_inputs(found.fits[chosen])
        return [*notes, *slow_sensor(found.at_best(chosen, block, motion, hypotheses), motion)]
    if not found.fits:
        return []
    hints = list(hints_for(block, motion, found.fits, hypotheses))
    if hints:
        return [*hints, Reason("warn", "unexplained", UNEXPLAINED)]
    disturbance = None
    if ALWAYS not in measured.names:
        disturbance = find_disturbance(block, motion, found.fits, hypotheses.settings)
    if disturbance is None:
        known = any(name.endswith("_restitution") for name in measured.names)
        text = UNEXPLAINED if known else f"{UNEXPLAINED}: {CAUSES}"
        return [Reason("warn", "unexplained", text)]
    start_s, end_s = disturbance
    name, what = (
        "disturbed",
        f"something acted on the block between {start_s:.2f} and {end_s:.2f} s after its ",
    )
    what += "release: a hit, a hand, or a slip"
    if start_s == 0:
        name, what = (
            "disturbed_release",
            f"free rocking begins only {end_s:.2f} s after the release: the block ",
        )
        what += "was let go slowly, pushed, hit, braked, or caught and let go again"
    return [Reason("warn", name, f"{what}: leave the run out"), Reason("warn", "unexplained", UNEXPLAINED)]
