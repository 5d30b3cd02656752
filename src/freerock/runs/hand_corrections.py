"""Returns the runs of a record as corrected by hand, and the reasons that corrections give to verdicts.

A correction's way to the fit: a person edits the campaign's CSV, or the review page does
(`review.corrections`). `config.record` reads its cells by `config.correction_cells`, `step_settings` passes
them to `jobs.make_record`. There `ByHand` masks the samples that are left out, sets runs as stated and marks
those that are excluded. `jobs.make_fits` passes over these; a record excluded whole has no runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freerock.config.correction_cells import Override
from freerock.rotation.flags import BY_HAND, FLAGS
from freerock.runs.verdict import Reason

if TYPE_CHECKING:
    import xarray as xr

SHARED = 0.5  # of the time of the shorter of two runs: then they are one


class Planned(NamedTuple):
    """A run of a record.

    Parameters
    ----------
    found : int or None
        Which of those that were found, from 0; None of one that was not.
    override : Override or None
        None of one that nobody set.
    release_s, end_s : float
        Release and end [s].
    """

    found: int | None
    override: Override | None
    release_s: float
    end_s: float


@dataclass(frozen=True)
class ByHand:
    """Corrections by hand; they take precedence over what is found.

    Parameters
    ----------
    overrides : sequence of (number, release_s, end_s, reason[, hold_s])
        Runs set by hand, as `Override`.
    exclusions : sequence of (number, reason)
        Runs left out: kept in the list and marked.
    stretches : sequence of (from_s, to_s, reason)
        Times whose samples are not used [s].
    """

    overrides: Sequence[tuple[Any, ...]] = ()
    exclusions: Sequence[tuple[int, str]] = ()
    stretches: Sequence[tuple[float, float, str]] = ()

    def without_hidden(self, record: "xr.Dataset") -> "xr.Dataset":
        """θ(t) of a record without the samples that are not used; they are flagged."""
        time_s = record["time"].values
        hidden = np.zeros(len(time_s), bool)
        for from_s, to_s, _ in self.stretches:
            hidden[slice(*np.searchsorted(time_s, (from_s, to_s)))] = True
        if not hidden.any():
            return record
        flags = record["flags"].values | np.where(hidden, BY_HAND["left_out"], 0).astype(np.uint8)
        known = FLAGS | BY_HAND
        masks = {"flag_masks": np.array([*known.values()], np.uint8), "flag_meanings": " ".join(known)}
        unseen: dict[str, Any] = {name: record[name].where(~hidden) for name in ("theta", "sigma_theta")}
        return record.assign(unseen | {"flags": ("time", flags, masks)})

    def merged(self, found: Sequence[tuple[float, float]], record_end_s: float) -> list[Planned]:
        """The runs of a record in the order of release.

        A run set by hand takes the place of the one found at its time: with the nearest release of those that
        share `SHARED` of their time with it. Where there is none, or another has its place, it is added.

        Parameters
        ----------
        found : sequence of (float, float)
            Release and end of each run that was found [s].
        record_end_s : float
            Last instant of the record [s]; a run released after it is left out.
        """
        in_order = sorted((Override(*each) for each in self.overrides), key=lambda each: each.release_s)
        set_by_hand = [each for each in in_order if each.release_s < record_end_s]
        places = [_place(each, found) for each in set_by_hand]
        runs = [Planned(i, None, *times) for i, times in enumerate(found) if i not in places]
        for i, each in enumerate(set_by_hand):
            place = places[i] if places[i] not in places[:i] else None
            runs.append(Planned(place, each, each.release_s, min(each.end_s, record_end_s)))
        return sorted(runs, key=lambda run: run.release_s)

    def reasons_of_corrections(self, runs: Sequence[Planned], record_end_s: float) -> list[list[Reason]]:
        """What was set by hand of each run, and what can't be so.

        What meets no run stands with all of them. Arguments as of `merged`.
        """
        everywhere = list[Reason]()
        for number, release_s, *_ in sorted(self.overrides, key=lambda each: float(each[1])):
            if release_s >= record_end_s:
                text = f"override: run {number} is released at {release_s:g} s"
                text = f"{text}, the record ends at {record_end_s:.3f} s"
                everywhere.append(Reason.of("by_hand", text, "warn"))
        for number, _ in sorted(self.exclusions):
            if not 1 <= number <= len(runs):
                name = "name run 1, the only one" if len(runs) == 1 else f"name one of runs 1 to {len(runs)}"
                everywhere.append(Reason.of("by_hand", f"exclude: there is no run {number}: {name}", "warn"))
        reasons, left_out = [], dict(self.exclusions)
        for number, run in enumerate(runs, 1):
            own = [Reason.of("overridden", f"overridden: {run.override.reason}")] if run.override else []
            if number in left_out:
                own.append(Reason.of("excluded", f"excluded: {left_out[number]}"))
            own += everywhere
            if run.override and run.override.run != number:
                text = f"set by hand as run {run.override.run}, it is run {number} in the order of release"
                own.append(Reason.of("renumbered", f"{text}: correct the number, and those in exclude"))
            if run.override and run.override.end_s > record_end_s:
                text = (
                    f"set by hand to end at {run.override.end_s:g} s, the record ends at {record_end_s:.3f} s"
                )
                own.append(Reason.of("by_hand", f"{text}: give an end within the record"))
            reasons.append(own)
        kept = [number for number in range(1, len(runs) + 1) if number not in left_out]
        for one, other in pairwise(kept):
            before, after = runs[one - 1], runs[other - 1]
            if before.end_s <= after.release_s:
                continue
            text = (
                f"run {one} ends at {before.end_s:.3f} s, run {other} is released at {after.release_s:.3f} s"
            )
            if before.override:
                text = f"{text}: end it before, or exclude run {other}"
                reasons[one - 1].append(Reason.of("by_hand", text))
            elif after.override:
                text = f"{text}: release it later, or exclude run {one}"
                reasons[other - 1].append(Reason.of("by_hand", text))
        return reasons

    def reasons_of_stretches(self, runs: Sequence[tuple[float, float]]) -> list[list[Reason]]:
        """What is left out of each run, from its hold to its end [s]; what meets no run stands with all."""
        lasts = ", ".join(f"{begin_s:.3f} s to {end_s:.3f} s" for begin_s, end_s in runs)
        own, everywhere = [list[Reason]() for _ in runs], list[Reason]()
        for from_s, to_s, why in self.stretches:
            text = f"{from_s:.3f} s to {to_s:.3f} s left out: {why}"
            met = [i for i, (begin_s, end_s) in enumerate(runs) if from_s < end_s and to_s > begin_s]
            for i in met:
                own[i].append(Reason.of("left_out", text))
            if not met:
                text = f"exclude: {from_s:g} s to {to_s:g} s meets no run: they last from {lasts}"
                everywhere.append(Reason.of("by_hand", text, "warn"))
        return [[*each, *everywhere] for each in own]


def _place(override: Override, found: Sequence[tuple[float, float]]) -> int | None:
    """Which of the runs found a run set by hand stands for, None for none."""
    near = []
    for i, (release_s, end_s) in enumerate(found):
        together = min(end_s, override.end_s) - max(release_s, override.release_s)
        if together > SHARED * min(end_s - release_s, override.end_s - override.release_s):
            near.append((abs(release_s - override.release_s), i))
    return min(near)[1] if near else None


NOTHING_BY_HAND = ByHand()
