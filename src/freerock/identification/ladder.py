"""As many candidates as a run asks for: rungs by the numbers they free, few first.

The laws named in the campaign are fitted to every run as the paper has them. A rung of their rivals is
fitted only while nothing smaller explains the run, or what does is surpassed by one of those laws; first each
of its candidates is screened by a quick fit, and only those that come near the best are fitted in full.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.candidates import Ladder, start_for
from freerock.identification.choice import NEAR, TELLS, Choice, Evidence, choose, plainly
from freerock.identification.diagnosis import asks_for
from freerock.identification.fit import Fit, evidence, fit_record
from freerock.identification.holdout import of_other_runs
from freerock.identification.later_swings import asked_later, law_suffices
from freerock.identification.noise import hopeless_from, noise_of
from freerock.identification.problem import Problem, posed
from freerock.identification.screening import Screening, screen
from freerock.identification.swings import tilt_of_swings
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, PER_RUN, law_of
from freerock.runs.motion import Motion

CONTENDS = 1.25  # times the least mean square of a rung, up to which a screened candidate is fitted in full
SCENES = (("release",), ("tilt",), ("edges",))  # of which a run may ask
BOTH = ("release", "tilt")
SEEN = 2.5e-3  # of a tilt as the swings have it [rad]: few swings of a level base show up to that much
# Times the least mean square of a run, from which rivals are asked in another scene; by judgement: what acts
# on the block explains most of what a law lacks without it.
PROMISES = 0.5
# Times the power of the noise, up to which a quick fit in another scene asks for a full one. Set on eight
# records of six mishaps: what explained one left up to 2.7 times, mostly 1.0, what did not 3.0 and more.
FOLLOWED = 4.0
EDGES_M = (5e-4, 2e-3)  # radii from which quick fits start: from the one, edges as the other are not found
ONE_RADIUS = 0.1  # relative difference up to which two ends have come to the same edges
# Times the mean square of a candidate that explains the run, from which a rival is given up; by judgement:
# the BIC would differ by thousands, and a quick fit is within a few per cent of a full one.
BEATEN = 4.0


class LeftOut(NamedTuple):
    """What a quick fit leaves: in words, and its ε_θ, NaN where it looked at a part of the run only."""

    reason: str
    epsilon_theta: float


SMALLER = LeftOut("a smaller candidate explains the run", math.nan)


@dataclass
class Identified:
    """What was found of one run.

    Parameters
    ----------
    fits : dict of str to Fit
        By candidate.
    left_out : dict of str to LeftOut
        Candidates of which a quick fit says that a full one is of no use.
    errors : dict of str to FreerockError
        Candidates to which the data allow no fit.
    scene : tuple of str
        What these fits do not take for granted: "release", that it is as measured, "tilt", that there is
        none, "edges", that they are sharp.
    width_or_edges : bool
        Whether another contact width on sharp edges and rounded edges explain the run alike.
    edge_radius_alike : float
        Largest radius of rounded edges that explain the run as well as what is named [m]; 0 where none other
        do.
    """

    fits: dict[str, Fit] = field(default_factory=dict)
    left_out: dict[str, LeftOut] = field(default_factory=dict)
    errors: dict[str, FreerockError] = field(default_factory=dict)
    scene: tuple[str, ...] = ()
    width_or_edges: bool = False
    edge_radius_alike: float = 0.0

    @property
    def explained(self) -> bool:
        """Whether some candidate leaves only noise."""
        return any(evidence(fit).explains for fit in self.fits.values())

    @property
    def possible(self) -> list[str]:
        """Candidates that leave only noise, and that no other that does surpasses by the BIC."""
        explaining = {name: known for name, fit in self.fits.items() if (known := evidence(fit)).explains}
        least = min((known.bic for known in explaining.values()), default=math.inf)
        return [name for name, known in explaining.items() if known.bic <= least + TELLS]

    def choice(self, ladder: Ladder) -> Choice:
        """The candidates that explain the run, and what became of all others."""
        ladder = ladder.freeing(self.scene)
        return choose([self._evidence(model, ladder) for model in ladder.candidates])

    def at_best(self, model: str, block: Block, motion: Motion, ladder: Ladder) -> tuple[Problem, Floats]:
        """The problem of the fit of a candidate, at its tolerance, and the fitted numbers."""
        settings, fit = ladder.freeing(self.scene).settings(model), self.fits[model]
        problem = replace(posed(model, (block,), (motion,), settings), rtol=fit.diagnostics["rtol"])
        return problem, problem.start_at(fit.values)

    @property
    def settled(self) -> bool:
        """Whether the best of the candidates that leave only noise has no number at a bound."""
        return math.isfinite(least := self.least_bic) and not any(
            fit.bic + TELLS < least and evidence(fit).explains for fit in self.fits.values()
        )

    @property
    def least_bic(self) -> float:
        """Of the candidates that leave only noise, and of which no number lies at a bound."""
        return min(
            (
                fit.bic
                for fit in self.fits.values()
                if evidence(fit).explains and bool(np.isfinite(fit.stderr).all())
            ),
            default=math.inf,
        )

    def _evidence(self, model: str, ladder: Ladder) -> Evidence:
        if model in self.fits:
            return evidence(self.fits[model])
        if model in self.errors:
            quick = LeftOut(str(self.errors[model]), math.nan)
        else:
            quick = self.left_out.get(model, SMALLER)
        n = ladder.n_freed(model)
        return Evidence(model, n, fitted=False, message=quick.reason, epsilon_theta=quick.epsilon_theta)


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
    found = _climbed(_of_laws(block, motion, ladder), block, motion, ladder)
    if found.fits and not found.explained:
        found = _elsewhere(found, block, motion, ladder) or found
    found = _on_edges(found, block, motion, ladder)
    while freer := next(_freer(found, block, motion, ladder), None):
        found = freer
    return found


def _freer(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Iterator[Identified]:
    """What does better than the named candidate with something freed that it asks for.

    Rounded edges that do as well are noted.
    """
    for other in _with_asked(found, block, motion, ladder):
        other = _on_edges(other, block, motion, ladder)
        if not other.settled or other.least_bic > found.least_bic + TELLS:
            continue
        if other.least_bic < found.least_bic:
            if _lasts(other, block, motion, ladder):
                yield other
        elif "edges" not in found.scene:
            radius = other.fits[other.choice(ladder).selected].values.get("edge_radius", 0.0)
            found.edge_radius_alike = max(found.edge_radius_alike, other.edge_radius_alike, radius)


def _with_asked(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Iterator[Identified]:
    """Rivals that free one number more, where a rival is named or a width is asked for; then the scene with
    what is asked for most.

    A rival that leaves no more than noise need not be the right one: beside pivoting corners a tilt has been
    asked for where the contact was narrower.
    """
    asked, level = _asked(found, block, motion, ladder), ladder.freeing(found.scene)
    if asked and (CANDIDATES[chosen := found.choice(ladder).selected].is_rival or "width" in asked):
        n = level.n_freed(chosen) + 1
        yield _climbed(replace(found, fits={**found.fits}), block, motion, level, at_least=n)
    for name in [name for name in asked if name != "width"][:1]:
        freeing = ladder.freeing(scene := (*found.scene, name))
        if name == "edges":
            _, edges = _of_scene(block, motion, freeing, scene, (level, found))
            yield _all_of(edges, block, motion, ladder)
        else:
            yield _climbed(_of_laws(block, motion, freeing, scene), block, motion, freeing)


def _on_edges(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified:
    """What does better where another contact width is named: that, or the law on rounded edges.

    The two are alike: beside a freed width the data hardly ask for edges, nor where the law as the paper has
    it is far off. So it is fitted with them.
    """
    chosen = found.choice(ladder).selected if found.explained else ""
    scene, level = (*found.scene, "edges"), ladder.freeing(found.scene)
    if not chosen or not CANDIDATES[chosen].width or ladder.freeing(scene) == level:
        return found
    cases = (CANDIDATES[chosen].law, *law_of(chosen).cases)
    laws = replace(found, fits={model: fit for model, fit in found.fits.items() if model in cases})
    _, edges = _of_scene(block, motion, ladder.freeing(scene), scene, (level, laws))
    if not edges.settled or edges.least_bic > found.least_bic + TELLS:
        return found
    alike = edges.least_bic > found.least_bic - TELLS
    if edges.least_bic < found.least_bic and _lasts(edges, block, motion, ladder):
        found = _all_of(edges, block, motion, ladder)
    return replace(found, width_or_edges=alike)


def _lasts(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> bool:
    """Whether the later swings ask for what is beside a freed release, as they do of base and corners."""
    if "release" not in found.scene:
        return True
    chosen, lasting = found.choice(ladder).selected, {*found.scene} - {"release"}
    if CANDIDATES[chosen].is_rival and law_suffices(block, motion, ladder.settings, found.fits[chosen]):
        return False
    return not lasting or lasting <= asked_later(block, motion, ladder.settings(chosen), found.fits[chosen])


def _asked(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> tuple[str, ...]:
    """What of base, release and corners the named candidate asks to be freed."""
    chosen = found.choice(ladder).selected if found.explained else ""
    fit = found.fits.get(chosen)
    if fit is None or not {*PER_RUN} <= {*fit.parameters}:
        return ()
    asked = asks_for(*found.at_best(chosen, block, motion, ladder))
    any_width = any(CANDIDATES[model].width for model in ladder.candidates)
    return tuple(name for name in asked if name != "width" or any_width)


def _elsewhere(level: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified | None:
    """The candidates that explain a run in a scene of which less is taken for granted; None without any.

    The laws come first; their rivals only in the scene that promises most, or on a base whose tilt is seen.
    Of scenes in which a law explains the run, that which does best is kept.
    """
    tried = []
    for scenes in (SCENES, (BOTH,)):
        for scene in scenes:
            freeing = ladder.freeing(scene)
            if freeing != ladder:
                tried.append(_of_scene(block, motion, freeing, scene, (ladder, level)))
        settled = [found for _, found in tried if found.settled and _lasts(found, block, motion, ladder)]
        if settled:
            return _all_of(min(settled, key=lambda each: each.least_bic), block, motion, ladder)
    least = min([each for each, _ in tried], default=math.inf)
    near = [found for each, found in tried if each <= CONTENDS * least]
    if least > PROMISES * _least_square(level, motion):
        seen = abs(tilt_of_swings(block, motion)) > SEEN
        near = [found for _, found in tried if seen and found.scene == ("tilt",)]
    if not near:
        return None
    found = _all_of(near[0], block, motion, ladder)
    return found if found.settled and _lasts(found, block, motion, ladder) else None


def _all_of(near: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified:
    """All laws in a scene, of which some are fitted, and the rivals that the run asks for there."""
    freeing = ladder.freeing(near.scene)
    laws = _of_laws(block, motion, freeing, near.scene, (freeing, near))
    return replace(_climbed(laws, block, motion, freeing), edge_radius_alike=near.edge_radius_alike)


def _of_scene(
    block: Block, motion: Motion, ladder: Ladder, scene: Sequence[str], known: tuple[Ladder, Identified]
) -> tuple[float, Identified]:
    """The laws near the noise in a scene, and the least mean square that quick fits leave of any [rad²].

    Quick fits start from what is `known` without the scene, with edges of either of `EDGES_M`.
    """
    starts = [{"edge_radius": radius} for radius in EDGES_M] if "edges" in scene else [{}]
    found, least = Identified(scene=tuple(scene)), math.inf
    for model, fit in known[1].fits.items():
        settings = ladder.settings(model)
        if CANDIDATES[model].is_rival or law_of(model).cases:
            continue
        if settings == known[0].settings(model):
            found.fits[model] = fit
            continue
        ends = list[Screening]()
        for start in starts:
            try:
                ends.append(screen(model, block, motion, settings, fit.values | start))
            except FreerockError:
                break
        least = min([least, *(end.mean_square for end in ends)])
        near = [end.values for end in ends if end.mean_square <= FOLLOWED * noise_of(motion).variance]
        _fit_from(near, model, block, motion, ladder, found)
    return min(least, _least_square(found, motion)), found


def _fit_from(
    starts: Sequence[Mapping[str, float]],
    model: str,
    block: Block,
    motion: Motion,
    ladder: Ladder,
    found: Identified,
) -> None:
    """The best full fit from some ends of quick ones; edges of another radius that do as well are noted.

    Edges have minima beside minima: of a short run of 0.7 mm one at 0.30 and one at 0.65 mm, 0.4 apart in the
    BIC and 2 % in k.
    """
    ends = list[Fit]()
    for start in starts:
        if any(_have_one_radius(start, end.values) for end in ends):
            continue
        _fit(model, block, motion, ladder, found, start)
        if model in found.errors:
            break
        ends.append(found.fits[model])
    if ends:
        found.errors.pop(model, None)
        found.fits[model] = best = min(ends, key=lambda end: (not evidence(end).explains, end.bic))
        alike = [end.values for end in ends if evidence(end).explains and end.bic <= best.bic + TELLS]
        others = [values["edge_radius"] for values in alike if not _have_one_radius(values, best.values)]
        found.edge_radius_alike = max([found.edge_radius_alike, *others])


def _have_one_radius(values: Mapping[str, float], other: Mapping[str, float]) -> bool:
    """Whether two ends have come to the same edges."""
    radii = (each.get("edge_radius", 0.0) for each in (values, other))
    return math.isclose(*radii, rel_tol=ONE_RADIUS)


def _of_laws(
    block: Block,
    motion: Motion,
    ladder: Ladder,
    scene: Sequence[str] = (),
    known: tuple[Ladder, Identified] | None = None,
) -> Identified:
    """The laws of the campaign as the paper has them; those fitted so already are `known`."""
    found = Identified(scene=tuple(scene))
    for model in ladder.candidates:
        if CANDIDATES[model].is_rival or law_of(model).cases:
            continue
        if known and model in known[1].fits and known[0].settings(model) == ladder.settings(model):
            found.fits[model] = known[1].fits[model]
        else:
            _fit(model, block, motion, ladder, found)
    return found


def _climbed(
    found: Identified, block: Block, motion: Motion, ladder: Ladder, at_least: int = 0
) -> Identified:
    """The laws with the rivals that the run asks for, and with all that free up to `at_least` numbers."""
    quick = dict[str, Screening]()
    for n, rung in groupby(ladder.candidates, key=ladder.n_freed):
        if n > at_least and any(ladder.n_freed(model) < n for model in found.possible):
            break
        rivals = [model for model in rung if model not in found.fits and model not in found.errors]
        quick |= _climb(rivals, block, motion, ladder, found)
    if not found.explained:
        _nearest(quick, block, motion, ladder, found)
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
    found = {number: replace(each, fits={**each.fits}) for number, each in singly.items()}
    for model in ladder.candidates:
        fits = {number: each.fits[model] for number, each in found.items() if _contends(model, each)}
        settings = {number: ladder.freeing(found[number].scene).settings(model) for number in fits}
        for number, epsilon in of_other_runs(model, block, motions, fits, settings).items():
            found[number].fits[model] = replace(fits[number], epsilon_holdout_runs=epsilon)
    return found


def _contends(model: str, found: Identified) -> bool:
    """Whether a candidate may be named for a run, so that its held-out discrepancy counts."""
    return model in found.fits and (evidence(found.fits[model]).explains or not found.explained)


def _climb(
    rivals: Sequence[str], block: Block, motion: Motion, ladder: Ladder, found: Identified
) -> dict[str, Screening]:
    """One rung: quick fits of all rivals, full ones of those that come near the best.

    A quick fit that is far above the noise on the first swings is not followed. Where the best is far above,
    none is fitted in full; all quick fits are given back.
    """
    explaining = [_mean_square(fit, motion) for fit in found.fits.values() if evidence(fit).explains]
    beyond = BEATEN * max(explaining) if explaining else hopeless_from([motion])
    rigid = max(beyond, NEAR * float(np.nanmean(motion.theta**2)))  # how near a rigid block comes is told
    quick: dict[str, Screening] = {}
    for model in rivals:
        try:
            start = start_for(model, {**found.fits, **quick})
            bar = beyond if law_of(model).is_foundation else rigid
            quick[model] = screen(model, block, motion, ladder.settings(model), start, bar)
        except FreerockError as error:
            found.errors[model] = error
    least = min([*explaining, *(end.mean_square for end in quick.values())], default=math.inf)
    bar = FOLLOWED * noise_of(motion).variance if found.scene else hopeless_from([motion])
    hopeless = not explaining and least > bar
    for model, end in sorted(quick.items(), key=lambda item: item[1].mean_square):
        first_hope = not explaining and end.mean_square == least
        if not hopeless and (first_hope or end.mean_square <= CONTENDS * least):
            _fit(model, block, motion, ladder, found, end.values)
        else:
            found.left_out[model] = _left_out(end, motion, least)
    return quick


def _nearest(
    quick: Mapping[str, Screening], block: Block, motion: Motion, ladder: Ladder, found: Identified
) -> None:
    """Where nothing explains a run: the smallest candidate that comes near the best, in full."""
    fitted = [_mean_square(fit, motion) for fit in found.fits.values() if fit.success]
    least = min([*fitted, *(end.mean_square for end in quick.values())], default=math.inf)
    near = [model for model in found.left_out if quick[model].mean_square <= CONTENDS * least]
    if near and not any(mean_square <= CONTENDS * least for mean_square in fitted):
        model = min(near, key=lambda name: (ladder.n_freed(name), quick[name].mean_square))
        _fit(model, block, motion, ladder, found, quick[model].values)
        if model in found.fits:
            found.left_out.pop(model)


def _left_out(end: Screening, motion: Motion, least: float) -> LeftOut:
    """What a quick fit leaves, beside the least mean square of its rung."""
    times = plainly(math.sqrt(end.mean_square / least))
    reason = f"a quick fit leaves {times} times the residual of the best"
    if end.given_up:
        return LeftOut(reason, math.nan)
    return LeftOut(reason, float(np.mean(end.residual**2) / np.nanmean(motion.theta**2)))


def _fit(
    model: str,
    block: Block,
    motion: Motion,
    ladder: Ladder,
    found: Identified,
    start: Mapping[str, float] | None = None,
) -> None:
    try:
        fit = fit_record(model, block, [motion], ladder.settings(model), start=start)
        found.fits[model] = fit
    except FreerockError as error:
        found.errors[model] = error


def _least_square(found: Identified, motion: Motion) -> float:
    """Least mean square residual of the laws as the paper has them [rad²]."""
    laws = [fit for model, fit in found.fits.items() if fit.success and not CANDIDATES[model].is_rival]
    return min((_mean_square(fit, motion) for fit in laws), default=math.inf)


def _mean_square(fit: Fit, motion: Motion) -> float:
    """Mean square residual of the samples that count [rad²]."""
    counts = motion.time_s >= motion.fit_start_s
    return float(np.nanmean(fit.residual[counts] ** 2))
