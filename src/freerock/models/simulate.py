"""The one public door to the rocking models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.arrays import Floats
from freerock.models import kernel, series
from freerock.models.block import Block
from freerock.models.block_on_bed import State, lean, static_depth
from freerock.models.ground import GroundMotion, tilted
from freerock.models.housner import housner_motion, housner_swings
from freerock.models.laws import GEOMETRIC, LAWS, Foundation, Law, Rules
from freerock.models.refusals import check_scene
from freerock.models.tangents import LATER_S, Tangents, swings_by_series

OUTCOMES = ("completed", "at_rest", "overturned", "step_limit", "non_finite")
STATISTICS = ("steps", "rejected", "implicit", "evaluations")
NO_RATES, NO_IMPACTS, NO_PASSAGES = np.empty((0, 3)), np.empty(0), np.empty((0, 5))
STILL = GroundMotion(np.empty(0), np.empty((0, 10)))


@dataclass(frozen=True)
class Solver:
    """How accurately and how long to solve.

    Parameters
    ----------
    rtol : float
        Error allowed per step, relative to the amplitude: θ₀ in free rocking, θ_cr on a moving ground.
    max_steps : int
        Steps (or impacts) after which to give up.
    """

    rtol: float = 1e-8
    max_steps: int = 1_000_000


SOLVER = Solver()


@dataclass(frozen=True)
class Response:
    """Simulated motion, sampled at `time`.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        Instants since the release [s].
    theta, theta_rate : ndarray, shape (n_time,)
        Rotation, positive clockwise [rad], and its rate [rad/s]; NaN after a failure or once overturned.
    z_cb, z_cb_rate : ndarray, shape (n_time,)
        Depth of the base centre, positive downward [m], and its rate [m/s].
    contact : ndarray of int8, shape (n_time,)
        0 the whole base, 1 its right part only (θ > 0), -1 its left part only, 2 flight.
    impacts : ndarray
        Instants at which θ changes its sign [s].
    outcome : str
        "completed", "at_rest" (before the last sample), "overturned" (beyond return), "step_limit" or
        "non_finite" (the state or the step size is no longer a usable number).
    statistics : dict
        steps, rejected (steps taken again), implicit (steps taken implicitly), evaluations (of the
        accelerations, or of their series); 0 but for the steps, which are the impacts, in closed form.
    """

    time: Floats
    theta: Floats
    theta_rate: Floats
    z_cb: Floats
    z_cb_rate: Floats
    contact: NDArray[np.int8]
    impacts: Floats
    outcome: str
    statistics: dict[str, int]


def simulate(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time: ArrayLike,
    *,
    theta0: float | State = 0.0,
    base_excitation: GroundMotion | None = None,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
) -> Response:
    """Motion of a rocking block released at t = 0.

    Free rocking of the Housner model from rest is evaluated in closed form; everything else is integrated.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.LAWS`: "housner", "winkler", "hunt_crossley", …
    block : Block
        The block.
    parameters : mapping
        Those of the law by name, as {"k": ..., "c": ...}, in the units of `free_parameters.PARAMETERS`: r
        [1], k [N/m²], c [N·s/m²], λ "lambda" [N·s/m³], …
    time : ndarray, shape (n_time,)
        Increasing instants [s]; before t = 0 the initial state is held.
    theta0 : float or State
        Rotation from which it is released at rest [rad], positive clockwise, in vertical equilibrium; or its
        whole state at t = 0. Rigid blocks, which stand on a corner, do not use the depth in it.
    base_excitation : GroundMotion, optional
        Motion of the ground.
    rules : Rules
        The rule of debonding and the kinematics.
    solver : Solver
        Accuracy, and number of steps after which to give up.

    Raises
    ------
    FreerockError
        Unknown model, missing or negative parameter, time not increasing, and the like.

    Examples
    --------
    >>> import freerock
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> bed, time = {"k": 6.77e6, "c": 2.17e4}, [0.0, 0.1, 0.2, 0.3]
    >>> freerock.simulate("winkler", block, bed, time, theta0=0.17).theta.round(4).tolist()
    [0.17, 0.1552, 0.1037, -0.0066]
    """
    start = theta0 if isinstance(theta0, State) else State(0.0, 0.0, theta0, 0.0)
    instants = check_scene(model, block, parameters, time, start, rules, solver.rtol)
    scene = _Scene(LAWS[model], block, parameters, base_excitation, rules, solver)
    if not scene.law.is_foundation:
        start = State(0.0, 0.0, start.theta, start.theta_rate)
    elif not isinstance(theta0, State):
        start = start._replace(z=static_depth(block, scene.foundation, theta0))
    rates = np.empty((instants.size, 3))
    if scene.is_closed_form and not start.theta_rate:
        theta, outcome, impacts = scene.in_closed_form(start.theta, instants, rates)
        counts = [len(impacts), 0, 0, 0]
    else:
        theta = np.empty(instants.size)
        outcome, *counts, impacts = scene.integrate(start, instants, theta, rates)
    z_cb, z_cb_rate, theta_rate = rates.T
    if scene.law.is_foundation:
        lift = block.flat * np.sin(theta)
        left, right = (np.asarray(depth <= 0, np.int8) for depth in (z_cb - lift, z_cb + lift))  # which is up
        contact = left - right + 2 * left * right
    else:
        contact = np.where(np.isnan(theta), 0.0, np.sign(theta)).astype(np.int8)
        z_cb, z_cb_rate = (
            -block.b * np.abs(np.sin(theta)),
            -block.b * np.sign(theta) * np.cos(theta) * theta_rate,
        )
    statistics = dict(zip(STATISTICS, counts, strict=True))
    return Response(
        instants, theta, theta_rate, z_cb, z_cb_rate, contact, impacts, OUTCOMES[outcome], statistics
    )


def simulate_fitted(
    model: str,
    block: Block,
    values: Mapping[str, float],
    time: Floats,
    *,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    rates: Floats | None = None,
    passages: Floats = NO_PASSAGES,
) -> Floats:
    """Rotation [rad], shape (n_time,), under what a fit finds; an overturned block lies at ±π/2.

    `values` holds the parameters of the model, theta0 [rad] and, where they were freed, the release t0 on the
    clock of `time` [s], the width of the corners and the radius of the edges [m], the tilt of the base
    [rad] and, as "impacts", δ of each impact, after which the rate is multiplied by 1 + δ. Angles count from
    where the block stands at rest. `rates`, if given, receives z_cb, ż_cb and θ̇ [m, m/s, rad/s], shape
    (n_time, 3); of a rigid block θ̇ in its last column is enough. `passages`, shape (n_impacts, 5), receives
    the instant since the release [s], z_cb, ż_cb, 1 + δ and θ̇ after each impact that has a δ. Where its last
    column holds a rate, the impact leaves the block that rate, and δ follows. Arguments are not checked.
    """
    scene = _Scene(LAWS[model], block.as_found(values), values, None, rules, solver)
    later = time - values["t0"] if "t0" in values else time
    if scene.is_closed_form:
        theta, *_ = scene.in_closed_form(values["theta0"], later, rates, passages)
    else:
        theta = np.empty(later.size)
        every = NO_RATES if rates is None else rates if rates.shape[1] > 1 else np.empty((later.size, 3))
        scene, start, stands = scene.released(values["theta0"], later)
        scene.integrate(start, later, theta, every, passages)
        if rates is not None and every is not rates:
            rates[:, 0] = every[:, 2]
        theta = theta - stands if stands else theta
    if theta.size and np.isnan(theta[-1]):
        lost = np.isnan(theta)
        theta[lost] = np.copysign(np.pi / 2, values["theta0"])
        if rates is not None:
            rates[lost] = 0.0
    return theta


def tangents(
    model: str,
    block: Block,
    values: Mapping[str, Any],
    time: Floats,
    motion: tuple[Floats, Floats, Floats],
    *,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    steps: Sequence[float] = (3e-7,),
) -> Tangents:
    """The swings of a motion, with their derivatives by the state after each impact.

    Parameters
    ----------
    values : mapping
        As in `simulate_fitted`; "impacts" holds δ of each impact, shape (n_impacts,).
    motion : (ndarray, ndarray, ndarray)
        Rotation, rates and passages of `simulate_fitted`.
    steps : sequence of float
        Of difference quotients, as shares of the state: one, or one to either side.
    """
    scene = _Scene(LAWS[model], block.as_found(values), values, None, rules, solver)
    theta0, time, (theta, rates, passages) = values["theta0"], time - values.get("t0", 0.0), motion
    passages = passages[passages[:, 0] < time[-1]]
    if scene.is_closed_form:
        return _swings_in_closed_form(scene, theta0, time, theta, rates[:, -1], -steps[0])
    scene, start, stands = scene.released(theta0, time)
    begin = np.append(np.searchsorted(time, passages[:, 0], "right"), time.size)
    none = np.zeros((2, 3, time.size)), np.zeros((len(passages), 4, 3))
    found = Tangents(begin, *none, passages[:, 4], passages[:, 3])
    known = theta + stands, np.ascontiguousarray(rates[:, 0])
    tolerance = scene.tolerance(start)
    if scene.is_by_series(time) and len(steps) == 1:
        law, motion_of_base = scene.constants, scene.motion or STILL
        accuracy = tolerance, series.SHARPER * tolerance, solver.max_steps
        own = scene.factors, passages, static_depth(scene.block, scene.foundation, 0.0), steps[0]
        of_scene = series.scene_of(law, motion_of_base.coefficients)
        if swings_by_series(of_scene, time, accuracy, *own, *known, begin, found.by_state, found.onward):
            return found
    _swing_by_swing(scene, found, time, passages, known, steps, tolerance)
    return found


def _swing_by_swing(
    scene: "_Scene",
    found: Tangents,
    time: Floats,
    passages: Floats,
    known: tuple[Floats, Floats],
    steps: Sequence[float],
    tolerance: float,
) -> None:
    """Fill the derivatives of swings by any integrator."""
    is_foundation, block = scene.law.is_foundation, scene.block
    depth = static_depth(block, scene.foundation, 0.0) if is_foundation else 0.0
    last = np.full(5, np.nan)
    for j, (clock, z, z_rate, _, rate) in enumerate(passages.tolist()):
        own = slice(found.begin[j], found.begin[j + 1])
        after = passages[j + 1] - [clock, 0, 0, 0, 0] if j + 1 < len(passages) else last
        n, later = time[own].size, time[own] - clock
        if after is not last:
            later = np.append(later, (1 + 30 * steps[0]) * after[0] + LATER_S)
        scales = max(abs(z), depth), block.b * abs(rate), abs(rate)
        for q in range(3) if is_foundation else (2,):
            ends = [(known[0][own], known[1][own], after)]
            for step in steps:
                state = [z, z_rate, 0.0, rate]
                state[(0, 1, 3)[q]] += step * scales[q]
                moved, rates, passed = (
                    np.empty(later.size),
                    np.empty((later.size, 3)),
                    np.full((1, 5), np.nan),
                )
                scene.integrate(State(*state), later, moved, rates, passed, j + 1, tolerance)
                ends.append((moved[:n], rates[:n, 0], passed[0]))
            one, other = ends[1], ends[2 if len(steps) > 1 else 0]
            by = (steps[0] - sum(steps[1:])) * scales[q]
            for out, i in ((found.by_state[0, q], 0), (found.by_state[1, q], 1)):
                out[own] = (one[i] - other[i]) / by
            if after is not last:
                found.onward[j, :, q] = (one[2] - other[2])[[1, 2, 4, 0]] / by


def _swings_in_closed_form(
    scene: "_Scene", theta0: float, time: Floats, theta: Floats, rate: Floats, step: float
) -> Tangents:
    """Of Housner's block: all swings after an impact keep their ratios of energy."""
    kept, limits = scene.restitutions, (theta0, time[-1], scene.solver.max_steps)
    lost = np.append(1 + step, np.ones(kept.size - 1))
    whole, moved = (housner_swings(scene.block, each, *limits) for each in (kept, kept * lost))
    n = min(scene.factors.size, whole.impact_time.size, moved.impact_time.size)
    n = int(np.searchsorted(whole.impact_time[:n], time[-1]))
    begin = np.append(np.searchsorted(time, whole.impact_time[:n], "right"), time.size)
    none = np.zeros((2, 3, time.size)), np.zeros((n, 4, 3))
    found = Tangents(begin, *none, np.ones(n), scene.factors[:n])
    late = (moved.impact_time[:n] - whole.impact_time[:n]) / step
    found.onward[:, 2, 2], found.onward[:-1, 3, 2] = 1.0, np.diff(late)
    later, _ = housner_motion(moved, time, theta0, rates=False)
    own = slice(begin[0], None)
    found.by_state[0, 2, own] = (later - theta)[own] / step + rate[own] * np.repeat(late, np.diff(begin))
    return found


@dataclass(frozen=True, eq=False)
class _Scene:
    """A block that moves by a law on a ground, and how the motion is solved."""

    law: Law
    block: Block
    parameters: Mapping[str, Any]
    motion: GroundMotion | None
    rules: Rules
    solver: Solver

    @cached_property
    def foundation(self) -> Foundation:
        """What it stands on; none under a rigid block."""
        return Foundation.of(self.parameters) if self.law.is_foundation else Foundation(0.0)

    @property
    def restitutions(self) -> Floats:
        """r of Housner's block at each of the first impacts, at last that of all further ones."""
        return float(self.parameters["r"]) * np.append(self.factors, 1.0)

    @cached_property
    def factors(self) -> Floats:
        """What the rate is multiplied with at each of the first impacts, 1 + δ."""
        return 1.0 + np.asarray(self.parameters.get("impacts", NO_IMPACTS), float)

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Law and block as the integrators take them; Housner's block always turns about its corners."""
        return self.foundation.constants(
            self.block, self.rules.kinematics == "pivoting" or not self.law.is_foundation
        )

    @property
    def is_closed_form(self) -> bool:
        """Whether it is Housner's block on a level base that stays."""
        leans = self.block.e or self.parameters.get("tilt")
        return not (self.law.is_foundation or self.motion or leans)

    @property
    def is_tensionless(self) -> bool:
        """Whether the foundation never pulls where it could."""
        return self.rules.debonding == "tensionless" and self.foundation.is_damped

    def is_by_series(self, time: Floats) -> bool:
        """Whether `series` knows it: the force of its law, at sharp corners."""
        odd = self.is_tensionless or self.block.edge_radius_m or self.block.e
        still = self.motion is None or not len(self.motion.coefficients)
        return self.law.by_series and not odd and (still or self.motion.leans(time, self.block.g))  # type: ignore[union-attr]

    def in_closed_form(
        self, theta0: float, time: Floats, rates: Floats | None, passages: Floats = NO_PASSAGES
    ) -> tuple[Floats, int, Floats]:
        """Rotation of Housner's block released from rest, its outcome and impacts.

        Fills θ̇ and passages where they are wanted.
        """
        until = time[-1] if time.size else 0.0
        r, n = self.restitutions, len(passages)
        if n and (passages[:, 4] > 0).any():
            first = housner_swings(self.block, r, theta0, 0.0).impact_rate
            after = float(first[0]) if first.size else np.nan
            for i, held in enumerate(passages[:, 4].tolist()):
                r[i] = held / after if held > 0 else r[i]
                after *= r[i]
        swings = housner_swings(self.block, r, theta0, until, self.solver.max_steps)
        if n:
            reached = min(n, len(swings.impact_time))
            passages[:reached, 0] = swings.impact_time[:reached]
            passages[:, 3] = r[:n] / self.parameters["r"]
            passages[:reached, 4] = r[:reached] * swings.impact_rate[:reached]
        theta, rate = housner_motion(swings, time, theta0, rates=rates is not None)
        if rates is not None:
            rates[:, -1] = rate
        outcome = "at_rest" if until > swings.rest_time else swings.outcome
        return theta, OUTCOMES.index(outcome), swings.impact_time[swings.impact_time <= until]

    def released(self, theta0: float, time: Floats) -> tuple["_Scene", State, float]:
        """With gravity as on its base, the state at the release, and where it stands at rest [rad]."""
        tilt, scene = float(self.parameters.get("tilt", 0.0)), self
        if tilt:
            scene = replace(self, motion=tilted(tilt, float(time[-1]), self.block.g))
        depth = stands = 0.0
        if self.law.is_foundation:
            depth = static_depth(self.block, self.foundation, theta0)
            stands = lean(self.block, self.foundation, tilt) if tilt or self.block.e else 0.0
        return scene, State(depth, 0.0, theta0 + stands, 0.0), stands

    def tolerance(self, start: State) -> float:
        """Error allowed per step [rad]."""
        block, amplitude = self.block, self.block.theta_cr
        if self.motion is None or "tilt" in self.parameters:
            _, z_rate0, theta0, theta_rate0 = start
            moved = abs(theta0) + abs(theta_rate0) / block.p + abs(z_rate0) / (block.p * block.b)
            amplitude = min(amplitude, moved) or amplitude
        if self.law.is_foundation and not self.foundation.is_damped:
            # nothing forgets the errors of a motion without damping
            amplitude *= 0.3
        return self.solver.rtol * amplitude

    def integrate(
        self,
        start: State,
        time: Floats,
        theta: Floats,
        rates: Floats,
        passages: Floats = NO_PASSAGES,
        first: int = 0,
        tolerance: float = 0.0,
    ) -> tuple[int, int, int, int, int, Floats]:
        """Outcome, steps, rejected, implicit, evaluations and impacts; fills theta, rates and passages.

        The start lies before the impact of the number `first`.
        """
        # one signature, so that the kernel is compiled once
        state = float(start[0]), float(start[1]), float(start[2]), float(start[3])
        if not (time.flags.carray and time.dtype == float):
            time = np.require(time, float, ["C", "W"])
        motion = self.motion or STILL
        ground, tolerance = (motion.breaks, motion.coefficients), tolerance or self.tolerance(start)
        factors = self.factors[first : first + len(passages)] if first else self.factors
        given = state, time, *ground, tolerance, self.solver.max_steps, factors, passages, theta, rates
        if self.is_by_series(time):
            return series.integrate_series(self.constants, *given)
        r = -1.0 if self.law.is_foundation else float(self.parameters["r"])
        found: tuple[int, int, int, int, int, Floats] = kernel.integrate(
            self.constants, r, self.is_tensionless, *given
        )
        return found
