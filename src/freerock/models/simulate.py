"""The one public door to the rocking models."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.arrays import Floats
from freerock.models import kernel, series
from freerock.models.block import Block
from freerock.models.contact import Foundation, State, lean, static_depth
from freerock.models.ground import GroundMotion, tilted
from freerock.models.housner import Swings, housner_motion, housner_swings
from freerock.models.laws import GEOMETRIC, LAWS, Law, Rules
from freerock.models.refusals import check_scene

OUTCOMES = ("completed", "at_rest", "overturned", "step_limit", "non_finite")
NO_RATES, NO_IMPACTS, NO_PASSAGES = np.empty((0, 3)), np.empty(0), np.empty((0, 5))
STILL = GroundMotion(np.empty(0), np.empty((0, 14)))


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

    Free rocking of the Housner model is evaluated in closed form; everything else is integrated.

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
    instants = check_scene(model, block, parameters, time, start, base_excitation, rules, solver.rtol)
    if not LAWS[model].is_foundation:
        if base_excitation is None and not block.e:
            return _housner(block, parameters["r"], instants, start, solver.max_steps)
        start = State(0.0, 0.0, start.theta, start.theta_rate)
    elif not isinstance(theta0, State):
        start = start._replace(z=static_depth(block, Foundation.of(parameters), theta0))
    theta, rates = np.empty(instants.size), np.empty((instants.size, 3))
    scene = _Scene(model, block, parameters, base_excitation, rules, solver)
    outcome, steps, rejected, implicit, evaluations, impacts = scene.integrate(start, instants, theta, rates)
    statistics = {"steps": steps, "rejected": rejected, "implicit": implicit, "evaluations": evaluations}
    z_cb, z_cb_rate, theta_rate = rates.T
    if LAWS[model].is_foundation:
        base = z_cb, z_cb_rate, _contact(block, z_cb, theta)
    else:
        base = _about_corners(block, theta, theta_rate)
    return Response(instants, theta, theta_rate, *base, impacts, OUTCOMES[outcome], statistics)


def simulate_theta(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time: Floats,
    *,
    theta0: float,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    rates: Floats | None = None,
) -> tuple[Floats, str]:
    """Rotation of a block released from rest, for fits: `simulate` without checks of its arguments.

    `parameters` may hold more: the tilt of the base counts [rad]. Angles count from where the block stands
    at rest. `rates`, if given, receives z_cb, ż_cb and θ̇ [m, m/s, rad/s], shape (n_time, 3), or
    θ̇ alone, shape (n_time, 1).

    Returns
    -------
    theta : ndarray, shape (n_time,)
        [rad]
    outcome : str
        As in `Response`.
    """
    return _released(_Scene(model, block, parameters, None, rules, solver), theta0, time, rates)


def simulate_fitted(
    model: str,
    block: Block,
    values: Mapping[str, float],
    time: Floats,
    *,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    rates: Floats | None = None,
) -> Floats:
    """Rotation [rad], shape (n_time,), under what a fit finds; an overturned block lies at ±π/2.

    `values` holds the parameters of the model, theta0 [rad] and, where they were freed, the release t0 on the
    clock of `time` [s], the width of the corners and the radius of the edges [m], the tilt of the base
    [rad] and, as "impacts", δ of each impact, after which the rate is multiplied by 1 + δ. All else as in
    `simulate_theta`, which fits share.
    """
    theta, _ = simulate_theta(
        model,
        block.as_found(values),
        values,
        time - values["t0"] if "t0" in values else time,
        theta0=values["theta0"],
        rules=rules,
        solver=solver,
        rates=rates,
    )
    if theta.size and np.isnan(theta[-1]):
        lost = np.isnan(theta)
        theta[lost] = np.copysign(np.pi / 2, values["theta0"])
        if rates is not None:
            rates[lost] = 0.0
    return theta


def restarts(
    model: str,
    block: Block,
    values: Mapping[str, Any],
    time: Floats,
    *,
    rules: Rules = GEOMETRIC,
    solver: Solver = SOLVER,
    step: float = 1e-4,
) -> Iterator[tuple[int, int, Floats, Floats]]:
    """The motion after each impact whose rate is a little larger, for derivatives by the scatter of impacts.

    A motion before an impact does not depend on it: each of these begins where the impact was.

    Parameters
    ----------
    values : mapping
        As in `simulate_fitted`; "impacts" holds δ of each impact, shape (n_impacts,): the rate after it is
        multiplied by 1 + δ.
    step : float
        What is added to δ of one impact.

    Yields
    ------
    impact, begin : int
        Number of the impact, and of the first sample after it.
    theta, z_cb : ndarray, shape (n_time - begin,)
        Rotation [rad], and depth of the base centre [m].
    """
    scene = _Scene(model, block.as_found(values), values, None, rules, solver)
    block, tilt, theta0 = scene.block, float(values.get("tilt", 0.0)), values["theta0"]
    time = time - values.get("t0", 0.0)
    n = scene.factors.size
    if not (tilt or scene.law.is_foundation or block.e):
        whole = housner_swings(block, scene.restitutions, theta0, 0.0, time[-1], solver.max_steps)
        for i in range(min(n, whole.impact_time.size)):
            moved = np.array(values["impacts"], float)
            moved[i] += step
            own: dict[str, Any] = {**values, "impacts": moved}
            scene = replace(scene, parameters=own)
            begin = int(np.searchsorted(time, whole.impact_time[i], "right"))
            if begin < time.size:
                theta, _ = _released(scene, theta0, time)
                yield i, begin, theta[begin:], _corner_kept(block, theta[begin:], theta[begin:])[0]
        return
    if tilt:
        scene = replace(scene, motion=tilted(tilt, float(time[-1]), block.g))
    stands = depth = 0.0
    if scene.law.is_foundation:
        depth = static_depth(block, scene.foundation, theta0)
        stands = lean(block, scene.foundation, tilt) if tilt or block.e else 0.0
    passages, unwanted = np.full((n, 5), np.nan), np.empty(time.size)
    scene.integrate(State(depth, 0.0, theta0 + stands, 0.0), time, unwanted, NO_RATES, passages)
    for i in range(n):
        clock, z, z_rate, theta, rate = passages[i].tolist()
        begin = int(np.searchsorted(time, clock, "right")) if np.isfinite(clock) else time.size
        if begin == time.size:
            return
        later = time[begin:] - clock
        start = State(z, z_rate, theta, rate * (1 + step / scene.factors[i]))
        moved, rates = np.empty(later.size), np.empty((later.size, 3))
        scene.integrate(start, later, moved, rates, first=i + 1)
        yield i, begin, moved - stands if stands else moved, rates[:, 0]


@dataclass(frozen=True)
class _Scene:
    """A block that moves by a law on a ground, and how the motion is solved."""

    model: str
    block: Block
    parameters: Mapping[str, float]
    motion: GroundMotion | None
    rules: Rules
    solver: Solver

    @property
    def law(self) -> Law:
        """Its row."""
        return LAWS[self.model]

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

    def integrate(
        self,
        start: State,
        time: Floats,
        theta: Floats,
        rates: Floats,
        passages: Floats = NO_PASSAGES,
        first: int = 0,
    ) -> tuple[int, int, int, int, int, Floats]:
        """Outcome, steps, rejected, implicit, evaluations and impacts; fills theta, rates and passages.

        The start lies before the impact of the number `first`.
        """
        block, foundation, motion = self.block, self.foundation, self.motion
        is_foundation = self.law.is_foundation
        # one signature, so that the kernel is compiled once
        state = float(start[0]), float(start[1]), float(start[2]), float(start[3])
        if not (time.flags.carray and time.dtype == float):
            time = np.require(time, float, ["C", "W"])
        amplitude = block.theta_cr
        if motion is None or "tilt" in self.parameters:
            _, z_rate0, theta0, theta_rate0 = state
            moved = abs(theta0) + abs(theta_rate0) / block.p + abs(z_rate0) / (block.p * block.b)
            amplitude = min(amplitude, moved) or amplitude
            motion = motion or STILL
        if is_foundation and not (foundation.is_damped or self.parameters.get("c", 0.0)):
            # nothing forgets the errors of a motion without damping
            amplitude *= 0.3
        pivots = self.rules.kinematics == "pivoting"
        tensionless = self.rules.debonding == "tensionless" and foundation.is_damped
        tolerance, max_steps = self.solver.rtol * amplitude, self.solver.max_steps
        # Housner's block always turns about its corners
        constants = foundation.constants(block, pivots or not is_foundation)
        odd = tensionless or block.edge_radius or block.e
        on = motion.breaks, motion.coefficients
        accuracy = tolerance, max_steps
        scattered = self.factors[first:], passages
        if is_foundation and not odd and (not len(motion.coefficients) or motion.leans(time, self.block.g)):
            return series.integrate_series(constants, state, time, *on, *accuracy, *scattered, theta, rates)
        r = -1.0 if is_foundation else float(self.parameters["r"])
        return kernel.integrate(
            constants, r, tensionless, state, time, *on, *accuracy, *scattered, theta, rates
        )


def _released(scene: _Scene, theta0: float, time: Floats, rates: Floats | None = None) -> tuple[Floats, str]:
    """Rotation of a block released from rest, and how its motion ends; fills rates if given."""
    block, tilt = scene.block, float(scene.parameters.get("tilt", 0.0))
    is_foundation = scene.law.is_foundation
    if tilt:
        scene = replace(scene, motion=tilted(tilt, float(time[-1]), block.g))
    if scene.motion is None and not is_foundation and not block.e:
        swings = housner_swings(block, scene.restitutions, theta0, 0.0, time[-1], scene.solver.max_steps)
        theta, rate = housner_motion(swings, time, theta0, 0.0, rates=rates is not None)
        if rates is not None:
            rates[:, -1] = rate
            if rates.shape[1] > 1:
                rates[:, 0], rates[:, 1] = _corner_kept(block, theta, rate)
        return theta, _housner_outcome(swings, time)
    depth = stands = 0.0
    if is_foundation:
        depth = static_depth(block, scene.foundation, theta0)
        stands = lean(block, scene.foundation, tilt) if tilt or block.e else 0.0
    theta = np.empty(time.size)
    start = State(depth, 0.0, theta0 + stands, 0.0)
    every = NO_RATES if rates is None else rates if rates.shape[1] > 1 else np.empty((time.size, 3))
    outcome, *_ = scene.integrate(start, time, theta, every)
    if rates is not None and every is not rates:
        rates[:, 0] = every[:, 2]
    return theta - stands if stands else theta, OUTCOMES[outcome]


def _housner(block: Block, r: float, time: Floats, start: State, max_steps: int) -> Response:
    """Free rocking of the rigid block in closed form."""
    until = time[-1] if time.size else 0.0
    swings = housner_swings(block, r, start.theta, start.theta_rate, until, max_steps)
    theta, theta_rate = housner_motion(swings, time, start.theta, start.theta_rate)
    impacts = swings.impact_time[swings.impact_time <= until]
    statistics, base = _in_closed_form(impacts), _about_corners(block, theta, theta_rate)
    return Response(time, theta, theta_rate, *base, impacts, _housner_outcome(swings, time), statistics)


def _about_corners(
    block: Block, theta: Floats, theta_rate: Floats
) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """z_cb [m], its rate [m/s] and the contact of a block that turns about its corners."""
    down = np.where(np.isnan(theta), 0.0, np.sign(theta)).astype(np.int8)
    return *_corner_kept(block, theta, theta_rate), down


def _corner_kept(block: Block, theta: Floats, theta_rate: Floats) -> tuple[Floats, Floats]:
    """z_cb [m] and its rate [m/s] of a block that turns about its corners."""
    side = np.sign(theta)
    return -block.b * side * np.sin(theta), -block.b * side * np.cos(theta) * theta_rate


def _in_closed_form(impacts: Floats) -> dict[str, int]:
    """The statistics of a motion without steps."""
    return {"steps": len(impacts), "rejected": 0, "implicit": 0, "evaluations": 0}


def _housner_outcome(swings: Swings, time: Floats) -> str:
    if swings.outcome == "completed" and time.size and time[-1] > swings.rest_time:
        return "at_rest"
    return swings.outcome


def _contact(block: Block, z_cb: Floats, theta: Floats) -> NDArray[np.int8]:
    """Which part of the base is below the ground, as in `Response`."""
    lift = block.flat * np.sin(theta)
    contact = np.zeros(theta.size, np.int8)
    contact[z_cb - lift <= 0] = 1
    contact[z_cb + lift <= 0] = -1
    contact[(z_cb - lift <= 0) & (z_cb + lift <= 0)] = 2
    return contact
