"""A base off level, another release, rounded edges: freed where a run asks for them.

Fits take the base for level, its edges for sharp and the release for measured. What a run does not take for
granted is its scene.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from freerock.errors import FreerockError
from freerock.identification.candidates import Ladder
from freerock.identification.choice import TELLS
from freerock.identification.diagnosis import asks_for
from freerock.identification.fit import Fit, evidence
from freerock.identification.identified import Identified
from freerock.identification.later_swings import asked_later, law_suffices
from freerock.identification.noise import noise_of
from freerock.identification.rungs import CONTENDS, FOLLOWED, climbed, fit_into, least_square, of_laws
from freerock.identification.screening import Screening, screen
from freerock.identification.swings import tilt_of_swings
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, PER_RUN, law_of
from freerock.runs.motion import Motion

SCENES = (("release",), ("tilt",), ("edges",))  # of which a run may ask
BOTH = ("release", "tilt")
SEEN = 2.5e-3  # of a tilt as the swings have it [rad]: few swings of a level base show up to that much
# Times the least mean square of a run, from which rivals are asked in another scene; by judgement: what acts
# on the block explains most of what a law lacks without it.
PROMISES = 0.5
EDGES_M = (5e-4, 2e-3)  # radii from which quick fits start: from the one, edges as the other are not found
ONE_RADIUS = 0.1  # relative difference up to which two ends have come to the same edges


def elsewhere(level: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified | None:
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
    if least > PROMISES * least_square(level, motion):
        seen = abs(tilt_of_swings(block, motion)) > SEEN
        near = [found for _, found in tried if seen and found.scene == ("tilt",)]
    if not near:
        return None
    found = _all_of(near[0], block, motion, ladder)
    return found if found.settled and _lasts(found, block, motion, ladder) else None


def freer(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Iterator[Identified]:
    """What does better than the named candidate with something freed that it asks for.

    Where sharp and rounded edges do as well, it is noted.
    """
    for other in _with_asked(found, block, motion, ladder):
        other = on_edges(other, block, motion, ladder)
        if not other.settled or other.least_bic > found.least_bic + TELLS:
            continue
        rounded = "edges" in other.scene and "edges" not in found.scene
        if other.least_bic < found.least_bic:
            if _lasts(other, block, motion, ladder):
                other.sharp_alike = rounded and found.least_bic <= other.least_bic + TELLS
                yield other
        elif rounded:
            named = other.choice(ladder).selected
            radii = other.fits[named].values["edge_radius"], other.edge_radii_alike.get(named, 0.0)
            found.edge_radii_alike[found.choice(ladder).selected] = max(radii)


def _with_asked(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Iterator[Identified]:
    """Rivals that free one number more, where a rival is named or a width is asked for; then the scene with
    what is asked for most.

    A rival that leaves no more than noise need not be the right one: beside pivoting corners a tilt has been
    asked for where the contact was narrower.
    """
    asked, level = _asked(found, block, motion, ladder), ladder.freeing(found.scene)
    if asked and (CANDIDATES[chosen := found.choice(ladder).selected].is_rival or "width" in asked):
        n = level.n_freed(chosen) + 1
        yield climbed(found.copied(), block, motion, level, at_least=n)
    for name in [name for name in asked if name != "width"][:1]:
        freeing = ladder.freeing(scene := (*found.scene, name))
        if name == "edges":
            _, edges = _of_scene(block, motion, freeing, scene, (level, found))
            yield _all_of(edges, block, motion, ladder)
        else:
            yield climbed(of_laws(block, motion, freeing, scene), block, motion, freeing)


def on_edges(found: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified:
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
    asked = asks_for(found.at_best(chosen, block, motion, ladder))
    any_width = any(CANDIDATES[model].width for model in ladder.candidates)
    return tuple(name for name in asked if name != "width" or any_width)


def _all_of(near: Identified, block: Block, motion: Motion, ladder: Ladder) -> Identified:
    """All laws in a scene, of which some are fitted, and the rivals that the run asks for there."""
    freeing = ladder.freeing(near.scene)
    laws = of_laws(block, motion, freeing, near.scene, (freeing, near))
    return replace(climbed(laws, block, motion, freeing), edge_radii_alike=near.edge_radii_alike)


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
    return min(least, least_square(found, motion)), found


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
        fit_into(model, block, motion, ladder, found, start)
        if model in found.errors:
            break
        ends.append(found.fits[model])
    if ends:
        found.errors.pop(model, None)
        found.fits[model] = best = min(ends, key=lambda end: (not evidence(end).explains, end.bic))
        alike = [end.values for end in ends if evidence(end).explains and end.bic <= best.bic + TELLS]
        others = [values["edge_radius"] for values in alike if not _have_one_radius(values, best.values)]
        found.edge_radii_alike |= {model: max(others)} if others else {}


def _have_one_radius(values: Mapping[str, float], other: Mapping[str, float]) -> bool:
    """Whether two ends have come to the same edges."""
    radii = (each.get("edge_radius", 0.0) for each in (values, other))
    return math.isclose(*radii, rel_tol=ONE_RADIUS)
