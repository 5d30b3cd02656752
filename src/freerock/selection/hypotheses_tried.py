"""The search for the hypotheses that explain a run: best first, by the numbers that they free.

`allowed_hypotheses` lists what may be tried. Every run is fitted with the laws of the campaign as the paper
has them. The search goes on to neighbours: other kinematics, one damping more, a contact width, tilt, edge
radius or release that is not as stated. All that free as many numbers are tried together: a quick fit screens
each, and those near the best are fitted in full. The search ends where something explains the run, no untried
hypothesis frees as few numbers, and the derivatives require no other number; or where a law would explain the
run with an input beyond its prior, and no hypothesis with one number more does. Effects beside a law are
tried in `causes`, listed in `unmodelled`.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.against_noise import LOUDNESS, hopeless_from, least_mean_square
from freerock.identification.fit import Fit, fit_record
from freerock.identification.inputs_with_priors import Posterior, at_end
from freerock.identification.significance_levels import NEAR, REJECTS, TELLS, TRACE
from freerock.identification.start import posed
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS, PER_RUN
from freerock.models.laws import CANDIDATES, law_of
from freerock.rotation.laboratory import Input
from freerock.runs.motion import Motion
from freerock.selection.added_uncertainty import (
    beside_all_that_explain,
    beside_all_usable,
    beside_causes,
)
from freerock.selection.allowed_hypotheses import NOT_TRIED, Hypotheses, Hypothesis
from freerock.selection.causes import Cause, ranked, required_effect
from freerock.selection.choice import Choice, Evidence, choose, evidence, plainly
from freerock.selection.quick import (
    Screening,
    asked_later,
    asks_for,
    law_suffices,
    narrowed,
    screen,
    start_from,
)


@dataclass(frozen=True)
class Effort:
    """Which hypotheses are fitted in full, extended or given up; by judgement.

    Parameters
    ----------
    contends : float
        Times the least mean square of a round, up to which a hypothesis is fitted in full.
    beaten : float
        Times the mean square of a hypothesis that explains the run, from which another is given up: the BIC
        would differ by thousands, and a quick fit is within a few per cent of a full one.
    clearly : float
        Chance of the residual of a full fit as noise, below which no hypothesis that leaves more in its quick
        fit is fitted in full: a quick fit is within a few per cent of a full one.
    promises : float
        Share of its parent's misfit beyond the noise that a hypothesis may leave to be extended: what acts on
        the block explains most of what a law lacks without it.
    rivals : float
        Times the least misfit of hypotheses that free no more numbers, up to which one is extended. Set on 81
        truths of the confusion atlas under white noise, on the way to which hypotheses left up to 39 times;
        on 81 under mains 100 names 78, and 10 names 75.
    widened : int
        Priors besides the contact width: more of them pass for anything.
    edges_m : (float, float)
        Radii from which quick fits start: from the one, edges as the other are not found.
    freed : float
        Times its prior uncertainty, by which an input that a fit pulls is freed.
    one_radius : float
        Relative difference up to which two ends have come to the same edges.
    rigid : float
        Share of the largest stiffness of a fit, from which a bed is not told from a rigid one.
    """

    contends: float = 1.25
    beaten: float = 4.0
    clearly: float = 1e-8
    promises: float = 0.5
    rivals: float = 100.0
    widened: int = 2
    edges_m: tuple[float, float] = (5e-4, 2e-3)
    freed: float = 10.0
    one_radius: float = 0.1
    rigid: float = 0.1


EFFORT = Effort()


class RuledOut(NamedTuple):
    """What a quick fit leaves: in words, and its ε_θ, NaN where it looked at a part of the run only."""

    reason: str
    epsilon_theta: float


@dataclass
class Identified:
    """What was found of one run.

    Parameters
    ----------
    fits : dict of str to Fit
        By candidate.
    ruled_out : dict of str to RuledOut
        Candidates of which a quick fit says that a full one is of no use.
    errors : dict of str to FreerockError
        Candidates to which the data allow no fit.
    untried : dict of str to str
        Candidates that the search never came to, and why.
    widened : tuple of str
        Priors that these fits widen (`allowed_hypotheses.WIDENED`).
    alternatives : dict of Hypothesis to Fit
        What explains the run as well with other priors widened, with edges of another radius, or with an
        input beyond its prior.
    before : Fit or None
        That of the selected candidate before its `discrepancy` took up other hypotheses.
    effects : dict of str to Cause
        By candidate, selected from this run alone: the effect that it requires beside it. What that would
        change is part of the `discrepancy` of its fit.
    causes : dict of str to list of Cause
        By candidate, of a run that nothing explains: the causes of its misfit, likewise.
    """

    fits: dict[str, Fit] = field(default_factory=dict)
    ruled_out: dict[str, RuledOut] = field(default_factory=dict)
    errors: dict[str, FreerockError] = field(default_factory=dict)
    untried: dict[str, str] = field(default_factory=dict)
    widened: tuple[str, ...] = ()
    alternatives: dict[Hypothesis, Fit] = field(default_factory=dict)
    before: Fit | None = None
    effects: dict[str, Cause] = field(default_factory=dict)
    causes: dict[str, list[Cause]] = field(default_factory=dict)

    def copied(self) -> "Identified":
        """The same, to which fits may be added."""
        fits, ruled_out, errors = {**self.fits}, {**self.ruled_out}, {**self.errors}
        return replace(self, fits=fits, ruled_out=ruled_out, errors=errors, causes={**self.causes})

    @property
    def explained(self) -> bool:
        """Whether some candidate leaves only noise."""
        return any(evidence(fit).explains for fit in self.fits.values())

    def choice(self, hypotheses: Hypotheses) -> Choice:
        """The candidates that explain the run, and what became of all others."""
        return choose([self._evidence(model, hypotheses) for model in hypotheses.candidates])

    def at_best(self, model: str, block: Block, motion: Motion, hypotheses: Hypotheses) -> Posterior:
        """The linear model where the fit of a candidate ended, at its tolerance."""
        return at_end_of(self.fits[model], block, motion, hypotheses.settings(model, self.widened))

    def _evidence(self, model: str, hypotheses: Hypotheses) -> Evidence:
        if model in self.fits:
            return evidence(self.fits[model])
        if model in self.errors:
            quick = RuledOut(str(self.errors[model]), math.nan)
        else:
            untried = RuledOut(NOT_TRIED + self.untried.get(model, "the search did not come to it"), math.nan)
            quick = self.ruled_out.get(model, untried)
        n = hypotheses.n_freed(model, self.widened)
        return Evidence(model, n, fitted=False, message=quick.reason, epsilon_theta=quick.epsilon_theta)


def at_end_of(fit: Fit, block: Block, motion: Motion, settings: FitSettings) -> Posterior:
    """The linear model where a fit of one run ended, at its tolerance."""
    problem = replace(posed(fit.model, (block,), (motion,), settings), rtol=fit.diagnostics["rtol"])
    return at_end(problem, fit.values, fit.contributions)


def identify_run(block: Block, motion: Motion, hypotheses: Hypotheses) -> Identified:
    """The hypotheses that a run requires.

    Parameters
    ----------
    block : Block
    motion : Motion
        With its noise at rest, where it was seen.
    hypotheses : Hypotheses

    Returns
    -------
    Identified
    """
    search = _Search(block, motion, hypotheses)
    for law in search.hypotheses.always_fitted:
        search.fit(Hypothesis(law))
    while search.fits and (untried := search.worth_trying()):
        search.try_all(untried)
    found = search.found()
    if not found.explained:
        take_up_causes(found, block, motion, search.hypotheses)
    return found


def identify_runs(
    block: Block,
    motions: Mapping[int, Motion],
    hypotheses: Hypotheses,
    alone: Callable[[Block, Motion, Hypotheses], Identified] = identify_run,
) -> dict[int, Identified]:
    """The hypotheses that each run of a record requires.

    `motions` are the runs by number; `alone` identifies a run by itself; all else as in `identify_run`.
    """
    return {number: alone(block, motion, hypotheses) for number, motion in motions.items()}


def take_up_causes(found: Identified, block: Block, motion: Motion, hypotheses: Hypotheses) -> None:
    """The causes of the misfit of each candidate, but of beds that have become rigid; `discrepancy` takes up
    these and the other fits."""
    found.fits |= beside_all_usable(found.fits)
    for model, fit in found.fits.items():
        causes = [] if is_rigid(fit.values) else ranked(found.at_best(model, block, motion, hypotheses))
        if causes:
            found.causes[model] = causes
        moving = [cause for cause in causes if any(cause.shifts.values())]
        if moving and fit.contributions is None:  # else its numbers are those beside inputs that moved
            found.fits[model] = beside_causes(fit, moving, [cause.share for cause in moving])


def is_rigid(values: Mapping[str, float]) -> bool:
    """Whether a bed has become rigid, by its numbers [SI]: a rigid law describes it with fewer."""
    return values.get("k", 0.0) > EFFORT.rigid * PARAMETERS["k"].bounds[1]


def _contends(model: str, found: Identified) -> bool:
    """Whether a candidate may be named for a run, so that its held-out discrepancy counts."""
    return model in found.fits and (evidence(found.fits[model]).explains or not found.explained)


@dataclass
class _Search:
    """What was tried on a run, and what came of it."""

    block: Block
    motion: Motion
    hypotheses: Hypotheses
    fits: dict[Hypothesis, Fit] = field(default_factory=dict)
    others: list[tuple[Hypothesis, Fit]] = field(default_factory=list)  # with edges of another radius
    quick: dict[Hypothesis, Screening] = field(default_factory=dict)
    ruled_out: dict[Hypothesis, RuledOut] = field(default_factory=dict)
    errors: dict[Hypothesis, FreerockError] = field(default_factory=dict)
    lasting: dict[Hypothesis, bool] = field(default_factory=dict)
    effects: dict[Hypothesis, Cause | None] = field(default_factory=dict)

    def rank(self, each: Hypothesis) -> int:
        """How many numbers a hypothesis frees; a release other than measured counts as one more."""
        return self.hypotheses.n_freed(*each) + ("release" in each.widened)

    @property
    def explaining(self) -> dict[Hypothesis, Fit]:
        """Hypotheses that leave only noise; those that widen a prior with no number at a bound, and another
        release only as the later swings bear it out."""
        return {each: fit for each, fit in self.fits.items() if self._explains(each, fit)}

    def _explains(self, each: Hypothesis, fit: Fit) -> bool:
        if not (evidence(fit).explains and self._known(each, fit)):
            return False
        if "release" in each.widened and each not in self.lasting:
            self.lasting[each] = lasts(each, fit, self.block, self.motion, self.hypotheses)
        return self.lasting.get(each, True)

    @staticmethod
    def _known(each: Hypothesis, fit: Fit, but: Sequence[str] = ()) -> bool:
        """Whether no number of a fit that widens a prior, but some, lies at a bound."""
        known = zip(fit.parameters, np.isfinite(fit.stderr), strict=True)
        return not each.widened or all(is_known for name, is_known in known if name not in but)

    @property
    def _with_inputs(self) -> float:
        """Least rank of hypotheses that leave hardly more than noise with inputs beyond their priors, each of
        which is one number, too."""
        known = {each: evidence(fit) for each, fit in self.fits.items() if fit.success}
        ranks = [
            self.rank(each) + _beyond(self.fits[each])
            for each, own in known.items()
            if own.noise_p > EFFORT.clearly and not own.pulls_p > REJECTS
        ]
        return min(ranks, default=math.inf)

    @property
    def possible(self) -> dict[Hypothesis, Fit]:
        """Those that explain the run, and that no other one rules out."""
        explaining = {each: (fit, evidence(fit)) for each, fit in self.explaining.items()}
        return {
            each: fit
            for each, (fit, own) in explaining.items()
            if not any(other.rules_out(own) for _, other in explaining.values())
        }

    def worth_trying(self) -> list[Hypothesis]:
        """The next hypotheses to try together; none where the search is at its end."""
        possible = self.possible
        beside = [each for parent in self._extended() for each in self._neighbours(parent)]
        if not possible:
            beside += self._beside_the_best()
        untried = [
            each
            for each in dict.fromkeys(beside)
            if len(each.widened) <= EFFORT.widened and not {each} & {*self.fits, *self.quick, *self.errors}
        ]
        if not possible:
            least = min(map(self.rank, untried), default=0)
            return [each for each in untried if self.rank(each) == least <= self._with_inputs]
        smallest = min(map(self.rank, possible))
        best = min(possible, key=self._bic)
        alike = [each for each in possible if each.widened == best.widened]
        named = min(alike, key=lambda each: (self.rank(each), possible[each].bic))
        now = [each for each in untried if self.rank(each) <= smallest]
        now += [
            each for each in untried if each.widened == named.widened and self.rank(each) == self.rank(named)
        ]
        return [*dict.fromkeys(now)] or self._one_more(named, untried)

    def _one_more(self, named: Hypothesis, untried: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Hypotheses with one number more that the derivatives of the named one require.

        Where the width alone is required, that is the only one. Where a rival is named, or a width or a
        damping is required beside others, or an effect that no law has, these are all that free one number
        more: beside pivoting corners a tilt has been required where the contact was narrower, and drag where
        edges were rounded.
        """
        one_more = [each for each in untried if self.rank(each) == self.rank(named) + 1]
        required = self._required(named) if one_more else ()
        if required == ("width",):
            wider = self.hypotheses.of(replace(CANDIDATES[named.model], width=True).name, named.widened)
        elif not required:
            return []
        elif {"width", "damping", "effect"} & {*required} or named.model not in self.hypotheses.always_fitted:
            return one_more
        else:
            wider = self.hypotheses.of(named.model, (*named.widened, required[0]))
        return [each for each in one_more if each == wider]

    def _required(self, named: Hypothesis) -> tuple[str, ...]:
        fit = self.fits[named]
        if not {*PER_RUN} <= {*fit.parameters}:
            return ()
        required = asks_for(self._end_of(named)) or (("effect",) if self._effect(named) else ())
        lacking = fit.diagnostics.get("added_damping", 0.0)
        charged = math.log(fit.diagnostics["effective_samples"])
        return required if lacking <= 0 or lacking**2 < charged else (*required, "damping")

    def _end_of(self, each: Hypothesis) -> Posterior:
        return at_end_of(self.fits[each], self.block, self.motion, self.hypotheses.settings(*each))

    def _effect(self, each: Hypothesis) -> Cause | None:
        """What no law has and a fit requires."""
        if each not in self.effects:
            self.effects[each] = required_effect(self._end_of(each))
        return self.effects[each]

    def _bic(self, each: Hypothesis) -> float:
        """The criterion of a fit, with the effect that it requires where one was looked for."""
        fit, effect = self.fits[each], self.effects.get(each)
        charged = math.log(fit.diagnostics["effective_samples"])
        return fit.bic - (effect.deviations**2 - charged if effect else 0.0)

    def _extended(self) -> list[Hypothesis]:
        """Hypotheses whose neighbours are tried: the laws, and what took most of its parents' misfit.

        Also the best one where it was given up: of a part of the run it is not known what it took.
        """
        explaining, noise = self.explaining, least_mean_square(self.motion)
        little = (LOUDNESS.louder**2 - 1) * noise
        left = {each: max(self._mean_square(each) - noise, little) for each in {**self.fits, **self.quick}}
        whole, best = self._whole, min(left, key=lambda each: left[each], default=None)
        kept = []
        for each, own in left.items():
            parents = [left[other] for other in self._parents(each) if other in left]
            beside = [left[other] for other in whole if self.rank(other) <= self.rank(each)]
            near = own <= EFFORT.rivals * min(beside, default=math.inf)
            promises = near and own <= max(EFFORT.promises * min(parents, default=math.inf), little)
            if each in explaining or promises or (each == best and each not in whole):
                kept.append(each)
        return kept

    def _neighbours(self, each: Hypothesis) -> Iterable[Hypothesis]:
        """What may be tried beside a hypothesis that was; nothing beside a bed that has become rigid."""
        end = self.fits.get(each) or self.quick[each]
        return () if is_rigid(end.values) else self.hypotheses.neighbours(each)

    def _beside_the_best(self) -> list[Hypothesis]:
        """What frees as many numbers as the best, with other kinematics: inputs may take up so much of the
        wrong ones that the right ones without a width or tilt seem hopeless."""
        least = min(map(self._mean_square, self._whole), default=0.0)
        near = [each for each in self._whole if self._mean_square(each) <= EFFORT.contends * least]
        pairs = [(each, beside) for each in near for beside in self._neighbours(each)]
        return [beside for each, beside in pairs if self.rank(beside) == self.rank(each)]

    @property
    def _whole(self) -> list[Hypothesis]:
        """Hypotheses of which the misfit of the whole run is known."""
        quick = (each for each, end in self.quick.items() if not end.given_up)
        return [*dict.fromkeys([*self.fits, *quick])]

    def _parents(self, each: Hypothesis) -> list[Hypothesis]:
        """Hypotheses, tried or not, to which one adds a number."""
        widened = [each.widened, *(tuple({*each.widened} - {prior}) for prior in each.widened)]
        every = [self.hypotheses.of(model, of) for model in self.hypotheses.candidates for of in widened]
        return [
            other
            for other in dict.fromkeys(every)
            if self.rank(other) < self.rank(each) and each in self.hypotheses.neighbours(other)
        ]

    def try_all(self, untried: Sequence[Hypothesis]) -> None:
        """Quick fits of all; full ones of those near the best, where that is not far above the noise.

        A quick fit that is far above the noise on the first swings is not followed.
        """
        explaining = [self._mean_square(each) for each in self.explaining]
        hopeless_square = hopeless_from([self.motion])
        beyond = EFFORT.beaten * max(explaining) if explaining else hopeless_square
        # how near a rigid block comes is reported
        rigid = max(beyond, NEAR * float(np.nanmean(self.motion.theta**2)))
        starts = dict[Hypothesis, list[Screening]]()
        for each in untried:
            bar = beyond if law_of(each.model).is_foundation or each.widened else rigid
            try:
                starts[each] = self._screened(each, bar)
            except FreerockError as error:
                self.errors[each] = error
        ends = {each: min(of, key=lambda end: end.mean_square) for each, of in starts.items()}
        self.quick |= ends
        least = min([*explaining, *(end.mean_square for end in ends.values())], default=math.inf)
        worth = bool(explaining) or least <= hopeless_square
        for each, end in sorted(ends.items(), key=lambda item: item[1].mean_square):
            if worth and end.mean_square <= EFFORT.contends * least:
                near = (start for start in starts[each] if start.mean_square <= EFFORT.contends * least)
                self.fit(each, [start.values for start in near])
                worth = each not in self.fits or evidence(self.fits[each]).noise_p > EFFORT.clearly
            else:
                self.ruled_out[each] = _ruled_out(end, self.motion, least)
        for each in [each for each in untried if each in self.explaining]:
            self._reduce(each)

    def _reduce(self, larger: Hypothesis) -> None:
        """The fits of smaller hypotheses from where one that frees a number more explains the run: from
        elsewhere they may end in another minimum, or where no input moves."""
        found = self.fits[larger]
        known = found.contributions
        moved = dict(zip(known.inputs, known.moved.tolist(), strict=True)) if known else {}
        for each in self._parents(larger):
            start: tuple[dict[str, float], dict[Input, float]] | None = found.values, moved
            if each in self.explaining:
                continue
            if CANDIDATES[larger.model].width > CANDIDATES[each.model].width:
                start = narrowed(self._end_of(larger))
            if start is not None:
                self._fit_from(each, *start)

    def _fit_from(self, each: Hypothesis, start: Mapping[str, float], moved: Mapping[Input, float]) -> None:
        """A further fit of a hypothesis, kept if it is the better one."""
        settings = self.hypotheses.settings(*each)
        try:
            fit = fit_record(each.model, self.block, [self.motion], settings, start=start, moved=moved)
        except FreerockError:
            return
        ends = [end for end in (self.fits.get(each), fit) if end is not None]
        self.fits[each] = min(ends, key=lambda end: (not end.success, end.diagnostics["mean_square"]))
        if self.fits[each] is fit:
            for of in (self.errors, self.lasting, self.ruled_out, self.effects):
                of.pop(each, None)

    def _screened(self, each: Hypothesis, beyond: float) -> list[Screening]:
        """Quick fits of a hypothesis; of rounded edges from a small and a large radius."""
        start = self._start(each)
        starts: list[Mapping[str, float] | None] = [start]
        if start is not None and "edge_radius" in each.widened and "edge_radius" not in start:
            starts = [start | {"edge_radius": radius} for radius in EFFORT.edges_m]
        settings = self.hypotheses.settings(*each)
        return [screen(each.model, self.block, self.motion, settings, start, beyond) for start in starts]

    def _start(self, each: Hypothesis) -> dict[str, float] | None:
        tried: dict[Hypothesis, Fit | Screening] = {**self.quick, **self.fits}
        return start_from(each, [end for h, end in tried.items() if each in self.hypotheses.neighbours(h)])

    def fit(self, each: Hypothesis, starts: Sequence[Mapping[str, float] | None] = (None,)) -> None:
        """The best full fit from some starts.

        Edges have minima beside minima: of a short run of 0.7 mm one at 0.30 and one at 0.65 mm, 0.4 apart in
        the BIC and 2 % in k. Those that do as well are kept aside.
        """
        ends, failed, settings = list[Fit](), list[FreerockError](), self.hypotheses.settings(*each)
        for start in starts:
            if start is not None and any(_have_one_radius(start, end.values) for end in ends):
                continue
            try:
                ends.append(fit_record(each.model, self.block, [self.motion], settings, start=start))
            except FreerockError as error:
                failed.append(error)
        if not ends:
            self.errors[each] = failed[0]
            return
        ends.sort(key=lambda end: (not evidence(end).explains, end.bic))
        self.fits[each] = ends[0]
        self.others += [(each, end) for end in ends[1:] if not _have_one_radius(end.values, ends[0].values)]

    def found(self) -> Identified:
        """The best hypothesis, all candidates that widen the same priors, and what does as well otherwise."""
        explaining = self.explaining
        best = min(explaining, key=self._bic, default=self._nearest())
        for law in self.hypotheses.always_fitted:
            each = self.hypotheses.of(law, best.widened)
            if each not in self.fits and each not in self.errors:
                self.fit(each, [self._start(each)])
        if not explaining:
            self._fit_nearest()
        alike = {model: self.hypotheses.of(model, best.widened) for model in self.hypotheses.candidates}

        def told(of: Mapping[Hypothesis, Any]) -> dict[str, Any]:
            return {model: of[each] for model, each in alike.items() if each in of}

        found = Identified(told(self.fits), told(self.ruled_out), told(self.errors), widened=best.widened)
        tried = {*found.fits, *found.ruled_out, *found.errors}
        found.untried = {
            model: self._why_untried(each) for model, each in alike.items() if model not in tried
        }
        bar = self._bic(best) + TELLS if explaining else -math.inf
        for each, fit in (*explaining.items(), *self.others):
            named = found.fits.get(each.model)
            if fit.bic <= bar and evidence(fit).explains and fit is not named:
                kept = found.alternatives.get(each, fit)
                farther = abs(fit.value[0] - explaining[best].value[0]) > abs(
                    kept.value[0] - explaining[best].value[0]
                )
                found.alternatives[each] = fit if farther else kept
        for each in [*found.alternatives]:
            if any(
                other.model == each.model and {*other.widened} < {*each.widened}
                for other in found.alternatives
            ):
                del found.alternatives[each]
        selected = found.choice(self.hypotheses).selected
        if explaining and selected in found.fits:
            found.alternatives |= self._with_freed_inputs(alike[selected], bar)
            found.before = found.fits[selected]
        found.fits |= beside_all_that_explain(found.fits, tuple(found.alternatives.values()))
        if found.before:
            effect = self._effect(alike[selected])
            if effect:
                found.effects[selected] = effect
                found.fits[selected] = beside_causes(found.fits[selected], [effect], [1.0])
        return found

    def _why_untried(self, each: Hypothesis) -> str:
        """Why the search ended before it came to a hypothesis."""
        possible = [self.rank(other) for other in self.possible]
        if self.rank(each) > min(possible, default=math.inf):
            return "a smaller candidate explains the run"
        if not possible and self.rank(each) > self._with_inputs:
            return "a smaller candidate explains the run with an input beyond its prior"
        return "no candidate that it extends has a good enough fit"

    def _nearest(self) -> Hypothesis:
        """Where nothing explains a run: of the fits that leave about the least, one that widens least. A
        release that it does not widen may lie at a bound."""
        usable = [
            each
            for each, fit in self.fits.items()
            if fit.success and self._known(each, fit, () if "release" in each.widened else PER_RUN)
        ]
        left = {each: self._mean_square(each) for each in usable}
        near = [each for each in left if left[each] <= EFFORT.contends * min(left.values())]
        return min(near, key=lambda each: (len(each.widened), left[each]), default=Hypothesis(""))

    def _with_freed_inputs(self, selected: Hypothesis, bar: float) -> dict[Hypothesis, Fit]:
        """Hypotheses with fewer numbers than the selected one that explain the run as well where the input
        with the largest pull is freed, too."""
        found, explaining = dict[Hypothesis, Fit](), self.explaining
        for each, fit in self.fits.items():
            known = fit.contributions
            if self.rank(each) >= self.rank(selected) or known is None or known.most_pulled is None:
                continue
            source, pull = known.inputs[known.most_pulled], known.pulls[known.most_pulled]
            named = (fit.bic <= bar and each in explaining) or source.name == "response_ms"
            at_most = fit.bic - pull**2  # the most that it may gain
            within = replace(fit, diagnostics=fit.diagnostics | {"pulls_p": 1.0, "added_damping": 0.0})
            if named or at_most > bar or not self._explains(each, within):
                continue
            try:
                freed = freeing(source, fit, self.block, self.motion, self.hypotheses.settings(*each))
            except FreerockError:
                continue
            if freed.success and evidence(freed).explains and freed.bic <= bar:
                found[Hypothesis(each.model, (*each.widened, source.label))] = freed
        return found

    def _fit_nearest(self) -> None:
        """Where nothing explains a run: the smallest candidate that comes near the best, in full."""
        fitted = [self._mean_square(each) for each, fit in self.fits.items() if fit.success]
        plain = {each: end.mean_square for each, end in self.quick.items() if not each.widened}
        least = min([*fitted, *plain.values()], default=math.inf)
        near = [each for each in self.ruled_out if plain.get(each, math.inf) <= EFFORT.contends * least]
        if near and not any(square <= EFFORT.contends * least for square in fitted):
            each = min(near, key=lambda one: (self.rank(one), plain[one]))
            self.fit(each, [self.quick[each].values])
            if each in self.fits:
                self.ruled_out.pop(each)

    def _mean_square(self, each: Hypothesis) -> float:
        """Mean square of the residual and the pulls, with the inputs moved [rad²]."""
        if each not in self.fits:
            return self.quick[each].mean_square
        return self.fits[each].diagnostics["mean_square"]


