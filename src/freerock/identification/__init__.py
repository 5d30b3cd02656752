"""One hypothesis on one run: its data, parameters, start, least squares, noise and intervals.

A fit goes `settings` → `problem` → `start` → `search` (`least_squares`, `pursuit`) → `nuisances`
(`against_noise`, `likelihood`) → `intervals` → `model_discrepancy` → `fit`.
"""

__all__ = [
    "against_noise",
    "epsilon_theta",
    "fit",
    "intervals",
    "least_squares",
    "levels",
    "likelihood",
    "lmfit_models",
    "model_discrepancy",
    "nuisances",
    "problem",
    "pursuit",
    "search",
    "settings",
    "start",
]
