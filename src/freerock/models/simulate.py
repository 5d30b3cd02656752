"""The one public door to the rocking models."""

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freerock.errors import FreerockError
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import static_depth
from freerock.models.ground import GroundMotion
from freerock.models.housner import Swings, housner_motion, housner_swings
from freerock.models.kernel import integrate
from freerock.models.laws import DEBONDING, LAWS, MODELS, unit_of

Floats = NDArray[np.float64]

OUTCOMES = ("completed", "at_rest", "overturned", "step_limit", "non_finite")
MAX_STEPS = 1_000_000
NO_RATES = np.empty((0, 3))
STILL = GroundMotion(np.empty(0), np.empty((0, 14)))


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
        accelerations); 0 but for the steps, which are the impacts, in closed form.
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
    theta0: float = 0.0,
    theta_rate0: float = 0.0,
    z0: float | None = None,
    z_rate0: float = 0.0,
    base_excitation: GroundMotion | None = None,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    max_steps: int = MAX_STEPS,
) -> Response:
    """Motion of a rocking block released at t = 0.

    Free rocking of the Housner model is evaluated in closed form; everything else is integrated.

    Parameters
    ----------
    model : str
        "housner", "winkler", "hunt_crossley" or "general".
    block : Block
        The block.
    parameters : mapping
        {"r": ...} [1], {"k": ..., "c": ...} [N/m², N·s/m²], {"k": ..., "lambda": ...} [N/m², N·s/m³], or all
        of "k", "c" and "lambda".
    time : ndarray, shape (n_time,)
        Increasing instants [s]; before t = 0 the initial state is held.
    theta0, theta_rate0 : float
        Rotation, positive clockwise [rad], and rate [rad/s] at t = 0.
    z0, z_rate0 : float
        Depth of the base centre [m] and its rate [m/s] at t = 0; z0 None is static vertical equilibrium.
        Not used by the Housner model.
    base_excitation : GroundMotion, optional
        Motion of the ground.
    debonding : str
        "geometric" (contact where z > 0) or "tensionless" (contact where z > 0 and f > 0).
    rtol : float
        Error allowed per step, relative to the amplitude: θ₀ in free rocking, θ_cr on a moving ground.
    max_steps : int
        Steps (or impacts) after which to give up.

    Returns
    -------
    Response

    Raises
    ------
    FreerockError
        Unknown model, missing or negative parameter, time not increasing, and the like.
    """
    instants = _check(model, parameters, time, (theta0, theta_rate0, z0 or 0.0, z_rate0), debonding, rtol)
    if model == "housner" and base_excitation is None:
        return _housner(block, parameters["r"], instants, theta0, theta_rate0, max_steps)
    if model == "housner":
        z0, z_rate0 = 0.0, 0.0
    elif z0 is None:
        z0 = static_depth(block, parameters["k"], theta0)
    theta, rates = np.empty(instants.size), np.empty((instants.size, 3))
    outcome, steps, rejected, implicit, evaluations, impacts = _integrate(
        model, block, parameters, (z0, z_rate0, theta0, theta_rate0), instants, base_excitation, debonding,
        rtol, max_steps, theta, rates,
    )  # fmt: skip
    statistics = {"steps": steps, "rejected": rejected, "implicit": implicit, "evaluations": evaluations}
    if model == "housner":
        return _about_corners(block, instants, theta, rates[:, 2], impacts, OUTCOMES[outcome], statistics)
    z_cb, z_cb_rate, theta_rate = rates.T
    lift = block.b * np.sin(theta)
    contact = np.zeros(instants.size, np.int8)
    contact[z_cb - lift <= 0] = 1
    contact[z_cb + lift <= 0] = -1
    contact[(z_cb - lift <= 0) & (z_cb + lift <= 0)] = 2
    return Response(
        instants, theta, theta_rate, z_cb, z_cb_rate, contact, impacts, OUTCOMES[outcome], statistics
    )


def simulate_theta(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time: Floats,
    *,
    theta0: float,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    max_steps: int = MAX_STEPS,
    theta_rate: Floats | None = None,
) -> tuple[Floats, str]:
    """Rotation of a block released from rest, for fits: `simulate` without checks of its arguments.

    `theta_rate`, shape (n_time,), receives θ̇ [rad/s] if given.

    Returns
    -------
    theta : ndarray, shape (n_time,)
        [rad]
    outcome : str
        As in `Response`.
    """
    if model == "housner":
        swings = housner_swings(block, parameters["r"], theta0, 0.0, time[-1], max_steps)
        theta, rate = housner_motion(swings, time, theta0, 0.0, rates=theta_rate is not None)
        if theta_rate is not None:
            theta_rate[:] = rate
        return theta, _housner_outcome(swings, time)
    theta = np.empty(time.size)
    rates = NO_RATES if theta_rate is None else np.empty((time.size, 3))
    state = (static_depth(block, parameters["k"], theta0), 0.0, theta0, 0.0)
    outcome, *_ = _integrate(
        model, block, parameters, state, time, None, debonding, rtol, max_steps, theta, rates
    )
    if theta_rate is not None:
        theta_rate[:] = rates[:, 2]
    return theta, OUTCOMES[outcome]


