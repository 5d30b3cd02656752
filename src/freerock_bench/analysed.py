"""The first run of a record on the way of an analysis: volts to verdict and fits."""

from dataclasses import replace
from typing import NamedTuple

import xarray as xr

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.noise.at_rest import noise_at_rest, quiet_stretches, usual_of
from freerock.noise.converter import converter_step
from freerock.populations.sensitivity import with_contributions
from freerock.rotation.faults import signal_quality
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, heard, loud, motion_of
from freerock.runs.runs_with_impacts import runs_with_impacts
from freerock.runs.segment import Run
from freerock.runs.verdict import Verdict
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import Identified, identify_run
from freerock.selection.reasons_after_fits import reasons_of_fits


class Analysed(NamedTuple):
    """Verdict of a run, what the search finds of it, and the motion in which it does; none of a run that
    fails."""

    verdict: Verdict
    found: Identified
    motion: Motion | None


class Measured(NamedTuple):
    """A run, its impacts, what a fit takes of it, none of a run that fails; σ of a sample at rest [V]."""

    run: Run
    impacts: Impacts
    motion: Motion | None
    noise_v: float


def signal_of(record: xr.Dataset) -> list[Floats]:
    """Time, rotation, its standard deviation and flags of a record, as runs are found in them."""
    return [record[name].values for name in ("time", "theta", "sigma_theta", "flags")]


def measured(
    time_s: Floats, volts: Floats, laser: Laser, block: Block, laboratory: Laboratory | None = None
) -> Measured:
    """The first run of a record, as the jobs of a campaign measure it.

    Parameters
    ----------
    time_s, volts : ndarray, shape (n_time,)
        The channel of the laser [s, V].
    laser : Laser
    block : Block
    laboratory : Laboratory, optional
        Whose inputs a fit moves; without it they are exact.

    Raises
    ------
    FreerockError
        As of `rotation.find_rotation` and `runs_with_impacts`.
    """
    record = find_rotation(time_s, volts, laser, block, "V")
    signal = signal_of(record)
    time_s, theta, sigma, _ = signal
    step = converter_step(volts, theta)
    run, impacts = runs_with_impacts(signal, block, signal_quality(record))[0]
    if run.verdict.level == "fail":
        return Measured(run, impacts, None, record.attrs["noise_v"])
    rate_hz = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
    noise = noise_at_rest(quiet_stretches(time_s, theta, sigma), rate_hz, step)
    noise = noise and noise.scaled(loud(run, time_s, sigma, usual_of(sigma)))
    motion = heard(motion_of(run, time_s, theta, view=view_of([laser], block)), noise)
    return Measured(run, impacts, replace(motion, laboratory=laboratory), record.attrs["noise_v"])


def analysed(
    time_s: Floats, volts: Floats, laser: Laser, block: Block, laboratory: Laboratory | None = None
) -> Analysed:
    """What the jobs of a campaign make of that run by default; all else, and the errors, as in `measured`."""
    run, _, motion, _ = measured(time_s, volts, laser, block, laboratory)
    if motion is None:
        return Analysed(run.verdict, Identified(), None)
    found = identify_run(block, motion, BY_DEFAULT)
    reasons = reasons_of_fits(run.verdict, block, motion, found, BY_DEFAULT)
    if laboratory is not None:
        for model, fit in found.fits.items():
            settings = BY_DEFAULT.settings(model, found.widened)
            found.fits[model] = with_contributions(fit, motion, laboratory, settings)
    return Analysed(run.verdict.adding(reasons), found, motion)
