"""Which law the runs of a record need: a choice among candidates that had the same freedom.

Where a candidate leaves no more than the noise of the sensor, the evidence decides: -2 ln L with the numbers
and nuisances charged. Where none does, laws are compared by how well they predict the swings of a run whose
record's other runs they were fitted to.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from freerock.identification.fitted import Fit
from freerock.identification.goodness import louder
from freerock.identification.significance_levels import TELLS
from freerock.models.laws import MODEL_LABELS
from freerock.selection.candidates import contains, n_numbers
from freerock.selection.prediction import compared, errors_of_swings

Status = Literal["selected", "also_possible", "rejected", "not_fitted"]
Level = Literal["noise", "repeatability", "rejected", "none"]
Criterion = Literal["evidence", "prediction", "none"]


@dataclass(frozen=True)
class ChoiceSettings:
    """When data tell two laws apart where none leaves only noise; by judgement.

    Parameters
    ----------
    near : float
        Times the least residual, up to which candidates are compared by prediction.
    significant : float
        Chance of a difference in prediction, below which two laws are told apart.
    repeatable : float
        Share of what the scatter of the impacts does to a run, up to which a residual is small beside it.
    scatters : float
        σ_r up to which impacts of a block scatter: more is an error of the law or of the reading.
    """

    near: float = 3.0
    significant: float = 0.01
    repeatable: float = 0.3
    scatters: float = 0.05


CHOICE = ChoiceSettings()


@dataclass(frozen=True)
class Judged:
    """What becomes of a candidate.

    Parameters
    ----------
    model : str
    status : str
        "selected", "also_possible", "rejected" or "not_fitted".
    reason : str
        Why, in words.
    minus_two_log : float
        -2 ln of the evidence of all runs over that of the selected candidate; NaN if not fitted.
    n_parameters : int
    residual_over_noise : float
        Largest of the runs.
    p_prediction : float
        Chance of its difference in prediction from the selected one; NaN where it was not compared.
    """

    model: str
    status: Status
    reason: str
    minus_two_log: float = math.nan
    n_parameters: int = 0
    residual_over_noise: float = math.nan
    p_prediction: float = math.nan


@dataclass(frozen=True)
class Choice:
    """The law that the runs of a record need.

    Parameters
    ----------
    selected : str
        "" where no fit is to be used.
    level : str
        "noise" (it leaves no more than the noise), "repeatability" (what it leaves is small beside the
        scatter of the impacts), "rejected" (more), "none".
    criterion : str
        What decided: "evidence" or "prediction".
    reason : str
        In one sentence.
    judged : tuple of Judged
        All candidates, in their order.
    """

    selected: str
    level: Level
    criterion: Criterion
    reason: str
    judged: tuple[Judged, ...]

    @property
    def explained(self) -> bool:
        """Whether the selected law explains the runs, to the noise or to their repeatability."""
        return self.level in ("noise", "repeatability")

    @property
    def also_possible(self) -> tuple[str, ...]:
        """Candidates that the data can't tell from the selected one."""
        return tuple(each.model for each in self.judged if each.status == "also_possible")


Fits = Mapping[str, Mapping[int, Fit]]


def choose(
    fits: Fits, missing: Mapping[str, str], ruled_out: Mapping[str, str] = MappingProxyType({})
) -> Choice:
    """The law that the runs of a record need.

    Parameters
    ----------
    fits : mapping of str to mapping of int to Fit
        By candidate and run; all candidates were fitted to the same runs.
    missing : mapping of str to str
        Why other candidates were not fitted.
    ruled_out : mapping of str to str, optional
        Why candidates were fitted that the first swings reject: they are no choice where another one leaves
        no more than the noise. Where none does, that noise is no measure, and they are compared as all are.
    """
    usable = {name: own for name, own in fits.items() if all(fit.success for fit in own.values())}
    failed = [
        (name, next(fit.message for fit in own.values() if not fit.success))
        for name, own in fits.items()
        if name not in usable
    ]
    left_out = [
        Judged(name, "not_fitted", why, n_parameters=n_numbers(name))
        for name, why in (*failed, *missing.items())
    ]
    if not usable:
        return Choice("", "none", "none", "no fit is to be used", tuple(left_out))
    agree = [name for name, own in usable.items() if all(fit.evidence.agrees for fit in own.values())]
    good = [name for name in agree if name not in ruled_out] or agree
    found = _by_evidence(usable, good) if good else _by_prediction(usable)
    beside = {name: ruled_out[name] for name in agree if name not in good}
    judged = (replace(each, reason=beside.get(each.model, each.reason)) for each in found[4])
    return Choice(*found[:4], (*judged, *left_out))


def _over_noise(own: Mapping[int, Fit]) -> float:
    return max(fit.evidence.residual_over_noise for fit in own.values())