def simulate_fitted(
    model: str,
    block: Block,
    values: Mapping[str, float],
    time: Floats,
    *,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    theta_rate: Floats | None = None,
) -> Floats:
    """Rotation [rad], shape (n_time,), under what a fit finds; an overturned block lies at ±π/2.

    `values` holds the parameters of the model, theta0 [rad] and, where they were freed, the release t0 on the
    clock of `time` [s] and the width of the corners [m]. All else as in `simulate_theta`, which fits share.
    """
    if "width" in values:
        block = replace(block, contact_width_m=float(values["width"]))
    theta, _ = simulate_theta(
        model,
        block,
        {name: values[name] for name in MODELS[model]},
        time - values.get("t0", 0.0),
        theta0=values["theta0"],
        debonding=debonding,
        rtol=rtol,
        theta_rate=theta_rate,
    )
    lost = np.isnan(theta)
    if lost.any():
        theta[lost] = np.copysign(np.pi / 2, values["theta0"])
        if theta_rate is not None:
            theta_rate[lost] = 0.0
    return theta


def cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def simulate_many(
    model: str,
    block: Block,
    parameters: Mapping[str, float | Floats],
    time: ArrayLike,
    *,
    theta0: float | Floats,
    base_excitation: GroundMotion | None = None,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    max_steps: int = MAX_STEPS,
    threads: int | None = None,
) -> tuple[Floats, NDArray[np.str_]]:
    """Rotation under many sets of parameters, each released from rest, on several threads.

    Parameters
    ----------
    parameters : mapping
        As in `simulate`, with floats or arrays that broadcast to (n_sets,).
    theta0 : float or ndarray, shape (n_sets,)
        Rotation at t = 0 [rad].
    threads : int, optional
        Number of threads; all cores this process may use if None. The results do not depend on it.

    The others as in `simulate`.

    Returns
    -------
    theta : ndarray, shape (n_sets, n_time)
        [rad]
    outcome : ndarray of str, shape (n_sets,)
        As in `Response`.

    Raises
    ------
    FreerockError
        As in `simulate`.
    """
    names = MODELS.get(model, ())
    columns = [np.atleast_1d(np.asarray(parameters.get(name, np.nan), dtype=float)) for name in names]
    *columns, starts = np.broadcast_arrays(*columns, np.atleast_1d(np.asarray(theta0, dtype=float)))
    for values in columns:
        if values.ndim != 1:
            raise FreerockError("parameters", "not one-dimensional", "give one value for each set")
    lowest = {n: float(v.min()) for n, v in zip(names, columns, strict=True) if n in parameters}
    highest = {n: float(v.max()) for n, v in zip(names, columns, strict=True) if n in parameters}
    for extreme in (lowest, highest):
        instants = _check(model, extreme, time, starts, debonding, rtol)
    theta = np.empty((starts.size, instants.size))
    outcome = np.empty(starts.size, dtype="U10")

    def run(sets: Iterable[int]) -> None:
        for i in sets:
            one = {name: float(values[i]) for name, values in zip(names, columns, strict=True)}
            start = float(starts[i])
            if model == "housner" and base_excitation is None:
                theta[i], outcome[i] = simulate_theta(
                    model, block, one, instants, theta0=start, max_steps=max_steps
                )
                continue
            z0 = 0.0 if model == "housner" else static_depth(block, one["k"], start)
            code, *_ = _integrate(
                model, block, one, (z0, 0.0, start, 0.0), instants, base_excitation, debonding, rtol,
                max_steps, theta[i], NO_RATES,
            )  # fmt: skip
            outcome[i] = OUTCOMES[code]

    if threads is None:
        threads = cores()
    # the first run loads or compiles the kernel; the others are dealt out like cards
    run(range(min(1, starts.size)))
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(run, (range(1 + i, starts.size, threads) for i in range(threads))):
            pass
    return theta, outcome


