"""The problems of the studies of speed: the blocks and laws of the paper's tables."""

import math
from importlib.util import find_spec

from freerock.models.published import BLOCKS, PUBLISHED_BLOCK, RELEASE_ANGLES, TABLE_2
from freerock_bench.methods.problem import Problem

SAMPLING_HZ = 2000.0
NOISE_RAD = math.radians(0.01)  # of a sample of a laser
SPAN_S = {"full": 5.0, "small": 1.0}
ROUNDS = {"full": 7, "small": 2}


def scenes(size: str = "full") -> dict[tuple[str, str, str], Problem]:
    """The scenes measured, by name: block, foundation and model.

    Parameters
    ----------
    size : str
        "full", or "small": one scene of each model.

    Returns
    -------
    dict of (str, str, str) to Problem
        Keys are block, foundation, model.
    """
    named = [(block, foundation, "hunt_crossley") for block in BLOCKS for foundation in TABLE_2]
    for block in BLOCKS:
        if block == PUBLISHED_BLOCK:
            named += [(block, foundation, "winkler") for foundation in TABLE_2]
        named.append((block, "marble", "housner"))
    if size == "small":
        named = [key for key in named if key[:2] == (PUBLISHED_BLOCK, "marble")]
    return {
        (name, foundation, model): Problem(
            model, BLOCKS[name], TABLE_2[foundation][model], RELEASE_ANGLES[name]
        )
        for name, foundation, model in named
    }


def cyrk_installed() -> bool:
    """Whether the optional package CyRK can be compared with."""
    return find_spec("CyRK") is not None
