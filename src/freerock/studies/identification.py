"""Monte-Carlo studies of the identification: does it find the minimum, and are its intervals honest?

Every case is drawn from its own seed, so that a study's numbers do not depend on the number of processes.
"""

import math
import multiprocessing
import time as clock
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from freerock.identification.choice import LOUDER, choose_model, is_wanted
from freerock.identification.fit import evidence, fit_record, fit_run
from freerock.identification.plan import standard_errors
from freerock.models.block import GRAVITY, Block
from freerock.models.contact import accelerations, contact_force, static_depth
from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.models.simulate import cores, simulate
from freerock.runs.motion import Motion
from freerock.studies.paper import TABLE_2
from freerock.virtual_lab.record import CONFIGURATIONS, FOUNDATIONS

SEED = 2017
RATE_HZ = 2000.0
HOLD_S = 1.0
T0_STDERR_S = 2e-4
LONGEST_S = 8.0
REST_SIGMAS = 1.0  # a run lasts until the swings are lost in the noise
SUCCESS_RUNS = {"full": 1000, "small": 4}  # random truths of each law
COVERAGE_RUNS = {"full": {"white": 200, "hum and drift": 80}, "small": {"white": 3}}  # of each scene and law
ERROR_RUNS = {"full": 3, "small": 1}  # of each scene and imperfection
CHOICE_RUNS = {"full": 300, "small": 3}  # of each law
EXCESS = 1.0  # of the squared residual over σ², up to which two fits are in one minimum: a standard error
CENTRE_OFF_M = 3e-4
NEAR = 30.0  # distance of two laws [σ] below which it is found without noise
FEET = 0.6  # share of the width, in the middle, where an uneven base does not touch


@dataclass(frozen=True)
class Truth:
    """One virtual run: block, law, release and noise.

    Parameters
    ----------
    model : str
        The true law.
    block : Block
    parameters : mapping of str to float
        SI units.
    theta0 : float
        Angle of release [rad].
    sigma_theta : float
        Standard deviation of the white noise of θ [rad].
    noise : str
        "white"; "coloured", half of its variance correlated over 5 ms; "hum and drift", white with mains
        hum of 0.5 σ and a drift of 0.5 σ correlated over 2 s.
    """

    model: str
    block: Block
    parameters: Mapping[str, float]
    theta0: float
    sigma_theta: float
    noise: str = "white"


def noise(truth: Truth, n: int, generator) -> np.ndarray:
    """Noise of θ at RATE_HZ, shape (n,) [rad]."""

    def correlated(time_s):
        a = math.exp(-1 / (RATE_HZ * time_s))
        drive = math.sqrt(1 - a * a) * generator.standard_normal(n)
        return lfilter([1.0], [1.0, -a], drive, zi=[a * generator.standard_normal()])[0]

    white = generator.standard_normal(n)
    if truth.noise == "coloured":
        white = math.sqrt(0.5) * (white + correlated(5e-3))
    elif truth.noise == "hum and drift":
        phase = generator.uniform(0, 2 * math.pi)
        hum = np.sin(2 * math.pi * 50 * np.arange(n) / RATE_HZ + phase)
        white = white + 0.5 * math.sqrt(2) * hum + 0.5 * correlated(2.0)
    return truth.sigma_theta * white


def virtual_motion(truth: Truth, generator, time_s=None, theta=None) -> Motion | None:
    """A measured run: θ(t) with noise, and what the hold before it tells; None where the block overturns.

    Parameters
    ----------
    truth : Truth
    generator : numpy.random.Generator
    time_s, theta : ndarray, shape (n_time,), optional
        The true motion [s, rad] where another than the law's is wanted.
    """
    if theta is None:
        time_s = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
        response = simulate(
            truth.model, truth.block, truth.parameters, time_s, theta0=truth.theta0, rtol=1e-10
        )
        if response.outcome == "overturned":
            return None
        theta = response.theta
    hold = int(HOLD_S * RATE_HZ)
    error = noise(truth, hold + len(theta), generator)
    moving = np.flatnonzero(np.abs(theta) > REST_SIGMAS * truth.sigma_theta)
    n = min(len(theta), moving[-1] + 200)
    t0 = T0_STDERR_S * generator.standard_normal()
    return Motion(
        time_s=time_s[:n] + t0,
        theta=theta[:n] + error[hold : hold + n],
        sigma_theta=float(np.std(error[:hold])),
        theta0=truth.theta0 + float(np.mean(error[:hold])),
        theta0_stderr=truth.sigma_theta * (1 if truth.noise == "hum and drift" else 3 / math.sqrt(hold)),
        t0_stderr=T0_STDERR_S,
        fit_start_s=0.0,
    )


