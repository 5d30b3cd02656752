"""The causes of a misfit, ranked by the share that each would remove.

Of the residual r that a fit would leave with its inputs as stated and the derivative a by an input or by an
effect that no law has, both whitened and without what the free numbers take up, the cause alone would take
(a·r)²/(a·a) of r·r, moved by -(a·r)/(a·a): the score of a number that is not yet free. Causes whose
derivatives are alike are named together.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from freerock.identification.levels import EFFECTS
from freerock.identification.likelihood import Whitened
from freerock.identification.nuisances import Nuisances, Posterior, at, without_own
from freerock.identification.pursuit import multiplies_errors
from freerock.rotation.laboratory import Input, Laboratory
from freerock.selection.unmodelled import EITHER, Effect, effects, forces, line_in

TOLD = 3  # causes; a line in the residual is always one of them
LINE = "oscillation"
LEAST = 0.05  # of the misfit
TWINS = 3  # that are named together, at most
ALIKE = 0.95  # cosine of derivatives that no run tells apart
OFFSET_M = 3e-4  # in units of which an offset of the centre of mass is tried


class Cause(NamedTuple):
    """A cause by its name, in words with what it would have to be, the share of the misfit that it takes,
    the misfit left with a charge for each free number, and its amount [SI]."""

    name: str
    what: str
    share: float
    left: float
    off: float = 0.0

    @property
    def text(self) -> str:
        """In words."""
        return f"{self.name}, {self.what} ({100 * self.share:.0f} %)"


class _Tried(NamedTuple):
    """A cause that is tried: its share of the misfit, the misfit beside it, amount, whitened derivative."""

    effect: Effect
    share: float
    left: float
    amount: float
    direction: np.ndarray

    @property
    def name(self) -> str:
        """Of the cause."""
        return self.effect.name

    @property
    def text(self) -> str:
        """What it would have to be."""
        return self.effect.text(self.amount)


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
    own = [_effect_of(each, laboratory) for each in sources]
    every = sorted(_scored(end, [*own, *effects(end)]), key=lambda each: -each.share)
    causes = _named([each for each in every if each.share > LEAST])
    if any(each.name == LINE for each in causes):
        return causes
    return [*causes[: TOLD - 1], *_named([each for each in every if each.name == LINE])]


class Required(NamedTuple):
    """An effect that no law or input contains: in words with its amount, by how many standard errors that is
    off zero, and by how much it shifts each free number [SI]."""

    name: str
    what: str
    deviations: float
    shifts: dict[str, float]


def required_effect(best: Posterior) -> Required | None:
    """The most significant effect beside a law that explains a run; None where none is significant.

    By the score of each amount beside all free numbers and inputs with their priors. Lost samples are left
    out, since at one of so many instants chance seems to lose half of one; so is what differs from left to
    right, which a tilt or the zero of the sensor does too, and what bends the reading, as slow noise does.

    Parameters
    ----------
    best : Posterior
        Where the fit of one run ended, at its tolerance.
    """
    if multiplies_errors(best.problem, best.x):  # derivatives are none there
        return None
    known, n = forces(best), best.columns.shape[1]
    if not known:
        return None
    value, rows = best.prior
    prior = value, np.hstack([rows, np.zeros((len(rows), len(known)))])
    columns = np.column_stack([best.columns, *(each.column for each in known)])
    noises = [each.noise for each in best.problem.motions]
    whitened = Whitened(best.residual, columns, best.samples.lengths, noises, prior, best.level)
    every = np.vstack([whitened.rows, np.column_stack(prior)])
    left, *own = without_own(every[:, 1 : 1 + n], np.delete(every, np.s_[1 : 1 + n], axis=1)).T
    size = np.maximum(np.linalg.norm(own, axis=1), np.finfo(float).tiny)
    score = own @ left / size
    likely = [
        j
        for j, each in enumerate(known)
        if each.bounds[0] <= -score[j] / size[j] <= each.bounds[1] and abs(score[j]) > EFFECTS / 2
    ]
    if not likely:
        return None
    alone, at_first = best.whitened.likelihood(), max(likely, key=lambda j: abs(score[j]))
    effect = known[at_first]
    beside = best.whitened.adding(effect.column)
    off = math.sqrt(max(alone.minus_two_log - beside.minus_two_log, 0.0))
    if off < EFFECTS:
        return None
    free = np.flatnonzero(best.free)
    change = best.problem.gradient(best.x)[np.ix_(free, free)] @ (beside.step[:-1] - alone.step)[: len(free)]
    names = [best.problem.names[i] for i in free]
    what = effect.text(float(beside.step[-1]))
    return Required(effect.name, what, off, dict(zip(names, change.tolist(), strict=True)))


def _scored(end: Posterior, known: list[Effect]) -> Iterator[_Tried]:
    """Each cause with its score; effects stand behind the inputs."""
    n, noises = int(end.free.sum()), [each.noise for each in end.problem.motions]
    columns = np.column_stack([end.columns, *(each.column for each in known[len(end.z) :])])
    as_stated = end.residual - end.by_inputs @ end.z
    rows = Whitened(as_stated, columns, end.samples.lengths, noises).rows
    others = without_own(rows[:, 1 : 1 + n], np.delete(rows, np.s_[1 : 1 + n], axis=1))
    left, columns = others[:, 0], others[:, 1:]
    size = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    score, whole = columns.T @ left / size, max(float(left @ left), np.finfo(float).tiny)
    charge = (n + 1) * math.log(len(left))
    for j, each in enumerate(known):
        amount, share = float(-score[j] / size[j]), float(score[j] ** 2) / whole
        if each.bounds[0] <= amount <= each.bounds[1]:
            rest = whole * (1 - share) + charge
            yield _Tried(each, share, rest, amount, columns[:, j] / size[j])
    frequency, share = line_in(replace(end, residual=as_stated))
    if not frequency:
        return
    what = f"a line at {frequency:.1f} Hz, as of a table or an upper part that swings, which bias k"
    rest = whole * (1 - share) + charge
    line = Effect(LINE, np.empty(0), lambda _: what)
    yield _Tried(line, share, rest, frequency, np.zeros(len(left)))


def _named(tried: list[_Tried]) -> list[Cause]:
    """The first ones, each name once, with those of other names that no run tells from it."""
    causes, told = list[Cause](), set[str]()
    for each in tried:
        if each.name in told or len(causes) == TOLD:
            continue
        told.add(each.name)
        twins = dict[str, str]()
        for other in tried:
            if other.name not in told and abs(other.direction @ each.direction) > ALIKE:
                twins.setdefault(other.name, f"{other.name}, {other.text}")
        told |= {*twins}
        what = " or ".join([each.text, *[*twins.values()][: TWINS - 1]])
        causes.append(Cause(each.name, what, each.share, each.left, each.amount * each.effect.unit))
    return causes


def _effect_of(source: Input, laboratory: Laboratory) -> Effect:
    """An input that is off by standard uncertainties."""
    unit = f" {source.unit}" if source.unit != "1" else ""
    twin = ", or a tilt of the base" if source.name == "com_offset_m" else ""
    if source.name == "response_ms":  # what it does grows with its square

        def slower(by: float) -> str:
            (laser,) = laboratory.moved(source, by).lasers.values()
            return f"{laser.response_ms:.1f} ms of {source.owner}"

        return Effect(source.name, np.empty(0), slower, unit=source.u)

    def text(by: float) -> str:
        return f"{by * source.u:+.2g}{unit} of {source.owner}{twin}"

    return Effect(source.name, np.empty(0), text, EITHER, source.u)


def _tried(inputs: tuple[Input, ...]) -> Iterator[Input]:
    """The inputs that may be off; also the offset of the centre of mass, which does what a tilt does."""
    names = {each.name for each in inputs}
    yield from (each for each in inputs if each.u > 0 and each.name not in ("levelled_deg", "mass_kg"))
    owners = [each.owner for each in inputs if each.name == "height_m"]
    if owners and "com_offset_m" not in names:
        yield Input(owners[0], "com_offset_m", OFFSET_M, False)
