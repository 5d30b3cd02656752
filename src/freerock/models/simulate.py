"""The one public door to the rocking models."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from freerock.errors import FreerockError
from freerock.models import MODELS, UNITS
from freerock.models.block import GRAVITY, Block
from freerock.models.foundation import static_depth
from freerock.models.housner import housner_lobes, housner_motion
from freerock.models.integrate import integrate

OUTCOMES = ("completed", "at_rest", "overturned", "step_limit", "non_finite")
DEBONDING = ("geometric", "tensionless")
# Error per step allowed in θ, as a share of rtol times the amplitude.
STEP_SHARE = 1.0


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
        "completed", "at_rest" (before the last sample), "overturned", "step_limit" or "non_finite".
    statistics : dict
        steps, rejected, evaluations.
    """

    time: np.ndarray
    theta: np.ndarray
    theta_rate: np.ndarray
    z_cb: np.ndarray
    z_cb_rate: np.ndarray
    contact: np.ndarray
    impacts: np.ndarray
    outcome: str
    statistics: dict


def simulate(
    model: str,
    block: Block,
    parameters: Mapping,
    time: np.ndarray,
    *,
    theta0: float,
    theta_rate0: float = 0.0,
    z0: float | None = None,
    z_rate0: float = 0.0,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    max_steps: int = 2_000_000,
) -> Response:
    """Motion of a rocking block released at t = 0.

    Parameters
    ----------
    model : str
        "housner", "winkler" or "hunt_crossley".
    block : Block
        The block.
    parameters : mapping
        {"r": ...} [1], {"k": ..., "c": ...} [N/m², N·s/m²] or {"k": ..., "lambda": ...} [N/m², N·s/m³].
    time : ndarray, shape (n_time,)
        Increasing instants [s]; before t = 0 the initial state is held.
    theta0, theta_rate0 : float
        Rotation, positive clockwise [rad], and rate [rad/s] at t = 0.
    z0, z_rate0 : float
        Depth of the base centre [m] and its rate [m/s] at t = 0; z0 None is static vertical equilibrium.
        Not used by the Housner model.
    debonding : str
        "geometric" (contact where z > 0) or "tensionless" (contact where z > 0 and f > 0).
    rtol : float
        Tolerance relative to the amplitude.
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
    time = _check(model, parameters, time, theta0, theta_rate0, debonding, rtol)
    if model == "housner":
        return _housner(block, parameters["r"], time, theta0, theta_rate0, max_steps)
    state = (static_depth(block, parameters["k"], theta0) if z0 is None else z0, z_rate0, theta0, theta_rate0)
    theta, rates = np.empty(time.size), np.empty((time.size, 3))
    outcome, steps, rejected, implicit, evaluations, impacts = _kernel(
        model, block, parameters, state, time, debonding, rtol, max_steps, theta, rates
    )
    z_cb, z_cb_rate, theta_rate = rates.T
    lift = block.b * np.sin(theta)
    contact = np.zeros(time.size, np.int8)
    contact[z_cb - lift <= 0] = 1
    contact[z_cb + lift <= 0] = -1
    contact[(z_cb - lift <= 0) & (z_cb + lift <= 0)] = 2
    statistics = {"steps": steps, "rejected": rejected, "implicit": implicit, "evaluations": evaluations}
    return Response(time, theta, theta_rate, z_cb, z_cb_rate, contact, impacts, OUTCOMES[outcome], statistics)


def simulate_theta(
    model: str,
    block: Block,
    parameters: Mapping,
    time: np.ndarray,
    *,
    theta0: float,
    debonding: str = "geometric",
    rtol: float = 1e-8,
    max_steps: int = 2_000_000,
) -> tuple:
    """Rotation only, for fits: `simulate` from rest without checks of its arguments.

    Returns
    -------
    theta : ndarray, shape (n_time,)
        [rad]
    outcome : str
        As in `Response`.
    """
    if model == "housner":
        lobes = housner_lobes(block, parameters["r"], theta0, 0.0, time[-1], max_steps)
        theta, _ = housner_motion(lobes, time, theta0, 0.0, rates=False)
        return theta, _housner_outcome(lobes, time)
    theta = np.empty(time.size)
    state = (static_depth(block, parameters["k"], theta0), 0.0, theta0, 0.0)
    outcome, *_ = _kernel(
        model, block, parameters, state, time, debonding, rtol, max_steps, theta, np.empty((0, 3))
    )
    return theta, OUTCOMES[outcome]


def _kernel(model, block, parameters, state, time, debonding, rtol, max_steps, theta, rates):
    m, b, h = block.mass_kg, block.b, block.h
    k, c, lam = parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0)
    law = (k / m, c / m, lam / m, b, h, block.inertia_base / m, GRAVITY)
    _, z_rate0, theta0, theta_rate0 = state
    amplitude = min(block.theta_cr, abs(theta0) + abs(theta_rate0) / block.p + abs(z_rate0) / (block.p * b))
    if amplitude == 0:
        amplitude = block.theta_cr
    return integrate(
        law,
        -1.0,
        debonding == "tensionless" and c + lam > 0,
        state,
        time,
        np.empty(0),
        np.empty((0, 14)),
        STEP_SHARE * rtol * amplitude,
        max_steps,
        theta,
        rates,
        len(rates) > 0,
    )


def _housner(block, r, time, theta0, theta_rate0, max_steps):
    lobes = housner_lobes(block, r, theta0, theta_rate0, time[-1] if time.size else 0.0, max_steps)
    theta, theta_rate = housner_motion(lobes, time, theta0, theta_rate0)
    cos = np.cos(theta)
    contact = np.sign(theta).astype(np.int8)
    outcome = _housner_outcome(lobes, time)
    impacts = lobes.impact_time
    return Response(
        time,
        theta,
        theta_rate,
        -block.b * np.abs(np.sin(theta)),
        -block.b * cos * np.sign(theta) * theta_rate,
        contact,
        impacts[impacts <= time[-1]],
        outcome,
        {"steps": len(impacts), "rejected": 0, "evaluations": 0},
    )


def _housner_outcome(lobes, time):
    if lobes.outcome == "completed" and time.size and time[-1] > lobes.rest_time:
        return "at_rest"
    return lobes.outcome


def _check(model, parameters, time, theta0, theta_rate0, debonding, rtol):
    if model not in MODELS:
        raise FreerockError("model", f"unknown model {model!r}", f"use one of {', '.join(MODELS)}")
    for name in MODELS[model]:
        where = f"parameters.{name}"
        if name not in parameters:
            raise FreerockError(where, "missing", f"give {name} [{UNITS[name]}] for the {model} model")
        value = parameters[name]
        if not math.isfinite(value) or value < 0 or (name == "k" and value == 0):
            raise FreerockError(
                where,
                f"{value} is not a {'positive' if name == 'k' else 'non-negative'} number",
                f"give {name} in {UNITS[name]}",
            )
        if name == "r" and value > 1:
            raise FreerockError(
                where, f"{value} is above 1", "an impact cannot add energy: give r between 0 and 1"
            )
    if debonding not in DEBONDING:
        raise FreerockError("debonding", f"unknown rule {debonding!r}", f"use {' or '.join(DEBONDING)}")
    if not rtol > 0:
        raise FreerockError("rtol", f"{rtol} is not positive", "give a tolerance such as 1e-8")
    if not (math.isfinite(theta0) and math.isfinite(theta_rate0)):
        raise FreerockError(
            "theta0", "the start is not finite", "give the angle in rad and the rate in rad/s"
        )
    time = np.ascontiguousarray(time, dtype=float)
    if time.ndim != 1 or not np.all(np.isfinite(time)) or np.any(np.diff(time) < 0):
        raise FreerockError("time", "not an increasing array of finite instants", "sort it and drop NaN")
    return time