def draw_truth(model: str, noises: Sequence[str], generator) -> Truth:
    """A random law, block and noise, over the whole range the models are made for."""
    block, theta0, _ = list(CONFIGURATIONS.values())[generator.integers(3)]
    k = 10 ** generator.uniform(6, 8)
    parameters = {
        "housner": {"r": generator.uniform(0.85, 0.995)},
        "winkler": {"k": k, "c": k * 10 ** generator.uniform(-3, math.log10(2e-2))},
        "hunt_crossley": {"k": k, "lambda": k * generator.uniform(5, 50)},
    }[model]
    sigma = math.radians(10 ** generator.uniform(math.log10(0.005), math.log10(0.05)))
    return Truth(model, block, parameters, theta0, sigma, noises[generator.integers(len(noises))])


def _spread_out(function: Callable, cases: Sequence) -> list:
    """Rows of all cases, on all cores."""
    with ProcessPoolExecutor(cores(), multiprocessing.get_context("spawn")) as pool:
        return [row for rows in pool.map(function, cases, chunksize=4) for row in rows]


def _drawn(model: str, noises: Sequence[str], key: Sequence[int], draw=draw_truth) -> tuple:
    """A random truth whose block does not overturn, its measured run, and how many overturned before it."""
    generator, overturned = np.random.default_rng([SEED, *key]), 0
    while True:
        truth = draw(model, noises, generator)
        motion = virtual_motion(truth, generator)
        if motion is not None:
            return truth, motion, overturned
        overturned += 1


def success(size: str = "full") -> pd.DataFrame:
    """Whether fits from the automatic start end in the minimum that a fit from the truth ends in.

    Parameters
    ----------
    size : str
        "full" or "small".

    Returns
    -------
    pandas.DataFrame
        One row per case: the truth (SI units, sigma_deg in degrees), overturned (draws thrown away before
        it), excess (of the squared residual over that from the truth, in σ²), reached (no excess), reported
        (the program itself says that the fit failed) and fit_s, the time of the fit [s].
    """
    cases = [(model, i) for model in PAPER_MODELS for i in range(SUCCESS_RUNS[size])]
    return pd.DataFrame(_spread_out(_success, cases))


def _success(case) -> list:
    model, i = case
    truth, motion, overturned = _drawn(model, ("white", "coloured"), (1, PAPER_MODELS.index(model), i))
    begin = clock.perf_counter()
    fit = fit_run(model, truth.block, motion)
    elapsed = clock.perf_counter() - begin
    best = fit_record(model, truth.block, [motion], start=list(truth.parameters.values()))
    excess = (np.sum(fit.residual**2) - np.sum(best.residual**2)) / motion.sigma_theta**2
    return [
        {
            "model": model,
            "case": i,
            "noise": truth.noise,
            "height_m": truth.block.height_m,
            "sigma_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "overturned": overturned,
            "excess": excess,
            "reached": bool(excess < EXCESS),
            "reported": not fit.success,
            "message": fit.message,
            "fit_s": elapsed,
        }
    ]


def coverage(size: str = "full") -> pd.DataFrame:
    """Scatter of identified parameters against the Cramér-Rao bound, and whether intervals hold the truth.

    Parameters
    ----------
    size : str
        "full" or "small".

    Returns
    -------
    pandas.DataFrame
        One row per run and parameter, SI units: block, foundation, model, noise, run, parameter, truth,
        value, stderr, ci95_low, ci95_high and bound, the Cramér-Rao bound of white noise; NaN where the fit
        failed.
    """
    cases = [
        (block, foundation, model, noise, i)
        for model in PAPER_MODELS
        for block in CONFIGURATIONS
        for foundation in FOUNDATIONS
        for noise, n in COVERAGE_RUNS[size].items()
        for i in range(n)
    ]
    return pd.DataFrame(_spread_out(_coverage, cases))