def _by_evidence(fits: Fits, good: Sequence[str]) -> "tuple[str, Level, Criterion, str, tuple[Judged, ...]]":
    """Of the candidates that leave only noise, the data tell apart what differs by `TELLS`.

    Among the others the least numbers win, then the evidence. A candidate that holds the selected one as a
    case is needless beside it, unless its evidence is better.
    """
    value = dict[str, float]()
    for name, own in fits.items():  # σ_r is charged where there is scatter
        scatter = next(iter(own.values())).scatter.of_record
        charged = math.log(max(scatter.n_impacts, 1.0)) if scatter.sigma_r else 0.0
        value[name] = sum(fit.evidence.minus_two_log for fit in own.values()) + charged
    best = min(value[name] for name in good)
    near = [name for name in good if value[name] <= best + TELLS]
    selected = min(near, key=lambda name: (n_numbers(name), value[name]))
    judged = []
    for name, own in fits.items():
        apart = value[name] - value[selected]
        status: Status = "rejected"
        if name == selected:
            status, why = "selected", "it leaves only noise, with the best evidence of those that do"
            if len(near) > 1:
                why = "the fewest numbers among those that the data can't tell apart"
        elif name not in good:
            why = f"its residual is {_over_noise(own):.3g} times the noise"
        elif name not in near:
            why = f"−2 ln L is {value[name] - best:.0f} higher"
        elif contains(name, selected) and apart >= 0:
            why = f"needless: it holds {MODEL_LABELS[selected]} as a case"
        else:
            status, why = "also_possible", f"−2 ln L differs by {apart:+.1f}, not significant"
        judged.append(Judged(name, status, why, apart, n_numbers(name), _over_noise(own)))
    beside = [MODEL_LABELS[each.model] for each in judged if each.status == "also_possible"]
    reason = f"{MODEL_LABELS[selected]} leaves no more than the noise of the sensor"
    reason += f"; the data can't tell it from {', '.join(beside)}" if beside else ""
    return selected, "noise", "evidence", reason, tuple(judged)


def _by_prediction(fits: Fits) -> "tuple[str, Level, Criterion, str, tuple[Judged, ...]]":
    """Where none leaves only noise: the likelihood with the residual's own spectrum, then prediction."""
    value = _under_least_residual(fits)
    order = sorted(fits, key=lambda name: value[name])
    least = min(_over_noise(own) for own in fits.values())
    near = [name for name in order if _over_noise(fits[name]) <= CHOICE.near * least]
    n_runs = len(next(iter(fits.values())))
    selected, p, criterion = min(near, key=lambda name: (n_numbers(name), value[name])), {}, "evidence"
    if n_runs > 1 and len(near) > 1:
        criterion = "prediction"
        errors = {name: errors_of_swings(fits[name]) for name in near}
        selected = _best_of(near, errors)
        p = {name: compared(errors[selected], errors[name]).p for name in near if name != selected}
    elif near:
        within = [name for name in near if value[name] <= value[order[0]] + TELLS] or near
        selected = min(within, key=lambda name: (n_numbers(name), value[name]))
    judged = []
    for name, own in fits.items():
        apart, status = value[name] - value[selected], "rejected"
        if name == selected:
            status, why = "selected", "it predicts the swings of other runs best"
            if criterion == "evidence":
                why = "it leaves least, with its numbers charged"
        elif name not in near:
            why = f"its residual is {_over_noise(own) / least:.3g} times that of the best"
        elif criterion == "evidence":
            status = "also_possible" if abs(apart) <= TELLS else "rejected"
            why = f"−2 ln L differs by {apart:+.3g}"
        elif p[name] >= CHOICE.significant:
            status, why = "also_possible", f"it predicts other runs as well (chance {p[name]:.2g})"
        else:
            why = f"it predicts other runs worse (chance {p[name]:.2g})"
        judged.append(
            Judged(name, status, why, apart, n_numbers(name), _over_noise(own), p.get(name, math.nan))  # type: ignore[arg-type]
        )
    level: Level = "repeatability" if _is_repeatable(fits[selected]) else "rejected"
    beside = [MODEL_LABELS[each.model] for each in judged if each.status == "also_possible"]
    what = "predicts the swings of other runs best" if criterion == "prediction" else "leaves least"
    reason = f"{MODEL_LABELS[selected]} {what}; it leaves {_over_noise(fits[selected]):.3g} times the noise"
    reason += f"; the data can't tell it from {', '.join(beside)}" if beside else ""
    return selected, level, criterion, reason, tuple(judged)  # type: ignore[return-value]


def _under_least_residual(fits: Fits) -> dict[str, float]:
    """-2 ln of the evidence of each candidate under the noise that the best one leaves in each run."""
    value = dict.fromkeys(fits, 0.0)
    for run in next(iter(fits.values())):
        best = min((own[run] for own in fits.values()), key=lambda fit: fit.evidence.residual_over_noise)
        assert best.posterior is not None
        noise = louder(best.posterior.noise, best.posterior.goodness)
        for name, own in fits.items():
            posterior = own[run].posterior
            assert posterior is not None
            value[name] += posterior.minus_two_log(noise)
    return value


def _best_of(names: Sequence[str], errors) -> str:  # type: ignore[no-untyped-def]
    """The candidate that predicts best; among those that are no worse, the one with the least numbers."""
    best = names[0]
    for name in names[1:]:
        if compared(errors[name], errors[best]).ratio < 1:
            best = name
    alike = [
        name
        for name in names
        if name == best or not compared(errors[best], errors[name]).p < CHOICE.significant
    ]
    fewest = min(map(n_numbers, alike))
    return min(
        (name for name in alike if n_numbers(name) == fewest),
        key=lambda name: (name != best, names.index(name)),
    )


def _is_repeatable(own: Mapping[int, Fit]) -> bool:
    """Whether what a law leaves within swings is small beside what the scatter of the impacts does."""
    shares = []
    for fit in own.values():
        posterior = fit.posterior
        if posterior is None or not fit.scatter.delta.size:
            return False
        n = posterior.n_names + posterior.at.inputs.size
        columns = posterior.rows[: len(posterior.residual), n:] * posterior.posed.level
        moved = columns * min(fit.scatter.of_record.sigma_r, CHOICE.scatters)
        by_scatter = float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
        shares.append(float(np.sqrt(np.mean(posterior.residual**2))) / max(by_scatter, 1e-300))
    return float(np.median(shares)) <= CHOICE.repeatable
