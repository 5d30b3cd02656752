"""Settings under which a law of the paper explains a run that no candidate does: said, never done."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from freerock.identification.fit import Fit
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, DEBONDING, MODEL_LABELS, MODELS, law_of
from freerock.rotation.beam import displaced, turned
from freerock.runs.motion import Motion
from freerock.runs.verdict import Reason
from freerock.selection.disturbance import leaves_noise
from freerock.selection.hypotheses import Hypotheses


def hints_for(
    block: Block, motion: Motion, fits: Mapping[str, Fit], hypotheses: Hypotheses
) -> Iterator[Reason]:
    """The other rule of debonding, and the other sign of the laser, where a law then leaves only noise.

    Parameters
    ----------
    block : Block
    motion : Motion
        The run.
    fits : mapping of str to Fit
        Of the run, by candidate; none of them explains it.
    hypotheses : Hypotheses
        Those of the campaign.
    """
    laws = [
        model
        for model in fits
        if not CANDIDATES[model].is_rival and law_of(model).is_foundation and not law_of(model).cases
    ]
    as_mirrored = mirrored(motion)
    for model in laws:
        settings = hypotheses.settings(model)
        start = {name: fits[model].values[name] for name in MODELS[model]}
        (other,) = {*DEBONDING} - {settings.debonding}
        would = f"would fit with {{}}: {MODEL_LABELS[model]} then leaves only noise"
        if leaves_noise(model, block, replace(settings, debonding=other), start, motion):
            text = would.format(f"fits.debonding: {other}")
            yield Reason("warn", "other_debonding", text)
        if as_mirrored is not None and leaves_noise(model, block, settings, None, as_mirrored):
            yield Reason("warn", "other_sign", would.format("the other sign of the laser"))


def mirrored(motion: Motion) -> Motion | None:
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
