"""Is a run that no candidate explains free rocking from a later peak on?

A block at a peak starts as one that is let go from rest there. What was done to it before leaves no trace but
the height of the peak, so a part of the run tells what the whole of it can't: whether the law is wrong, or
something else than the law acted on the block, and when.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.fit import Fit
from freerock.identification.least_squares import least_squares
from freerock.identification.noise import HOPELESS, against_rest, hopeless_from, noise_of
from freerock.identification.nuisances import settled
from freerock.identification.search import approach, follow, growing_horizons
from freerock.identification.settings import FitSettings
from freerock.identification.start import from_top, posed, tops_of
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, MODELS
from freerock.runs.motion import Motion

# Times the noise, from which a residual of the whole run is worth a search: of a squat block on a soft bed,
# whose record is short, four hits of 0.02 rad/s left 1.14 to 1.20 times the noise.
LOUDER = 1.1


class Disturbance(NamedTuple):
    """From when to when [s] since the release something else than the law acted on the block."""

    start_s: float
    end_s: float


def find_disturbance(
    block: Block, motion: Motion, fits: Mapping[str, Fit], settings: Callable[[str], FitSettings]
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
    """
    nearest = sorted(fits, key=lambda model: np.nan_to_num(fits[model].epsilon_theta, nan=np.inf))
    if not fits[nearest[0]].diagnostics["residual_over_sigma"] > LOUDER:
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


def leaves_noise(
    model: str, block: Block, settings: FitSettings, start: Mapping[str, float] | None, *parts: Motion
) -> bool:
    """Whether the law with one set of parameters leaves only the noise at rest of parts of a run.

    Parameters
    ----------
    model : str
    block : Block
    settings : FitSettings
    start : mapping of str to float, or None
        Parameters to start from [SI]; without them a scan finds some.
    parts : Motion
        Of one run, or all of it.
    """
    try:
        problem = posed(model, [block] * len(parts), parts, settings)
    except FreerockError:  # too few samples
        return False
    if start is None:
        quick = approach(problem, None, HOPELESS * max(noise_of(part).variance for part in parts))
    else:
        quick = follow(problem.rough(), problem.start_at(start), growing_horizons(parts[0]))
    if quick.mean_square > hopeless_from(parts):
        return False
    samples = problem.samples()
    x = least_squares(problem, quick.x, samples).x
    best = settled(problem, x) if len(parts) == 1 else None
    if best is not None:
        return best.against_rest.is_noise
    free = ~problem.held(x)
    jacobian: Floats = problem.jacobian(x, samples)[:, free]
    rest = against_rest(problem.residual(x, samples), jacobian, samples.lengths, list(map(noise_of, parts)))
    return rest.is_noise
