"""Truths of the studies of the choice: published laws, worn corners, records with holds and rests."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from freerock.models.laws import LAWS, Candidate
from freerock.models.published import TABLE_2
from freerock.runs.motion import Motion
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.virtual_run import Truth, virtual_motion

ANGLES = (0.6, 1.0)  # of the release angle of table 1
SIGMA_DEG = (0.005, 0.05)
STILL_S = (1.0, 3.0)  # shortest and longest hold, and rest


def place(i: int) -> tuple[str, str]:
    """Block and foundation of the i-th of six scenes, and so on in turn."""
    blocks, foundations = list(CONFIGURATIONS), list(FOUNDATIONS)
    return blocks[i % len(blocks)], foundations[i // len(blocks) % len(foundations)]


def table_2(law: str, foundation: str) -> dict[str, float]:
    """Parameters of table 2; of a law with cases the last one's stiffness and half of each one's damping."""
    published = TABLE_2[foundation]
    if not LAWS[law].cases:
        return dict(published[law])
    halves = {name: published[case][name] / 2 for case in LAWS[law].cases for name in LAWS[case].ratios}
    own = {"k": published[LAWS[law].cases[-1]]["k"], **halves}
    return {name: own[name] for name in LAWS[law].parameters}


def published(
    law: str,
    kinematics: str,
    i: int,
    generator: np.random.Generator,
    *,
    width_fraction: float = 1.0,
    scatter: float = 0.0,
) -> Truth:
    """A law of table 2 in the i-th scene, from an angle and with white noise that are drawn.

    Parameters
    ----------
    law, kinematics : str
    i : int
        Number of the scene.
    generator : numpy.random.Generator
    width_fraction : float
        Contact width over the width.
    scatter : float
        By how much, at most, each parameter is off that of the table, as a logarithm to base 10.
    """
    block, foundation = place(i)
    shape, angle, _ = CONFIGURATIONS[block]
    values = {
        name: value * 10 ** generator.uniform(-scatter, scatter)
        for name, value in table_2(law, foundation).items()
    }
    low, high = map(math.log10, SIGMA_DEG)
    return Truth(
        Candidate(law, kinematics).name,
        replace(shape, contact_width_m=width_fraction * shape.width_m),
        values,
        angle * generator.uniform(*ANGLES),
        math.radians(10 ** generator.uniform(low, high)),
    )


def record(
    draw: Callable[[np.random.Generator], Truth], generator: np.random.Generator
) -> tuple[Truth, Motion]:
    """A truth whose block does not overturn, and a run of it with hold and rest; drawn until found."""
    while True:
        truth = draw(generator)
        hold, rest = generator.uniform(*STILL_S, 2)
        if run := virtual_motion(truth, generator, still_s=(hold, rest)):
            return truth, run
