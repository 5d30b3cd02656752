"""The causes of a misfit, ranked by the share that each would remove.

Of the residual r that a fit would leave with its inputs as stated and the derivative a by an input or by an
effect that no law has, both whitened and without what the free numbers take up, the cause alone would take
(a·r)²/(a·a) of r·r, moved by -(a·r)/(a·a): the score of a number that is not yet free. Causes whose
derivatives are alike are named together.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.identification.diverging_motions import multiplies_errors
from freerock.identification.inputs_with_priors import Nuisances, Posterior, at, without_own
from freerock.identification.likelihood import Whitened
from freerock.identification.significance_levels import EFFECTS
from freerock.models.free_parameters import symbol_of
from freerock.rotation.laboratory import Input, Laboratory
from freerock.selection.unmodelled import Effect, effects, forces, line_in

TOLD = 3  # causes; a line in the residual is always one of them
LINE = "oscillation"
LEAST = 0.05  # of the misfit
TWINS = 3  # that are named together, at most
ALIKE = 0.95  # cosine of derivatives that no run tells apart
# By how much an input may be off that was measured at all: lengths [m], others in standard uncertainties.
# Wrong ones of kinds of laboratories are off by up to 5 mm and 100 u, twins of a beam that leans by 25 mm.
FARTHEST_M, FARTHEST = 0.01, 150.0
OFFSET_M = 3e-4  # in units of which an offset of the centre of mass is tried


class Cause(NamedTuple):
    """A cause of what a fit leaves.

    Parameters
    ----------
    name, what : str
        In words, with what it would have to be.
    share : float
        Of the misfit, that it takes.
    left : float
        Misfit that remains, with a charge for each free number.
    off : float
        Its amount, in the unit of the effect or input.
    shifts : dict of str to float
        By how much it would change each free number [SI]; the most that one of several named together would.
    deviations : float
        Standard errors by which the amount is off zero, where the law explains the run; else NaN.
    """

    name: str
    what: str
    share: float
    left: float
    off: float
    shifts: dict[str, float]
    deviations: float = math.nan

    @property
    def text(self) -> str:
        """In words."""
        return f"{self.name}, {self.what} ({100 * self.share:.0f} %)"


class _Tried(NamedTuple):
    """A cause that is tried: its share of the misfit, the misfit beside it, amount, whitened derivative, and
    the step of the numbers beside it."""

    effect: Effect
    share: float
    left: float
    amount: float
    direction: np.ndarray
    step: np.ndarray

    @property
    def name(self) -> str:
        """Of the cause."""
        return self.effect.name

    @property
    def text(self) -> str:
        """What it would have to be, with a true minus sign and a space before a per cent sign."""
        return re.sub(r"(?<!\w)-(?=\d)", "−", re.sub(r"(?<=\d)%", " %", self.effect.text(self.amount)))

    def cause(self, best: Posterior, what: str, deviations: float = math.nan) -> Cause:
        """The same in words, where the fit ended."""
        free = np.flatnonzero(best.free)
        change = best.problem.gradient(best.x)[np.ix_(free, free)] @ self.step[: len(free)]
        shifts = dict(zip([best.problem.names[i] for i in free], change.tolist(), strict=True))
        off = self.amount * self.effect.unit
        return Cause(self.name, what, self.share, self.left, off, shifts, deviations)


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
    every = [*own, *effects(end)]
    end = replace(end, residual=end.residual - end.by_inputs @ end.z)  # as stated
    columns = np.column_stack([end.columns, *(each.column for each in every[len(own) :])])
    noises = [each.noise for each in end.problem.motions]
    rows = Whitened(end.residual, columns, end.samples.lengths, noises).rows
    scored = [*_scored(rows, int(end.free.sum()), every), *_line(end, rows)]
    scored.sort(key=lambda each: -each.share)
    causes = _named(end, [each for each in scored if each.share > LEAST])
    line = _named(end, [each for each in scored if each.name == LINE])
    named = not line or any(each.name == LINE for each in causes)
    return causes if named else [*causes[: TOLD - 1], *line]


def required_effect(best: Posterior) -> Cause | None:
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
    likely = [*_scored(np.vstack([whitened.rows, np.column_stack(prior)]), n, known)]
    if not likely:
        return None
    first = max(likely, key=lambda each: each.share)
    gain = best.whitened.likelihood().minus_two_log - best.whitened.adding(first.effect.column).minus_two_log
    off = math.sqrt(max(gain, 0.0))
    return first.cause(best, first.text, off) if off > EFFECTS else None


def _scored(rows: Floats, n: int, known: Sequence[Effect]) -> Iterator[_Tried]:
    """Each cause within its bounds with its score; rows hold residual, n derivatives by what is free, and one
    by each cause."""
    size = np.maximum(np.linalg.norm(rows[:, 1 : 1 + n], axis=0), np.finfo(float).tiny)
    own, others = rows[:, 1 : 1 + n] / size, np.delete(rows, np.s_[1 : 1 + n], axis=1)
    taken = np.linalg.lstsq(own, others, rcond=None)[0]
    left, *columns = (others - own @ taken).T
    whole = max(float(left @ left), np.finfo(float).tiny)
    charge = (n + 1) * math.log(len(left))
    for j, (each, column) in enumerate(zip(known, columns, strict=True), 1):
        length = max(float(np.linalg.norm(column)), np.finfo(float).tiny)
        score = float(column @ left) / length
        amount, share = -score / length, score**2 / whole
        if each.bounds[0] <= amount <= each.bounds[1]:
            step = -amount * taken[:, j] / size
            yield _Tried(each, share, whole * (1 - share) + charge, amount, column / length, step)


def _line(end: Posterior, rows: Floats) -> Iterator[_Tried]:
    """A line in the residual; it shifts no number to first order."""
    frequency, share = line_in(end)
    if frequency:
        n = int(end.free.sum())
        left = without_own(rows[:, 1 : 1 + n], rows[:, :1])[:, 0]
        first = symbol_of(end.problem.names[0])
        what = f"a line at {frequency:.1f} Hz, as of a table or an upper part that swings, which bias {first}"
        rest = float(left @ left) * (1 - share) + (n + 1) * math.log(len(left))
        line = Effect(LINE, np.empty(0), lambda _: what)
        yield _Tried(line, share, rest, frequency, np.zeros(len(left)), np.zeros(n))


def _named(end: Posterior, tried: list[_Tried]) -> list[Cause]:
    """The first ones, each name once, with those of other names that no run tells from it."""
    causes, told = list[Cause](), set[str]()
    for each in tried:
        if each.name in told or len(causes) == TOLD:
            continue
        told.add(each.name)
        twins = dict[str, _Tried]()
        for other in tried:
            if other.name not in told and abs(other.direction @ each.direction) > ALIKE:
                twins.setdefault(other.name, other)
        told |= {*twins}
        among = [*twins.values()][: TWINS - 1]
        what = ", or ".join([each.text, *(f"{other.name}, {other.text}" for other in among)])
        cause = each.cause(end, what)
        changes = [cause.shifts, *(other.cause(end, "").shifts for other in among)]
        most = {name: max((shifts[name] for shifts in changes), key=abs) for name in cause.shifts}
        causes.append(cause._replace(shifts=most))
    return causes


def _effect_of(source: Input, laboratory: Laboratory) -> Effect:
    """An input that is off by standard uncertainties."""
    unit = f" {source.unit}" if source.unit != "1" else ""
    twin = ", or a tilt of the base" if source.name == "com_offset_m" else ""
    if source.name == "response_ms":  # what it does grows with its square

        def slower(by: float) -> str:
            moved = laboratory.moved(source, by).lasers[source.owner]
            return f"{moved.response_ms:.1f} ms of {source.owner}"

        return Effect(source.name, np.empty(0), slower, unit=source.u)

    def text(by: float) -> str:
        return f"{by * source.u:+.2g}{unit} of {source.owner}{twin}"

    farthest = FARTHEST_M / source.u if source.unit == "m" else FARTHEST
    return Effect(source.name, np.empty(0), text, (-farthest, farthest), source.u)


def _tried(inputs: tuple[Input, ...]) -> Iterator[Input]:
    """The inputs that may be off; also the offset of the centre of mass, which does what a tilt does."""
    names = {each.name for each in inputs}
    yield from (each for each in inputs if each.u > 0 and each.name not in ("levelled_deg", "mass_kg"))
    owners = [each.owner for each in inputs if each.name == "height_m"]
    if owners and "com_offset_m" not in names:
        yield Input(owners[0], "com_offset_m", OFFSET_M, False)
