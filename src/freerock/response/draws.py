"""Draws of a law's parameters: of their mean, or of the next run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from freerock.errors import FreerockError
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import MODELS


@dataclass(frozen=True)
class KnownParameter:
    """A parameter: its mean and its standard uncertainty, in the unit of the parameter.

    The uncertainty is u_total of the mean, or that of the next run.
    """

    mean: float
    u: float = 0.0


def drawn(model: str, known: Mapping[str, KnownParameter], n: int, seed: int = 0) -> list[dict[str, float]]:
    """Sets of parameters [SI]: the means first, then n - 1 draws.

    Positive parameters are drawn as logarithms; r is drawn as it is, and kept within 0 and 1.

    Parameters
    ----------
    model : str
    known : mapping of str to KnownParameter
        Of each parameter of the law.
    n : int
        Number of sets.
    seed : int
        Same seed, same sets.

    Raises
    ------
    FreerockError
        A parameter that is missing, or is no positive number.
    """
    names, draw = MODELS[model], np.random.default_rng(seed)
    for name in names:
        if name not in known:
            raise FreerockError(f"parameters of {model}", f"{name} is missing", f"give {', '.join(names)}")
        if not (known[name].mean > 0 and known[name].u >= 0 and math.isfinite(known[name].u)):
            what = f"{name} is {known[name].mean:g} with an uncertainty of {known[name].u:g}"
            raise FreerockError(f"parameters of {model}", what, "give positive numbers")
    sets = [{name: known[name].mean for name in names}]
    for _ in range(n - 1):
        each = {}
        for name in names:
            mean, u, z = known[name].mean, known[name].u, float(draw.normal())
            if PARAMETERS[name].is_logarithm:
                each[name] = mean * math.exp(z * u / mean)
            else:
                each[name] = min(max(mean + z * u, 0.0), 1.0)
        sets.append(each)
    return sets