def _integrate(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    state: Sequence[float],
    time: Floats,
    motion: GroundMotion | None,
    debonding: str,
    rtol: float,
    max_steps: int,
    theta: Floats,
    rates: Floats,
) -> tuple[int, int, int, int, int, Floats]:
    """Outcome, steps, rejected, implicit, evaluations and impacts; fills theta and rates."""
    m, b, p = block.mass_kg, block.b, block.p
    k, c, lam = parameters.get("k", 0.0), parameters.get("c", 0.0), parameters.get("lambda", 0.0)
    law = (k / m, c / m, lam / m, b, block.h, block.inertia_base / m, GRAVITY)
    # one signature, so that the kernel is compiled once
    state = tuple(map(float, state))
    time = np.require(time, float, ["C", "W"])
    amplitude = block.theta_cr
    if motion is None:
        _, z_rate0, theta0, theta_rate0 = state
        moved = abs(theta0) + abs(theta_rate0) / p + abs(z_rate0) / (p * b)
        amplitude = min(amplitude, moved) or amplitude
        motion = STILL
    if k > 0 and c == 0 and lam == 0:
        # nothing forgets the errors of a motion without damping
        amplitude *= 0.3
    found: tuple[int, int, int, int, int, Floats] = integrate(
        law,
        float(parameters["r"]) if model == "housner" else -1.0,
        debonding == "tensionless" and c + lam > 0,
        state,
        time,
        motion.breaks,
        motion.coefficients,
        rtol * amplitude,
        max_steps,
        theta,
        rates,
        len(rates) > 0,
    )
    return found


def _housner(
    block: Block, r: float, time: Floats, theta0: float, theta_rate0: float, max_steps: int
) -> Response:
    until = time[-1] if time.size else 0.0
    swings = housner_swings(block, r, theta0, theta_rate0, until, max_steps)
    theta, theta_rate = housner_motion(swings, time, theta0, theta_rate0)
    impacts = swings.impact_time[swings.impact_time <= until]
    statistics = {"steps": len(impacts), "rejected": 0, "implicit": 0, "evaluations": 0}
    return _about_corners(block, time, theta, theta_rate, impacts, _housner_outcome(swings, time), statistics)


def _about_corners(
    block: Block,
    time: Floats,
    theta: Floats,
    theta_rate: Floats,
    impacts: Floats,
    outcome: str,
    statistics: dict[str, int],
) -> Response:
    """Response of a block that turns about its corners."""
    side = np.where(np.isnan(theta), 0.0, np.sign(theta))
    return Response(
        time,
        theta,
        theta_rate,
        -block.b * side * np.sin(theta),
        -block.b * side * np.cos(theta) * theta_rate,
        side.astype(np.int8),
        impacts,
        outcome,
        statistics,
    )


def _housner_outcome(swings: Swings, time: Floats) -> str:
    if swings.outcome == "completed" and time.size and time[-1] > swings.rest_time:
        return "at_rest"
    return swings.outcome


def _check(
    model: str,
    parameters: Mapping[str, float],
    time: ArrayLike,
    state: ArrayLike,
    debonding: str,
    rtol: float,
) -> Floats:
    if model not in MODELS:
        raise FreerockError("model", f"unknown model {model!r}", f"use one of {', '.join(MODELS)}")
    for name in MODELS[model]:
        where = f"parameters.{name}"
        if name not in parameters:
            raise FreerockError(where, "missing", f"give {name} [{unit_of(name)}] for the {model} model")
        value = parameters[name]
        if not math.isfinite(value) or value < 0 or (name == "k" and value == 0):
            raise FreerockError(
                where,
                f"{value} is not a {'positive' if name == 'k' else 'non-negative'} number",
                f"give {name} in {unit_of(name)}",
            )
        if name == "r" and value > 1:
            raise FreerockError(
                where, f"{value} is above 1", "an impact cannot add energy: give r between 0 and 1"
            )
    if debonding not in DEBONDING:
        raise FreerockError("debonding", f"unknown rule {debonding!r}", f"use {' or '.join(DEBONDING)}")
    law = LAWS[model]
    if not law.allows(debonding, sum(parameters[name] > 0 for name in law.dampings)):
        what = "the tensionless rule is not worked out for both dampings at once"
        raise FreerockError("debonding", what, "use geometric")
    if not rtol > 0:
        raise FreerockError("rtol", f"{rtol} is not positive", "give a tolerance such as 1e-8")
    if not np.all(np.isfinite(state)):
        raise FreerockError(
            "theta0", "the start is not finite", "give the angle in rad and the rate in rad/s"
        )
    instants = np.ascontiguousarray(time, dtype=float)
    if instants.ndim != 1 or not np.all(np.isfinite(instants)) or np.any(np.diff(instants) < 0):
        raise FreerockError("time", "not an increasing array of finite instants", "sort it and drop NaN")
    return instants
