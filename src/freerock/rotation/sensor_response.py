"""The response of a sensor: its output is a mean over the preceding time.

A sensor that averages gives the mean over a time T, a low pass of the first order with the time constant τ
the mean with the weight exp(-x/τ)/τ of the time x before. Both are a delay, by T/2 and by τ, and a blur
about it. The blur of a motion is its mean over a few moments, by the rules of Gauss and Legendre and of Gauss
and Laguerre: exact for motions that are polynomials of fifth degree in time.
"""

from functools import cache

import numpy as np

from freerock.arrays import Floats

KINDS = ("average", "low_pass")
MOMENTS = 3


def delay_s(response_s: float, kind: str = "average") -> float:
    """By how much a sensor is late [s]; its time is that of the mean, or the time constant."""
    return response_s / 2 if kind == "average" else response_s


def moments(response_s: float, kind: str = "average") -> tuple[Floats, Floats]:
    """Instants [s] beside the one that a sample belongs to, its delay taken off, and their weights."""
    if response_s == 0:
        return np.zeros(1), np.ones(1)
    at, weight = _rule(kind)
    return (at * response_s / 2, weight / 2) if kind == "average" else ((1 - at) * response_s, weight)


@cache
def _rule(kind: str) -> tuple[Floats, Floats]:
    """Abscissas and weights of Gauss and Legendre, or of Gauss and Laguerre."""
    polynomial = np.polynomial
    return (polynomial.legendre.leggauss if kind == "average" else polynomial.laguerre.laggauss)(MOMENTS)