def _scene(block: str, foundation: str, model: str, noise: str = "white") -> Truth:
    shape, theta0, _ = CONFIGURATIONS[block]
    return Truth(model, shape, TABLE_2[foundation][model], theta0, math.radians(0.01), noise)


def _coverage(case) -> list:
    block, foundation, model, noise, i = case
    truth = _scene(block, foundation, model, noise)
    key = (
        2,
        list(CONFIGURATIONS).index(block),
        list(FOUNDATIONS).index(foundation),
        PAPER_MODELS.index(model),
        i,
    )
    motion = virtual_motion(truth, np.random.default_rng([SEED, *key, noise == "white"]))
    if motion is None:
        return []
    fit = fit_run(model, truth.block, motion)
    bound = standard_errors(
        model,
        truth.block,
        truth.parameters,
        motion.time_s - motion.time_s[0],
        truth.theta0,
        truth.sigma_theta,
    )
    return [
        {
            "block": block,
            "foundation": foundation,
            "model": model,
            "noise": noise,
            "run": i,
            "parameter": name,
            "truth": truth.parameters[name],
            "value": fit.value[j],
            "stderr": fit.stderr[j],
            "ci95_low": fit.ci95_low[j],
            "ci95_high": fit.ci95_high[j],
            "bound": bound[name],
        }
        for j, name in enumerate(MODELS[model])
    ]


def imperfect_motion(truth: Truth, imperfection: str) -> tuple:
    """θ(t) of a block that is not quite what the law says, by an independent integration.

    Parameters
    ----------
    truth : Truth
        Of the Hunt-Crossley law.
    imperfection : str
        "centre": the centre of mass 0.3 mm off the middle; "uneven": a base that does not touch in the
        middle 60 % of its width; "amplitude": damping from half to one and a half times λ with |θ|/θ₀.

    Returns
    -------
    time_s, theta : ndarray, shape (n_time,)
        [s, rad]
    """
    block, k, lam = truth.block, truth.parameters["k"], truth.parameters["lambda"]
    m, h = block.mass_kg, block.h
    middle = replace(block, contact_width_m=FEET * block.width_m)

    def rates(_, y):
        z, v, theta, w = y
        damping = lam * (0.5 + abs(theta / truth.theta0)) if imperfection == "amplitude" else lam
        a, turn = accelerations(block, k, 0.0, damping, z, v, theta, w)
        force = moment = 0.0
        if imperfection == "centre":
            moment = -m * GRAVITY * CENTRE_OFF_M * math.cos(theta)
        elif imperfection == "uneven":
            force, moment = (-x for x in contact_force(middle, k, 0.0, lam, z, v, theta, w))
        arm = h * math.sin(theta)
        more = (arm * force - moment) / (block.inertia_base - m * arm * arm)
        return [v, a - force / m - arm * more, w, turn + more]

    time_s = np.arange(0.0, LONGEST_S, 1 / RATE_HZ)
    start = [static_depth(block, k, truth.theta0), 0.0, truth.theta0, 0.0]
    motion = solve_ivp(rates, (0, LONGEST_S), start, "DOP853", time_s, rtol=1e-7, atol=1e-11)
    return time_s, motion.y[2]


def model_error(size: str = "full") -> pd.DataFrame:
    """What the identification says of blocks that are not quite what the law says.

    Parameters
    ----------
    size : str
        "full" or "small".

    Returns
    -------
    pandas.DataFrame
        One row per run and parameter of the Hunt-Crossley law: block, foundation, imperfection, run, success,
        told (the residual test says that the law is not the whole truth), widened (standard error over the
        Cramér-Rao bound), error (of the parameter in standard errors), error_percent and epsilon_theta.
    """
    cases = [
        (block, foundation, imperfection, i)
        for block in (CONFIGURATIONS if size == "full" else ["config3"])
        for foundation in FOUNDATIONS
        for imperfection in ("none", "centre", "uneven", "amplitude")
        for i in range(ERROR_RUNS[size])
    ]
    return pd.DataFrame(_spread_out(_model_error, cases))


