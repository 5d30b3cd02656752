"""Impacts under a fitted law: restitution as the root of a ratio of true energies.

On a compliant base a tilted block has sunk, moves up and down and has pressed the foundation: its height
alone is not its energy, and the restitution from two peaks of a rigid block is not the ratio of energies.

An error of the law adds to the uncertainty of restitution by energy. A law that leaves more than the noise
has energies of swings wrong. Two traces of it are seen. The duration of a swing over that of the law at the
same height tells by what share a couple is wrong. A δ that alternates, more so the lower the swing, tells
that swings have another zero than the block at rest: a bed is softer on one side, or a base slips. The
scatter takes this up, so that it counts under a law that agrees with the noise, too, where chance does not
explain it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from freerock.arrays import Floats
from freerock.config.processing import RUN_LIMITS, ImpactLimits
from freerock.identification.significance_levels import REJECTS
from freerock.models.block import Block
from freerock.models.block_on_bed import energy
from freerock.models.laws import CANDIDATES, GEOMETRIC, MODELS, Foundation, Rules, law_of
from freerock.models.simulate import Solver, simulate
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import View, view_of
from freerock.runs.impacts import Impacts, find_impacts
from freerock.runs.release import lowered

if TYPE_CHECKING:
    from freerock.identification.fitted import Fit
    from freerock.runs.motion import Motion

RTOL, STEP_S = 1e-9, 5e-4  # of the integrator; between instants of the modelled motion [s]
RELATIVE, SHARE = 1e-4, 0.1  # steps: of a number, and of the uncertainty of an input
LEAST = 1e-3  # of a force that the motion hardly determines, where it would become negative
BEYOND = 2.0  # times the time between the last two impacts, for the top after the last one
FEWEST = 3  # impacts of a run with a δ, which tell its zero
APART = 0.25  # of the time between two impacts, by which a measured one may lie off that of the law


class ImpactEnergy(NamedTuple):
    """Of each impact of a modelled motion, in the order of time, shape (n_impacts,).

    Parameters
    ----------
    time_s : ndarray
        Since the release, on the clock of the fit [s].
    restitution, u_total : ndarray
        √(energy at the top after the impact over that at the top before it), and its total uncertainty. NaN
        of impacts without a further top.
    """

    time_s: Floats
    restitution: Floats
    u_total: Floats


def impact_energy(
    fit: "Fit",
    block: Block,
    time_s: Floats,
    *,
    debonding: str = GEOMETRIC.debonding,
    view: View | None = None,
    laboratory: Laboratory | None = None,
) -> ImpactEnergy:
    """Restitution by energy of the impacts of a fitted motion.

    At a top θ̇ is zero, and the energy has these parts only: of rising and sinking, of weight, and in the
    foundation (`freerock.models.block_on_bed.energy`). The uncertainty is to first order that of the fitted
    numbers and of the scatter δ of the impacts, and that of the inputs, which reach it through the numbers
    and by themselves. The energy before the first impact is that of the block when the finger has left; the
    total uncertainty has what the finger may have taken (`runs.release.lowered`). A rigid block's r of impact
    i is r (1 + δ_i).

    Parameters
    ----------
    fit : Fit
        Of one run, to be used.
    block : Block
    time_s : ndarray, shape (n_impacts,)
        Impacts that are requested, each the nearest of the law [s].
    debonding : str
        The rule of the fit.
    view : View, optional
        What the sensor made of the motion.
    laboratory : Laboratory, optional
        What is known of the inputs.
    """
    asked, delta = np.asarray(time_s, float), fit.scatter.delta
    if not law_of(fit.model).is_foundation:
        return _rigid(fit, asked)
    law = _Law(fit.model, debonding, view, asked, float(fit.curve.theta_model[0]))
    nominal = law.of(block, fit.values, delta)

    def slope(values: Mapping[str, float], by: Floats, step: float) -> Floats:
        return (law.of(block, values, by).restitution - nominal.restitution) / step

    columns = [
        slope({**fit.values, name: value * (1 + RELATIVE)}, delta, RELATIVE * value)
        if value and name != "t0"
        else np.zeros(asked.size)
        for name, value in fit.values.items()
    ]
    by_numbers = np.nan_to_num(np.reshape(columns, (len(fit.values), asked.size)).T)
    contributions = fit.uncertainty.contributions
    noise = fit.uncertainty.covariance - contributions.values @ contributions.values.T
    total = np.sum(by_numbers @ np.nan_to_num(noise) * by_numbers, axis=1)
    own = nominal.number < delta.size
    if own.any():  # an impact has a δ of its own, which the others hardly move
        at = nominal.number[own]
        by_delta = slope(dict(fit.values), delta + RELATIVE, RELATIVE)[own]
        both = 2 * np.sum(by_numbers[own] * fit.scatter.with_parameters[:, at].T, axis=1)
        total[own] += by_delta * (by_delta * np.diag(fit.scatter.covariance)[at] + both)
    unknown = nominal.restitution * fit.scatter.of_record.sigma_r  # where the fit has no δ
    total[~own] += unknown[~own] ** 2
    if laboratory is not None:
        for source, shift in zip(contributions.inputs, contributions.values.T, strict=True):
            moved = laboratory.moved({source: SHARE}).block
            there = law.of(moved, _shifted(fit, SHARE * shift), delta).restitution
            total += ((there - nominal.restitution) / SHARE) ** 2
    total += (
        nominal.restitution * (nominal.number == 0) * _taken(block, abs(fit.values.get("theta0", law.theta0)))
    ) ** 2
    return ImpactEnergy(nominal.time_s, nominal.restitution, np.sqrt(np.maximum(total, 0.0)))


def of_measured(time_s: Floats, law_s: Floats) -> NDArray[np.intp]:
    """The impact of the law at each measured one, shape (n_impacts,): the nearest, -1 where none is near.

    Parameters
    ----------
    time_s, law_s : ndarray
        Instants of the measured impacts and of those of the law [s].
    """
    if not len(time_s) or not len(law_s):
        return np.full(len(time_s), -1)
    apart = np.abs(law_s[:, None] - time_s)
    nearest = np.argmin(apart, axis=0)
    gap = APART * np.min(np.diff(law_s), initial=np.inf) if len(law_s) > 1 else np.inf
    near = np.argmin(apart, axis=1)[nearest] == np.arange(len(time_s))
    return np.where(near & (apart.min(axis=0) < max(gap, APART * 0.1)), nearest, -1)


def _rigid(fit: "Fit", asked: Floats) -> ImpactEnergy:
    """r (1 + δ_i) of a rigid block, and its uncertainty."""
    i, r, delta = list(fit.values).index("r"), fit.values["r"], np.zeros(asked.size)
    own, n = np.full(asked.size, fit.scatter.of_record.sigma_r**2), min(asked.size, fit.scatter.delta.size)
    both = np.zeros(asked.size)
    delta[:n], own[:n] = fit.scatter.delta[:n], np.diag(fit.scatter.covariance)[:n]
    both[:n] = fit.scatter.with_parameters[i, :n]
    square = (1 + delta) ** 2 * fit.uncertainty.covariance[i, i] + r**2 * own + 2 * r * (1 + delta) * both
    return ImpactEnergy(asked, r * (1 + delta), np.sqrt(np.maximum(square, 0.0)))


def _shifted(fit: "Fit", shift: Floats) -> dict[str, float]:
    """The numbers of a fit, shifted; a force or a length that the motion hardly determines stays above 0."""
    above = {*MODELS[fit.model], "width", "edge_radius"}
    return {
        name: max(value + by, LEAST * value) if name in above else value + by
        for (name, value), by in zip(fit.values.items(), shift.tolist(), strict=True)
    }


def _taken(block: Block, height: float) -> float:
    """Half the share of a rigid block's energy that a finger may take at the release from an angle [rad]."""
    height = min(height, 0.99 * block.theta_cr)
    slope = math.sin(block.theta_cr - height)
    energy = 2 * math.sin(height / 2) * math.sin(block.theta_cr - height / 2)
    return lowered(block.p**2 * slope, RUN_LIMITS.finger_s) * slope / energy / 2


