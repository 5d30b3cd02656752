"""The runs of a record with their impacts, checked before a model is fitted."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.config.processing import IMPACT_LIMITS, RUN_LIMITS, ImpactLimits, RunLimits
from freerock.models.block import Block
from freerock.noise.at_rest import at_rest, over_usual
from freerock.noise.converter import scatter
from freerock.noise.spectrum import Noise
from freerock.rotation.flags import signal_quality
from freerock.runs.by_hand import NOTHING_BY_HAND, ByHand
from freerock.runs.impacts import IMPACT_COLUMNS, Impacts, find_impacts, reasons_of_impacts
from freerock.runs.segment import Run, find_runs
from freerock.runs.uneven_restitution import reasons_of_unevenness
from freerock.runs.verdict import Reason, Verdict

if TYPE_CHECKING:
    import xarray as xr

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

    `record` is as `freerock.find_rotation` gives it; all else, and the errors, as in `segment.find_runs` and
    `impacts.find_impacts`.
    """
    time_s, theta, sigma, flags = (record[name].values for name in ("time", "theta", "sigma_theta", "flags"))
    quality = signal_quality(record)
    still = at_rest(time_s, theta, sigma, quality.converter_step, of_runs.window_s)
    noise, found = over_usual(still.noise, sigma), list[tuple[Run, Impacts]]()
    for run in find_runs(time_s, theta, sigma, flags, block, quality, by_hand, of_runs, still):

        def part(from_s: float, to_s: float, released: bool, run: Run = run) -> Impacts:
            during = slice(np.searchsorted(time_s, from_s), np.searchsorted(time_s, to_s, "right"))
            return find_impacts(
                time_s[during],
                theta[during],
                sigma[during],
                block,
                theta0=run.theta0 if released else None,
                theta0_stderr=run.theta0_stderr,
                limits=of_impacts,
                noise=noise,
                zero_stderr=run.zero_stderr,
            )

        impacts, notes = _with_stretches_left_out(part, run, by_hand)
        peaks = _of_peaks(time_s, theta, run, quality.converter_step)
        uneven = reasons_of_unevenness(impacts, block, peaks)
        verdict = _as_of_a_tilt(run.verdict) if any(each.name == TILTS for each in uneven) else run.verdict
        reasons = reasons_of_impacts(impacts, of_impacts) + uneven + notes
        found.append((replace(run, verdict=verdict.adding(reasons)), impacts))
    vain = by_hand.left_out_in_vain([(run.hold_start_s, run.end_s) for run, _ in found])
    runs = tuple(replace(run, verdict=run.verdict.adding(vain)) for run, _ in found)
    return Measured(runs, on_one_bed([each for _, each in found]), still.noise)


def on_one_bed(impacts: Sequence[Impacts]) -> tuple[Impacts, ...]:
    """Impacts of the runs of a record: where a tail does not show the bed, it is that of the other runs."""
    seen = [each.theta_uplift for each in impacts if each.theta_uplift > 0]
    usual = float(np.median(seen)) if seen else 0.0
    return tuple(replace(each, theta_uplift=each.theta_uplift or usual) for each in impacts)


def _with_stretches_left_out(
    part: Callable[[float, float, bool], Impacts], run: Run, by_hand: ByHand
) -> tuple[Impacts, list[Reason]]:
    """The impacts of a run, with one of NaN in place of those that a stretch left out hides, and its notes.

    No peak and no restitution spans what is hidden: `part` finds the impacts from an instant to another [s],
    of the first part with those that the release begins.
    """
    own = [each for each in by_hand.stretches if each[0] <= run.end_s and each[1] >= run.hold_start_s]
    hidden = sorted(each[:2] for each in own if each[1] > run.release_s and each[0] < run.end_s)
    notes = [
        Reason.of("left_out", f"{from_s:.3f} s to {to_s:.3f} s left out: {why}") for from_s, to_s, why in own
    ]
    begins = np.maximum.accumulate([run.release_s, *(to_s for _, to_s in hidden)]).tolist()
    ends = [*(from_s for from_s, _ in hidden), run.end_s]
    parts = [part(run.release_s, max(run.release_s, ends[0]), True)]
    parts += [part(*span, False) for span in zip(begins[1:], ends[1:], strict=True) if span[0] < span[1]]
    known = [each for i, each in enumerate(parts) if i == 0 or each.time_s.size]
    columns = {
        name: np.concatenate([value for each in known for value in ([np.nan], getattr(each, name))][1:])
        for name in IMPACT_COLUMNS
    }
    return Impacts(**columns, theta_uplift=max(each.theta_uplift for each in known)), notes


def _of_peaks(time_s: Floats, theta: Floats, run: Run, converter_step: float) -> float:
    """Standard deviation of θ over the length of a peak at rest after a run [rad]; 0 where no rest is seen.

    A mean of samples that a converter rounds alike is rounded as they are.
    """
    rounded = converter_step / math.sqrt(12) if converter_step > run.sigma_theta else 0.0
    after = theta[slice(*np.searchsorted(time_s, (run.end_s, run.end_s + AFTER_S)))]
    size = max(1, round(PEAK_S / (time_s[1] - time_s[0])))
    n = after.size // size
    means = after[: n * size].reshape(n, size).mean(axis=1)
    means = means[np.isfinite(means)]
    return max(rounded, scatter(means)) if means.size >= FEWEST else rounded


def _as_of_a_tilt(verdict: Verdict) -> Verdict:
    """On a base off level swings to its side are higher than those before: the fits may tell."""
    return Verdict(
        tuple(each._replace(verdict="warn") if each.name == "touched" else each for each in verdict.reasons)
    )