def _model_error(case) -> list:
    block, foundation, imperfection, i = case
    truth = _scene(block, foundation, "hunt_crossley")
    time_s, theta = imperfect_motion(truth, imperfection)
    key = (3, list(CONFIGURATIONS).index(block), list(FOUNDATIONS).index(foundation), i)
    motion = virtual_motion(truth, np.random.default_rng([SEED, *key]), time_s, theta)
    fit = fit_run("hunt_crossley", truth.block, motion)
    bound = standard_errors(
        "hunt_crossley",
        truth.block,
        truth.parameters,
        time_s[: len(motion.time_s)],
        truth.theta0,
        truth.sigma_theta,
    )
    told = not fit.diagnostics["white"] or fit.diagnostics["residual_over_sigma"] > LOUDER
    return [
        {
            "block": block,
            "foundation": foundation,
            "imperfection": imperfection,
            "run": i,
            "parameter": name,
            "success": fit.success,
            "told": told,
            "widened": fit.stderr[j] / bound[name],
            "error": (fit.value[j] - truth.parameters[name]) / fit.stderr[j],
            "error_percent": 100 * (fit.value[j] / truth.parameters[name] - 1),
            "epsilon_theta": fit.epsilon_theta,
        }
        for j, name in enumerate(MODELS["hunt_crossley"])
    ]


def choice(size: str = "full") -> pd.DataFrame:
    """Whether the choice of model names the law that made a run.

    Parameters
    ----------
    size : str
        "full" or "small".

    Returns
    -------
    pandas.DataFrame
        One row per case: model (the true law), chosen, rival (the nearest other law that is no larger),
        distance (between the true motion and the rival's best, in σ: √Σ(Δθ)²/σ; inf where no other law is
        as small or its fit fails), reason.
    """
    cases = [(model, i) for model in MODELS for i in range(CHOICE_RUNS[size])]
    return pd.DataFrame(_spread_out(_choice, cases))


def _draw_any(model: str, noises, generator) -> Truth:
    """As `draw_truth`; of the general law one damping as there, of the other anything down to a trace."""
    if model != "general":
        return draw_truth(model, noises, generator)
    main, other = ("winkler", "hunt_crossley")[:: generator.choice([-1, 1])]
    truth, trace = draw_truth(main, noises, generator), draw_truth(other, noises, generator).parameters
    (name,) = set(trace) - {"k"}
    k = truth.parameters["k"]
    added = k * trace[name] / trace["k"] * 10 ** generator.uniform(-4, 0)
    return replace(truth, model="general", parameters={**truth.parameters, name: added})


def _choice(case) -> list:
    model, i = case
    truth, motion, _ = _drawn(model, ("white",), (4, list(MODELS).index(model), i), _draw_any)
    fits = {law: fit_run(law, truth.block, motion) for law in PAPER_MODELS}
    found = {law: evidence(fit) for law, fit in fits.items()}
    if is_wanted("general", found):
        found["general"] = evidence(fit_run("general", truth.block, motion))
    chosen, reason = choose_model(found)

    exact = simulate(
        model, truth.block, truth.parameters, motion.time_s - motion.time_s[0], theta0=truth.theta0
    )
    exact = replace(motion, time_s=exact.time, theta=exact.theta, theta0=truth.theta0)
    distance, rival = math.inf, ""
    for law in PAPER_MODELS:
        if law == model or len(MODELS[law]) > len(MODELS[model]) or not fits[law].success:
            continue
        # the squared residual exceeds that of noise by the squared distance, give or take a few σ²
        excess = np.sum(fits[law].residual ** 2) / truth.sigma_theta**2 - len(exact.theta)
        apart = math.sqrt(max(0.0, excess))
        if apart < NEAR:
            apart = np.sqrt(np.sum(fit_run(law, truth.block, exact).residual ** 2)) / truth.sigma_theta
        if apart < distance:
            distance, rival = float(apart), law
    return [
        {
            "model": model,
            "case": i,
            "sigma_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "chosen": chosen,
            "rival": rival,
            "distance": distance,
            "reason": reason,
        }
    ]
