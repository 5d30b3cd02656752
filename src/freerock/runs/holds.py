"""Where a record is held before a release."""

import math
from bisect import bisect
from collections.abc import Sequence

import numpy as np

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.faults import Fault
from freerock.rotation.still import UNSTEADY, Phase, stationary_phases
from freerock.runs.signal import Signal, invalid_in

MOVES = 0.02  # of the critical angle: a signal that sweeps less is of no release


def find_holds(signal: Signal, steady: Sequence[Phase], window_s: float) -> list[Phase]:
    """Phases that end with a release: the steady ones, and those too unsteady to be among them."""
    loose = stationary_phases(signal.t, signal.theta, window_s=window_s, floor_fraction=UNSTEADY)
    holds: list[Phase] = []  # in the order of time, and apart
    for phase in [*steady, *loose]:
        at = bisect(holds, phase.start_s, key=lambda hold: hold.start_s)
        beside = holds[max(at - 1, 0) : at + 1]
        apart = all(phase.end_s < hold.start_s or phase.start_s > hold.end_s for hold in beside)
        if phase.kind == "held" and phase.level and apart:
            holds.insert(at, phase)
    return holds


def no_release(
    phases: Sequence[Phase], block: Block | None, signal: Signal, faults: Sequence[Fault]
) -> FreerockError:
    """The error of a record without a release, with what can be said of it."""
    remedy = "check that the channel, the sign and the laser are those of this record"
    if not phases:
        what, remedy = "no release found: the signal never stands still", "record a rest and a held phase"
    else:
        held = max((phase.level for phase in phases), key=abs)
        swept = float(np.nanmax(signal.theta) - np.nanmin(signal.theta))
        what = "no release found: nowhere is the block held, let go and left to rock to rest"
        if block is not None and abs(held) >= block.theta_cr:
            what = (
                f"no release found: held at {math.degrees(held):.2f}°, beyond the block's critical angle "
                f"{math.degrees(block.theta_cr):.2f}°, it overturns"
            )
            remedy = "check the block's height and width and the laser's position"
        elif block is not None and swept < MOVES * block.theta_cr:
            what = f"nothing moves: the signal stays within {math.degrees(swept):.2g}°"
    invalid = invalid_in(signal, 0.02)
    lost = next((fault.note for fault in faults if fault.name == "target_lost"), "")
    if lost:
        what += f", the target is lost {lost}"
    elif invalid and "overturns" not in what:
        what += f", {invalid}"
    return FreerockError("record", what, remedy)
