"""Impacts of a run after a person has excluded stretches of time, or impacts by their instants."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.runs.by_hand import ByHand
from freerock.runs.impacts import IMPACT_COLUMNS, Impacts, restitution_from_peaks
from freerock.runs.segment import Run
from freerock.runs.verdict import Reason

NEAR_S = 0.05  # of an impact is the instant that names it
Find = Callable[[float, float, bool], Impacts]  # from when to when [s]; whether it begins with the release


class Used(NamedTuple):
    """Impacts of a run, and notes of what it lacks."""

    impacts: Impacts
    notes: list[Reason]


def impacts_used(find: Find, run: Run, block: Block, by_hand: ByHand) -> Used:
    """The impacts of a run, NaN where they are hidden or their restitution is not used.

    Between stretches each part has impacts of its own: no peak or restitution spans what is hidden. How many
    impacts a stretch hides follows from the energy that is lost in it.

    Parameters
    ----------
    find : callable
        Finds the impacts of a part of the run.
    run : Run
    block : Block
    by_hand : ByHand
    """
    hold_s, release_s, end_s = run.hold_start_s, run.release_s, run.end_s
    own = [each for each in by_hand.stretches if each[0] <= end_s and each[1] >= hold_s]
    hidden = sorted(each[:2] for each in own if each[0] < each[1] and each[1] > release_s and each[0] < end_s)
    notes = [
        Reason("ok", "left_out", f"{from_s:.3f} s to {to_s:.3f} s left out: {why}")
        for from_s, to_s, why in own
        if from_s < to_s
    ]
    begins = np.maximum.accumulate([release_s, *(to_s for _, to_s in hidden)]).tolist()
    ends = [*(from_s for from_s, _ in hidden), end_s]
    parts = [find(release_s, max(release_s, ends[0]), True)]
    parts += [find(*span, False) for span in zip(begins[1:], ends[1:], strict=True) if span[0] < span[1]]
    impacts = _joined(parts, run, block)
    for from_s, to_s, why in own:
        if from_s == to_s and (named := nearest(impacts.time_s, from_s)) is not None:
            kept = {
                name: getattr(impacts, name).copy()
                for name in IMPACT_COLUMNS
                if name.startswith("restitution")
            }
            for values in kept.values():
                values[named] = np.nan
            text = f"impact {named + 1} at {impacts.time_s[named]:.3f} s left out: {why}"
            impacts, notes = replace(impacts, **kept), [*notes, Reason("ok", "left_out", text)]
    return Used(impacts, notes)


def missed(by_hand: ByHand, found: Sequence[tuple[Run, Impacts]]) -> list[Reason]:
    """What was left out and is not there."""
    lasts_s = [(run.hold_start_s, run.end_s) for run, _ in found]
    passages = np.concatenate([np.empty(0), *(impacts.time_s for _, impacts in found)])
    passages = passages[np.isfinite(passages)]
    reasons = []
    for from_s, to_s, _ in by_hand.stretches:
        if from_s == to_s and nearest(passages, from_s) is None:
            text = f"exclude: there is no impact at {from_s:g} s"
            if passages.size:
                text += f": the nearest is at {passages[np.argmin(np.abs(passages - from_s))]:.3f} s"
            reasons.append(Reason("warn", "by_hand", text))
        elif from_s < to_s and not any(from_s < end_s and to_s > begin_s for begin_s, end_s in lasts_s):
            lasts = ", ".join(f"{begin_s:.3f} s to {end_s:.3f} s" for begin_s, end_s in lasts_s)
            text = f"exclude: {from_s:g} s to {to_s:g} s meets no run: they last from {lasts}"
            reasons.append(Reason("warn", "by_hand", text))
    return reasons


def nearest(passages: Floats, instant_s: float) -> int | None:
    """Which impact an instant names, None if there is none within `NEAR_S`."""
    apart = np.abs(np.nan_to_num(passages, nan=np.inf) - instant_s)
    return int(np.argmin(apart)) if apart.size and apart.min() <= NEAR_S else None


def _joined(parts: Sequence[Impacts], run: Run, block: Block) -> Impacts:
    """The impacts of all parts in order, with those that are hidden between, of which nothing is known."""
    known = [each for i, each in enumerate(parts) if i == 0 or each.time_s.size]
    if len(known) < 2:
        return known[0]
    columns: dict[str, list[Floats]] = {name: [getattr(known[0], name)] for name in IMPACT_COLUMNS}
    for before, after in pairwise(known):
        blank = np.full(_hidden(before, after, run, block), np.nan)
        for name, column in columns.items():
            column += [blank, getattr(after, name)]
    joined = {name: np.concatenate(column) for name, column in columns.items()}
    return Impacts(**joined, theta_uplift=max(each.theta_uplift for each in known))


def _hidden(before: Impacts, after: Impacts, run: Run, block: Block) -> int:
    """How many impacts there are between two parts: as many as take the energy that is lost between them.

    Each takes the share that those do which are seen. The sides of the swings say if their number is odd.
    """
    seen = np.concatenate([before.restitution, after.restitution])
    seen = seen[np.isfinite(seen)]
    each = float(np.median(seen)) if seen.size else block.restitution_housner
    start, end = before.peak_after_rad[-1] if before.time_s.size else run.theta0, after.peak_after_rad[0]
    lost, odd = restitution_from_peaks(start, 0.0, end, 0.0, block)[0], int(start * end < 0)
    n = math.log(lost) / math.log(each) if 0 < lost < 1 and 0 < each < 1 else 1.0
    return max(2 * round((n - odd) / 2) + odd, 2 - odd) - 1