class _Found(NamedTuple):
    """Instants [s] and restitutions of the impacts requested, and their numbers from 0."""

    time_s: Floats
    restitution: Floats
    number: NDArray[np.intp]


@dataclass(frozen=True)
class _Law:
    """A candidate, the instants of the impacts that are asked of it [s]; a held release angle [rad]."""

    model: str
    debonding: str
    view: View | None
    asked: Floats
    theta0: float

    def of(self, block: Block, values: Mapping[str, float], delta: Floats) -> _Found:
        """What a block shows under such numbers."""
        nothing = np.full(self.asked.size, np.nan)
        if not self.asked.size:
            return _Found(nothing, nothing, np.empty(0, np.intp))
        candidate, turning = CANDIDATES[self.model], block.as_found(values)
        rules, foundation = Rules(self.debonding, candidate.kinematics), Foundation.of(values)
        theta0, t0 = values.get("theta0", self.theta0), values.get("t0", 0.0)
        if self.view is not None:
            theta0 = replace(self.view, block=block).released(theta0, turning, foundation)
        last = self.asked[-1] - t0
        before = self.asked[-2] - t0 if self.asked.size > 1 else 0.0
        time = np.arange(0.0, last + BEYOND * (last - before), STEP_S)
        law: dict[str, object] = {
            name: values[name] for name in (*MODELS[candidate.law], "tilt") if name in values
        }
        law |= {"impacts": delta} if delta.size else {}
        motion = simulate(candidate.law, turning, law, time, theta0=theta0, rules=rules, solver=Solver(RTOL))  # type: ignore[arg-type]
        impacts = motion.impacts[motion.impacts < time[-1]]
        # the release and the top after each impact: the sample before it, its share of the step from there
        tops, shares, rate = [0], [0.0], motion.theta_rate
        for first, end in pairwise(np.searchsorted(time, np.append(impacts, time[-1])).tolist()):
            turned = np.flatnonzero(rate[first : end - 1] * rate[first + 1 : end] <= 0)
            if not len(turned):
                break
            i = first + int(turned[len(turned) // 2])
            tops.append(i)
            shares.append(rate[i] / (rate[i] - rate[i + 1]) if rate[i] != rate[i + 1] else 0.0)
        if len(tops) < 2:
            return _Found(nothing, nothing, np.zeros(self.asked.size, np.intp))
        at = np.append(tops, np.add(tops, 1))
        states = [each[at] for each in (motion.z_cb, motion.z_cb_rate, motion.theta, motion.theta_rate)]
        stored = energy(turning, foundation, states[0], states[1], states[2], states[3], rules)
        left, right = np.split(np.asarray(stored), 2)
        at_tops = left + np.array(shares) * (right - left)
        restitution = np.full(len(impacts), np.nan)
        restitution[: len(at_tops) - 1] = np.sqrt(at_tops[1:] / at_tops[:-1])
        nearest = np.argmin(np.abs(impacts[:, None] + t0 - self.asked), axis=0)
        return _Found(impacts[nearest] + t0, restitution[nearest], nearest)


NEAR = 2  # swings to either side, over which the share of a swing is averaged
HIGHEST = 0.99  # of the critical angle: no swing lasts for ever


def energies_of_record(
    fits: "Mapping[int, Mapping[str, Fit]]",
    motions: "Mapping[int, Motion]",
    block: Block,
    limits: ImpactLimits,
    debonding: str,
) -> dict[int, dict[str, ImpactEnergy]]:
    """Restitution by energy at the impacts of each fit that is to be used, by run and candidate.

    Parameters
    ----------
    fits : mapping of int to mapping of str to Fit
        By run of a record and candidate, with the impacts of the modelled motion.
    motions : mapping of int to Motion
        As seen, by run.
    block : Block
    limits : ImpactLimits
        Of the impacts that are seen.
    debonding : str
        The rule of the fits.
    """
    found = dict[int, dict[str, ImpactEnergy]]({number: {} for number in fits})
    seen = {
        number: find_impacts(
            each.time_s, each.theta, each.sigma_theta, block, theta0=each.theta0, limits=limits
        )
        for number, each in motions.items()
    }
    for name in {name: None for own in fits.values() for name in own}:
        own = {number: of_run[name] for number, of_run in fits.items() if name in of_run}
        plain = dict[int, ImpactEnergy]()
        for number, fit in own.items():
            at, view, known = motions[number].laboratory, motions[number].view, fit.uncertainty.contributions
            if not fit.success or fit.impacts is None or at is None:
                continue
            if known.moved.any():  # with the inputs where the fit has moved them
                at = at.moved(dict(zip(known.inputs, known.moved.tolist(), strict=True)))
                view = view_of([*at.lasers.values()], at.block)
            plain[number] = impact_energy(
                fit, at.block, fit.impacts.time_s, debonding=debonding, view=view, laboratory=at
            )
        for number, each in with_law_error(plain, own, seen, block).items():
            found[number][name] = each
    return found


def with_law_error(
    energies: Mapping[int, ImpactEnergy],
    fits: "Mapping[int, Fit]",
    measured: Mapping[int, Impacts],
    block: Block,
) -> dict[int, ImpactEnergy]:
    """Restitution by energy whose u holds the error of the law.

    Parameters
    ----------
    energies : mapping of int to ImpactEnergy
        Of one candidate by run of a record, at the impacts of the modelled motion.
    fits : mapping of int to Fit
        With the impacts of the modelled motion.
    measured : mapping of int to Impacts
        As seen.
    block : Block
    """
    drawn = {run: fits[run] for run in energies if fits[run].impacts is not None}
    wrong = [run for run, fit in drawn.items() if not fit.evidence.agrees]
    shares = {run: _shares(drawn[run], measured[run], block) for run in wrong}
    seen = np.concatenate([np.zeros(0), *shares.values()])
    usual, zeros = _root_mean_square(seen), _zeros(drawn, block)
    usual_zero = _root_mean_square(np.array([zeros[run] for run in wrong if run in zeros]))
    found = dict(energies)
    for run, fit in drawn.items():
        r = energies[run].restitution
        after = np.full(r.size, usual if run in wrong else 0.0)
        known = shares.get(run, np.zeros(0))[: r.size]
        after[: known.size] = known
        before = np.append(after[:1], after[:-1])
        zero = zeros.get(run, usual_zero if run in wrong else 0.0)
        by_zero = zero * _per_zero(fit, block)[: r.size]
        of_law = r * np.sqrt((before**2 + after**2) / 4 + by_zero**2)
        found[run] = energies[run]._replace(u_total=np.hypot(energies[run].u_total, of_law))
    return found


def _root_mean_square(values: Floats) -> float:
    """Root mean square of some values; 0 without any."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _shares(fit: "Fit", measured: Impacts, block: Block) -> Floats:
    """Share of its energy that each swing between two impacts has more or less than the law has it.

    Root mean squares over neighbours, shape (n_swings,). A swing of a rigid block that rises to θ lasts as
    acosh(1/(1 - θ/θ_cr)) (Housner 1963, equation 8); a couple that is larger by a share a makes it shorter by
    a/2.
    """
    assert fit.impacts is not None
    n = min(len(measured.time_s), len(fit.impacts.time_s))
    if n < 2:
        return np.zeros(0)
    lasts, seen = (np.diff(each.time_s[:n]) for each in (fit.impacts, measured))
    tops = (np.abs(each.peak_after_rad[: n - 1]) / block.theta_cr for each in (fit.impacts, measured))
    rigid, seen_rigid = (np.arccosh(1 / (1 - np.minimum(each, HIGHEST))) for each in tops)
    square = (2 * np.log(seen / lasts * rigid / seen_rigid)) ** 2
    near = [np.nanmean(square[max(i - NEAR, 0) : i + NEAR + 1]) for i in range(n - 1)]
    return np.asarray(np.sqrt(np.nan_to_num(near)))


def _per_zero(fit: "Fit", block: Block) -> Floats:
    """What a zero that is off adds to ln r of each impact [rad⁻¹], shape (n_impacts,).

    Half the relative slopes of the energy at the top before and at that after it: they lie on two sides.
    """
    assert fit.impacts is not None
    tops = np.abs(np.append(fit.values.get("theta0", fit.curve.theta_model[0]), fit.impacts.peak_after_rad))
    tops = np.minimum(tops, HIGHEST * block.theta_cr)
    slopes = np.sin(block.theta_cr - tops) / (2 * np.sin(tops / 2) * np.sin(block.theta_cr - tops / 2))
    return np.asarray((slopes[:-1] + slopes[1:]) / 2)


def _zeros(fits: "Mapping[int, Fit]", block: Block) -> dict[int, float]:
    """By how much the swings of each run may have another zero than the block at rest [rad].

    Of a least squares of δ: a constant and the zero of each run, a slope over the logarithm of the height. Of
    a law that leaves more than the noise the root of the squares of the zero and its standard uncertainty, of
    one that agrees the zero where it is beyond chance, else 0. A run with few δ has none.
    """
    rows = dict[int, Floats]()
    for run, fit in fits.items():
        assert fit.impacts is not None
        n = min(fit.scatter.delta.size, fit.impacts.peak_after_rad.size)
        tops, delta = fit.impacts.peak_after_rad[:n], fit.scatter.delta[:n]
        per_zero = np.sign(tops) * _per_zero(fit, block)[:n]
        by = 1 / np.hypot(fit.scatter.u_delta[:n], fit.scatter.of_record.sigma_r)
        # what a zero, a constant and the logarithm of the height add to each δ, and δ itself, over its u
        own = np.column_stack([per_zero, np.ones(n), np.log(np.abs(tops)), delta]) * by[:, None]
        known = own[np.isfinite(own).all(axis=1)]
        if len(known) >= FEWEST:
            rows[run] = known
    n, lengths = len(rows), [len(own) for own in rows.values()]
    free = sum(lengths) - (2 * n + 1)
    if free <= 0:
        return {}
    zero, one, height, seen = np.vstack([*rows.values()]).T
    of_run = np.eye(n)[np.repeat(np.arange(n), lengths)]
    design = np.column_stack([of_run * zero[:, None], of_run * one[:, None], height])
    best, *_ = np.linalg.lstsq(design, seen, rcond=None)
    variances = np.maximum(np.diag(np.linalg.pinv(design.T @ design)), 0.0)
    scatter, found = float(np.sum((seen - design @ best) ** 2)) / free, dict[int, float]()
    for run, value, variance in zip(rows, np.abs(best).tolist(), variances.tolist(), strict=False):
        if fits[run].evidence.agrees:
            t = value / math.sqrt(max(variance * scatter, np.finfo(float).tiny))
            found[run] = value if 2 * stdtr(free, -t) < REJECTS else 0.0
        else:
            found[run] = math.hypot(value, math.sqrt(variance * min(scatter, 1.0)))
    return found
