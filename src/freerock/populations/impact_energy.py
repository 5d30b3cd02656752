"""Impacts under a fitted law: restitution as a ratio of true energies.

On a compliant base a tilted block has sunk, moves up and down and has pressed the foundation: its height
alone is not its energy, and the restitution from two peaks of a rigid block is not the ratio of energies.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freerock.arrays import Floats
from freerock.config.processing import RUN_LIMITS
from freerock.identification.fit import Fit, ImpactEnergy
from freerock.identification.model_discrepancy import model_discrepancy
from freerock.models.block import Block
from freerock.models.contact import Foundation, energy
from freerock.models.laws import CANDIDATES, GEOMETRIC, MODELS, Rules, law_of
from freerock.models.simulate import Response, Solver, simulate
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.view import View
from freerock.runs.release import lowered


@dataclass(frozen=True)
class EnergySettings:
    """How the motion of a law is sampled, and its numbers moved.

    Parameters
    ----------
    rtol : float
        Of the integrator.
    step_s : float
        Between instants of the modelled motion [s].
    relative : float
        Step of the difference quotients.
    share : float
        Of its uncertainty, by which an input of the laboratory is moved.
    least : float
        Of a force that the motion hardly determines, where it would become negative.
    beyond : float
        Times the time between the last two impacts, for the top after the last one.
    """

    rtol: float = 1e-9
    step_s: float = 5e-4
    relative: float = 1e-4
    share: float = 0.1
    least: float = 1e-3
    beyond: float = 2.0


ENERGY = EnergySettings()


def impact_energy(
    fit: Fit,
    block: Block,
    time_s: Floats,
    *,
    debonding: str = GEOMETRIC.debonding,
    view: View | None = None,
    laboratory: Laboratory | None = None,
) -> ImpactEnergy:
    """Restitution by energy of the impacts of a fitted motion.

    At a top θ̇ is zero, and the energy has these parts only: of rising and sinking, of weight, and in the
    foundation (`freerock.models.contact.energy`). Standard errors are to first order those of the fitted
    numbers, through the law; inputs of the laboratory, such as the width, reach it both through these and by
    themselves. The energy before the first impact is that of the block when the finger has left; the total
    uncertainty has what the finger may have taken of the held block's (`runs.release.lowered`). What a law
    does not explain reaches it as it does the numbers: by what the parts of the run
    make of it (`model_discrepancy`).

    Parameters
    ----------
    fit : Fit
        Of one run, by a law of the foundation, to be used.
    block : Block
    time_s : ndarray, shape (n_impacts,)
        Impacts that are requested, each the nearest of the law [s].
    debonding : str
        The rule of the fit.
    view : View, optional
        What the sensor made of the motion.
    laboratory : Laboratory, optional
        What is known of the inputs, where the fit has their contributions.

    Raises
    ------
    ValueError
        Of a rigid block, whose energies are those of its heights.
    """
    if not law_of(fit.model).is_foundation:
        raise ValueError("a rigid block's restitution by energy is that from its peaks")
    asked = np.asarray(time_s, float)
    law = _Law(fit.model, debonding, view, asked, float(fit.theta_model[0]))
    nominal = law.of(block, fit.values)
    columns = []
    for name, value in fit.values.items():
        if name == "t0" or not value:
            columns.append(np.zeros(asked.size))
            continue
        step = ENERGY.relative * abs(value)
        up, down = (law.of(block, {**fit.values, name: value + side * step}) for side in (1, -1))
        columns.append((up[2] - down[2]) / (2 * step))
    gradient = np.reshape(columns, (len(fit.values), asked.size)).T
    known = np.isfinite(np.diag(fit.covariance))  # one held at a bound has no error
    own = gradient[:, known]
    variance = np.sum(own @ fit.covariance[np.ix_(known, known)] * own, axis=1)
    total = variance + _discrepancy(fit, gradient * known) ** 2
    if laboratory is not None and fit.contributions is not None:
        for source, shift in zip(fit.contributions.inputs, fit.contributions.values.T, strict=True):
            there = law.of(laboratory.moved(source, ENERGY.share).block, _shifted(fit, ENERGY.share * shift))
            total += ((there[2] - nominal[2]) / ENERGY.share) ** 2
    total += (nominal[2] * (nominal[3] == 0) * _taken(block, fit.values.get("theta0", law.theta0))) ** 2
    return ImpactEnergy(*nominal[:3], np.sqrt(variance), np.sqrt(total))


def of_measured(found: ImpactEnergy, time_s: Floats) -> ImpactEnergy:
    """The energies at measured impacts: those of the nearest impact of the law; NaN where it has none.

    Parameters
    ----------
    found : ImpactEnergy
        Of the law's own impacts.
    time_s : ndarray, shape (n_impacts,)
        Of the measured ones, since the release [s].
    """
    if not len(found.time_s) or not len(time_s):
        nothing = np.full(len(time_s), np.nan)
        return ImpactEnergy(time_s, nothing, nothing, nothing, nothing)
    apart = np.abs(np.nan_to_num(found.time_s, nan=np.inf)[:, None] - time_s)
    nearest = np.argmin(apart, axis=0)
    own = np.argmin(apart, axis=1)[nearest] == np.arange(len(time_s))
    numbers = found.speed_m_s, found.restitution, found.stderr, found.u_total
    return ImpactEnergy(time_s, *(np.where(own, each[nearest], np.nan) for each in numbers))


def _shifted(fit: Fit, shift: Floats) -> dict[str, float]:
    """The numbers of a fit, shifted; a force or a length that the motion hardly determines stays above 0."""
    above = {*MODELS[fit.model], "width", "edge_radius"}
    return {
        name: max(value + by, ENERGY.least * value) if name in above else value + by
        for (name, value), by in zip(fit.values.items(), shift.tolist(), strict=True)
    }


def _taken(block: Block, theta0: float) -> float:
    """Half the share of a rigid block's energy that a finger may take at the release."""
    height = min(abs(theta0), 0.99 * block.theta_cr)
    slope = math.sin(block.theta_cr - height)
    energy = 2 * math.sin(height / 2) * math.sin(block.theta_cr - height / 2)
    return lowered(block.p**2 * slope, RUN_LIMITS.finger_s) * slope / energy / 2