def freeing(source: Input, fit: Fit, block: Block, motion: Motion, settings: FitSettings) -> Fit:
    """The fit of a run with the prior of an input widened by `EFFORT.freed`.

    The BIC charges it as that prior does before: as a freed contact width, by what it was known to.
    """
    laboratory, found = motion.laboratory, fit.contributions
    assert laboratory is not None and found is not None
    wide = replace(source, u=EFFORT.freed * source.u)
    inputs = tuple(wide if each == source else each for each in laboratory.inputs)
    moved = dict(zip(found.inputs, found.moved.tolist(), strict=True))
    moved[wide] = moved.pop(source) / EFFORT.freed
    motion = replace(motion, laboratory=replace(laboratory, inputs=inputs))
    freed = fit_record(fit.model, block, [motion], settings, start=fit.values, moved=moved)
    return replace(freed, bic=freed.bic + fit.diagnostics["charged"] - freed.diagnostics["charged"])


def _beyond(fit: Fit) -> int:
    """How many inputs a fit moves beyond their priors; at least one."""
    pulls = fit.contributions.pulls if fit.contributions is not None else np.zeros(0)
    return max(1, int(np.sum(np.abs(pulls) > TRACE)))


def _ruled_out(end: Screening, motion: Motion, least: float) -> RuledOut:
    """Mean square of a quick fit over the best of its round; if it is near that, over the noise."""
    is_near = end.mean_square <= EFFORT.contends * least
    of, square = ("the noise", least_mean_square(motion)) if is_near else ("the best", least)
    reason = f"a quick fit leaves {plainly(end.mean_square / square)} times the mean square of {of}"
    if end.given_up:
        return RuledOut(reason, math.nan)
    return RuledOut(reason, float(np.mean(end.residual**2) / np.nanmean(motion.theta**2)))


def _have_one_radius(values: Mapping[str, float], other: Mapping[str, float]) -> bool:
    """Whether two ends have come to the same edges."""
    radii = (each.get("edge_radius", 0.0) for each in (values, other))
    return math.isclose(*radii, rel_tol=EFFORT.one_radius)


def lasts(each: Hypothesis, fit: Fit, block: Block, motion: Motion, hypotheses: Hypotheses) -> bool:
    """Whether the later swings require what a hypothesis frees beside the release.

    Parameters
    ----------
    each : Hypothesis
        One that widens the release.
    fit : Fit
        Of the run under it.
    block : Block
    motion : Motion
        The run.
    hypotheses : Hypotheses
        Those of the campaign.
    """
    lasting = {*each.widened} - {"release"}
    if CANDIDATES[each.model].is_rival and law_suffices(block, motion, hypotheses.settings, fit):
        return False
    return not lasting or lasting <= asked_later(block, motion, hypotheses.settings(each.model), fit)
