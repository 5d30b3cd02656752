"""Does the choice name the candidate that made a run, and do its intervals hold the truth?"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from freerock.models.laws import CANDIDATES, KINEMATICS, LAWS, Candidate
from freerock.planning.rivals import best_rival, rivals_of
from freerock.runs.motion import Motion
from freerock_bench.naming import answer, identified
from freerock_bench.truths import published, record
from freerock_bench.virtual_run import RATE_HZ, SEED, Row, Truth, draw_truth, rows_of_all

SCATTER = 0.1  # of published parameters, as a logarithm to base 10
COMPLIANT = [(law, kinematics) for law in ("winkler", "hunt_crossley") for kinematics in KINEMATICS]
DISTANCE_SAMPLES = 1000  # of a run, at which the distance from a rival is found


@dataclass(frozen=True)
class Family:
    """Truths that are drawn alike.

    Parameters
    ----------
    draw : callable
        (number of the case, generator) → Truth.
    runs : int
        How many the full study draws.
    rivals : callable, optional
        candidate → the rivals from which the distance is asked for.
    """

    draw: Callable[[int, np.random.Generator], Truth]
    runs: int
    rivals: Callable[[str], tuple[str, ...]] = lambda candidate: ()


def run(size: str = "full") -> pd.DataFrame:
    """Which candidate is named for runs of known truth.

    Returns
    -------
    pandas.DataFrame
        One row per run: family, model (the smallest candidate that holds the truth), case, noise,
        theta0_deg, sigma_theta_deg, true r, k, c, lambda [SI], width_fraction; rival (the nearest of those
        that are asked for) and distance (of the true motion from the rival's best without noise, in σ:
        √Σ(Δθ)²/σ; inf without a rival); then the columns of `freerock_bench.naming.answer`.
    """
    cases = [
        (name, i) for name, family in FAMILIES.items() for i in range(family.runs if size == "full" else 2)
    ]
    return pd.DataFrame(rows_of_all(_choice, cases))


def _choice(case: Any) -> list[Row]:
    name, i = case
    family = FAMILIES[name]
    key = [SEED, 4, list(FAMILIES).index(name), i]
    truth, (motion,) = record(partial(family.draw, i), np.random.default_rng(key))
    law, fraction = CANDIDATES[truth.model], truth.block.b / truth.nominal.b
    candidate = Candidate(law.law, law.kinematics, fraction != 1).name
    rival, distance = _nearest(truth, motion, family.rivals(candidate))
    return [
        {
            "family": name,
            "model": candidate,
            "case": i,
            "noise": truth.noise,
            "theta0_deg": math.degrees(truth.theta0),
            "sigma_theta_deg": math.degrees(truth.sigma_theta),
            **{name: truth.parameters.get(name, math.nan) for name in ("r", "k", "c", "lambda")},
            "width_fraction": fraction,
            "rival": rival,
            "distance": distance,
            **answer(candidate, truth, identified(truth, [motion])),
        }
    ]


def _nearest(truth: Truth, motion: Motion, rivals: tuple[str, ...]) -> tuple[str, float]:
    """The rival that can do best against the true motion without noise, and its distance [σ]."""
    time_s = np.linspace(0.0, motion.time_s[-1], DISTANCE_SAMPLES)
    exact = Motion(time_s, truth.motion(time_s)[0], 0.0, truth.theta0)
    distances = {
        rival: best_rival(rival, truth.nominal, exact).distance(truth.sigma_theta, RATE_HZ)
        for rival in rivals
    }
    nearest = min(distances, key=lambda rival: distances[rival], default="")
    return nearest, distances.get(nearest, math.inf)


def _whole_range(i: int, generator: np.random.Generator) -> Truth:
    """Any law, over the whole range; of the general law one damping so, the other down to a trace."""
    model = list(LAWS)[i % len(LAWS)]
    if not LAWS[model].cases:
        return draw_truth(model, ("white",), generator)
    main, other = LAWS[model].cases[:: generator.choice([-1, 1])]
    truth, trace = (draw_truth(law, ("white",), generator) for law in (main, other))
    (name,) = LAWS[other].dampings
    share = trace.parameters[name] / trace.parameters["k"] * 10 ** generator.uniform(-4, 0)
    return replace(truth, model=model, parameters={**truth.parameters, name: share * truth.parameters["k"]})


def _hunt_crossley(kinematics: str, i: int, generator: np.random.Generator) -> Truth:
    """The published law in six scenes in turn, its parameters somewhat changed."""
    return published("hunt_crossley", kinematics, i, generator, scatter=SCATTER)


def _worn(i: int, generator: np.random.Generator) -> Truth:
    """A rigid block with worn corners."""
    width, r = generator.uniform(0.85, 0.98), generator.uniform(0.80, 0.98)
    drawn = published("housner", "pivoting", i, generator, width_fraction=width)
    return replace(drawn, parameters={"r": r})


def _nearly_rigid(i: int, generator: np.random.Generator) -> Truth:
    """A foundation so stiff and a sensor so loud, at most, that the block can't be told from a rigid one."""
    law, kinematics = COMPLIANT[i % len(COMPLIANT)]
    truth = draw_truth(law, ("white",), generator)
    stiffer, louder = 10 ** generator.uniform(0, 2, 2)
    return replace(
        truth,
        model=Candidate(law, kinematics).name,
        parameters={name: stiffer * value for name, value in truth.parameters.items()},
        sigma_theta=louder * truth.sigma_theta,
    )


def _correlated(noise: str, i: int, generator: np.random.Generator) -> Truth:
    """A published law in six scenes in turn, its parameters somewhat changed, under correlated noise."""
    law, kinematics = COMPLIANT[i % len(COMPLIANT)]
    drawn = published(law, kinematics, i // len(COMPLIANT), generator, scatter=SCATTER)
    return replace(drawn, noise=noise)


def _no_larger(candidate: str) -> tuple[str, ...]:
    """All rivals that are no larger."""
    return rivals_of(candidate, tuple(LAWS), KINEMATICS)


FAMILIES = {
    "whole range": Family(_whole_range, 400, _no_larger),
    "pivoting": Family(partial(_hunt_crossley, "pivoting"), 200),
    "guided": Family(partial(_hunt_crossley, "guided"), 200),
    "worn corners": Family(_worn, 300),
    "nearly rigid": Family(_nearly_rigid, 200, lambda candidate: ("housner_width",)),
    "2 ms": Family(partial(_correlated, "2 ms"), 200),
    "20 ms": Family(partial(_correlated, "20 ms"), 200),
}