def _discrepancy(fit: Fit, gradient: Floats) -> Floats:
    """Standard uncertainty of the restitutions as the law does not explain the run, shape (n_impacts,).

    By the parts of the run, as much of it as the numbers have of theirs.

    `gradient` holds their derivatives by the fitted numbers, shape (n_impacts, n_parameters).
    """
    if not np.any(fit.discrepancy > 0):
        return np.zeros(len(gradient))
    of_numbers = model_discrepancy(fit.value, fit.parts)
    told = (of_numbers > 0) & np.isfinite(fit.discrepancy)
    share = float(np.max(fit.discrepancy[told] / of_numbers[told], initial=0.0))
    parts = [part.following(fit.value, gradient) for part in fit.parts]
    return min(share, 1.0) * model_discrepancy(np.zeros(len(gradient)), parts)


@dataclass(frozen=True)
class _Law:
    """A candidate, the instants of the impacts that are asked of it [s]; a held release angle [rad]."""

    model: str
    debonding: str
    view: View | None
    asked: Floats
    theta0: float

    def of(self, block: Block, values: Mapping[str, float]) -> tuple[Floats, Floats, Floats, Floats]:
        """Instants [s], speeds [m/s], restitutions of the impacts requested; how many come before."""
        nothing = np.full(self.asked.size, np.nan)
        if not self.asked.size:
            return nothing, nothing, nothing, nothing
        moved = self._moved(block, values)
        motion, impacts = moved.motion, moved.impacts
        speeds = np.abs(np.interp(impacts, motion.time, motion.theta_rate))
        at = np.append(moved.tops, moved.tops + 1)
        z_cb, z_cb_rate, theta, theta_rate = (
            each[at] for each in (motion.z_cb, motion.z_cb_rate, motion.theta, motion.theta_rate)
        )
        on = moved.block, moved.foundation
        left, right = np.split(np.asarray(energy(*on, z_cb, z_cb_rate, theta, theta_rate, moved.rules)), 2)
        at_tops = left + moved.share * (right - left)
        if len(at_tops) < 2:
            return nothing, nothing, nothing, nothing
        restitution = np.full(len(speeds), np.nan)
        restitution[: len(at_tops) - 1] = np.sqrt(at_tops[1:] / at_tops[:-1])
        nearest = self._nearest(moved, values)
        before = nearest.astype(float)
        times = impacts[nearest] + values.get("t0", 0.0)
        return times, 2 * moved.block.b * speeds[nearest], restitution[nearest], before

    def _nearest(self, moved: "_Moved", values: Mapping[str, float]) -> NDArray[np.intp]:
        """The impact of the law nearest to each that is requested."""
        return np.asarray(
            np.argmin(np.abs(moved.impacts[:, None] + values.get("t0", 0.0) - self.asked), axis=0)
        )

    def _moved(self, block: Block, values: Mapping[str, float]) -> "_Moved":
        candidate, turning = CANDIDATES[self.model], block.as_found(values)
        rules, foundation = candidate.rules(self.debonding), Foundation.of(values)
        theta0, t0 = values.get("theta0", self.theta0), values.get("t0", 0.0)
        if self.view is not None:
            theta0 = replace(self.view, block=block).released(theta0, turning, foundation)
        last = self.asked[-1] - t0
        before = self.asked[-2] - t0 if self.asked.size > 1 else 0.0
        time = np.arange(0.0, last + ENERGY.beyond * (last - before), ENERGY.step_s)
        law = {name: values[name] for name in (*MODELS[candidate.law], "tilt") if name in values}
        motion = simulate(
            candidate.law, turning, law, time, theta0=theta0, rules=rules, solver=Solver(ENERGY.rtol)
        )
        impacts = motion.impacts[motion.impacts < time[-1]]
        return _Moved(turning, foundation, rules, motion, impacts, *_tops(impacts, time, motion.theta_rate))


class _Moved(NamedTuple):
    """A motion of a law: what turned on what, its impacts [s], and the samples before its tops with the share
    of the step from there."""

    block: Block
    foundation: Foundation
    rules: Rules
    motion: Response
    impacts: Floats
    tops: NDArray[np.intp]
    share: Floats


def _tops(impacts: Floats, time: Floats, rate: Floats) -> tuple[NDArray[np.intp], Floats]:
    """The release and the top after each impact: the sample before it, its share of the step from there."""
    tops, shares = [0], [0.0]
    ends = np.searchsorted(time, np.append(impacts, time[-1]))
    for first, last in pairwise(ends.tolist()):
        turned = np.flatnonzero(rate[first : last - 1] * rate[first + 1 : last] <= 0)
        if not len(turned):
            break
        i = first + int(turned[len(turned) // 2])
        tops.append(i)
        shares.append(rate[i] / (rate[i] - rate[i + 1]) if rate[i] != rate[i + 1] else 0.0)
    return np.array(tops), np.array(shares)
