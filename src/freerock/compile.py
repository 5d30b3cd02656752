"""Compile the numerical kernels once, so that no job compiles them and no two jobs do so at the same time.

`python -m freerock.compile` is a part of `make setup`. Numba keeps what it compiles beside the sources, and
compiles again only a module that has changed.
"""

from typing import Any

import numpy as np

from freerock.models.block import Block
from freerock.models.simulate import simulate_fitted, tangents
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View, as_measured
from freerock.runs.impacts import find_impacts


def compile_kernels() -> None:
    """Call every kernel once, with the types of arguments that an analysis has."""
    block, time_s = Block(1.0, 0.2, 1.0), np.arange(100) / 100
    view = View(block, Laser("vertical", 0.05, units="mm"))
    bed: dict[str, Any] = {"k": 1e6, "c": 1e3, "theta0": 0.05}
    as_measured("winkler", block, bed | {"edge_radius": 1e-3}, time_s[:2], view)
    as_measured("housner", block, {"r": 0.9, "theta0": 0.05, "width": 0.19}, time_s[:2], view)
    for law, numbers, n in (("winkler", bed, 3), ("housner", {"r": 0.9, "theta0": 0.05}, 1)):
        scattered = {**numbers, "impacts": np.zeros(2)}
        rates, passages = np.empty((100, n)), np.full((2, 5), np.nan)
        theta = simulate_fitted(law, block, scattered, time_s, rates=rates, passages=passages)
        view.seen(theta[None], rates[None, :, 0], block, None)
        swings = tangents(law, block, scattered, time_s, (theta, rates, passages))
        out = np.zeros((time_s.size + swings.rates.size, swings.rates.size), order="F")
        swings.by_rates(theta, theta, theta, out)
    find_impacts(time_s, np.cos(9 * time_s), 1e-3, block, theta0=1.0)


if __name__ == "__main__":
    compile_kernels()
