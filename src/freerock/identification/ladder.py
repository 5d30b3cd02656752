"""The candidates that each run asks for: rungs of rivals, climbed in the scene that it needs."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from freerock.identification.candidates import Ladder
from freerock.identification.fit import evidence
from freerock.identification.holdout import of_other_runs
from freerock.identification.identified import Identified
from freerock.identification.rungs import climbed, of_laws
from freerock.identification.scenes import elsewhere, freer, on_edges
from freerock.models.block import Block
from freerock.runs.motion import Motion


def identify_run(block: Block, motion: Motion, ladder: Ladder) -> Identified:
    """The candidates that a run asks for.

    The base is taken for level, its edges for sharp and the release for measured. Where nothing explains the
    run so, or what does asks for it, the ladder is climbed again without.

    Parameters
    ----------
    block : Block
    motion : Motion
        With its noise at rest, where it was seen.
    ladder : Ladder

    Returns
    -------
    Identified
    """
    found = climbed(of_laws(block, motion, ladder), block, motion, ladder)
    if found.fits and not found.explained:
        found = elsewhere(found, block, motion, ladder) or found
    found = on_edges(found, block, motion, ladder)
    while better := next(freer(found, block, motion, ladder), None):
        found = better
    return found


def identify_runs(
    block: Block,
    motions: Mapping[int, Motion],
    ladder: Ladder,
    alone: Callable[[Block, Motion, Ladder], Identified] = identify_run,
) -> dict[int, Identified]:
    """The candidates that each run of a record asks for, held against its other runs.

    `motions` are the runs by number; `alone` identifies a run by itself; all else as in `identify_run`.
    """
    singly = {number: alone(block, motion, ladder) for number, motion in motions.items()}
    found = {number: each.copied() for number, each in singly.items()}
    for model in ladder.candidates:
        fits = {number: each.fits[model] for number, each in found.items() if _contends(model, each)}
        settings = {number: ladder.freeing(found[number].scene).settings(model) for number in fits}
        for number, epsilon in of_other_runs(model, block, motions, fits, settings).items():
            found[number].fits[model] = replace(fits[number], epsilon_holdout_runs=epsilon)
    return found


def _contends(model: str, found: Identified) -> bool:
    """Whether a candidate may be named for a run, so that its held-out discrepancy counts."""
    return model in found.fits and (evidence(found.fits[model]).explains or not found.explained)
