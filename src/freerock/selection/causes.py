"""The causes of a misfit, ranked by what each would take of it.

Of the residual r that a fit leaves and the derivative a by an input, both whitened and without what the free
numbers take up, the input alone would take (a·r)²/(a·a) of r·r, moved by -(a·r)/(a·a): the score of an input
that is not yet free.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from freerock.identification.nuisances import Nuisances, Posterior, at, without_own
from freerock.rotation.laboratory import Input

TOLD = 3  # causes
LEAST = 0.05  # of the misfit
OFFSET_M = 3e-4  # in units of which an offset of the centre of mass is tried


class Cause(NamedTuple):
    """An input, the share of the misfit that it would take, and by how much it would have to be off."""

    source: Input
    share: float
    off: float

    @property
    def text(self) -> str:
        """In words."""
        unit = f" {self.source.unit}" if self.source.unit != "1" else ""
        twin = " or a tilt of the base" if self.source.name == "com_offset_m" else ""
        name = f"{self.source.name} of {self.source.owner}{twin}"
        return f"{name} ({100 * self.share:.0f} %, {self.off:+.2g}{unit})"


def ranked(best: Posterior) -> list[Cause]:
    """The causes that would take most of a misfit, the first first; none where no laboratory is known.

    Parameters
    ----------
    best : Posterior
        Where the fit of one run ended that nothing explains.
    """
    problem, moved = best.nuisances.problem, dict(zip(best.nuisances.sources, best.z.tolist(), strict=True))
    laboratory = problem.motions[0].laboratory
    if laboratory is None:
        return []
    sources = tuple(_tried(laboratory.inputs))
    z = np.array([moved.get(each, 0.0) for each in sources])
    end = at(Nuisances(problem, sources), best.x, z, best.samples)
    n = int(end.free.sum())
    rows = end.beside((np.empty(0), np.empty((0, n + len(sources))))).rows
    others = without_own(rows[:, 1 : 1 + n], np.delete(rows, np.s_[1 : 1 + n], axis=1))
    left, by_inputs = others[:, 0], others[:, 1:]
    size = np.maximum(np.sum(by_inputs**2, axis=0), np.finfo(float).tiny)
    score = by_inputs.T @ left
    shares = score**2 / size / max(float(left @ left), np.finfo(float).tiny)
    causes = [
        Cause(each, float(share), float(-score[j] / size[j] * each.u))
        for j, (each, share) in enumerate(zip(sources, shares, strict=True))
        if share > LEAST
    ]
    return sorted(causes, key=lambda cause: -cause.share)[:TOLD]


def _tried(inputs: tuple[Input, ...]) -> Iterator[Input]:
    """The inputs that may be off; also the offset of the centre of mass, which does what a tilt does."""
    names = {each.name for each in inputs}
    yield from (each for each in inputs if each.u > 0 and each.name not in ("levelled_deg", "mass_kg"))
    owners = [each.owner for each in inputs if each.name == "height_m"]
    if owners and "com_offset_m" not in names:
        yield Input(owners[0], "com_offset_m", OFFSET_M, False)
