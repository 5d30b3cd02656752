"""Signals that mean nothing."""

import numpy as np


def random_signal(kind, n, draw):
    """A signal of nonsense: noise, walks, steps, swings, with what converters add."""
    base = {
        "noise": lambda: draw.standard_normal(n),
        "walk": lambda: np.cumsum(draw.standard_normal(n)),
        "steps": lambda: np.repeat(draw.standard_normal(n // 50 + 1), 50)[:n],
        "swing": lambda: np.exp(-np.arange(n) / 400) * np.cos(np.arange(n) / draw.uniform(3, 90)),
        "spoilt": lambda: np.round(draw.standard_normal(n), draw.integers(0, 3)),
    }[kind]()
    if kind == "spoilt":
        base[draw.integers(0, n, n // 10 + 1)] = draw.choice([np.nan, np.inf, -np.inf, 0.0, 10.2])
    return base
