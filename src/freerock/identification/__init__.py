"""One hypothesis on one run: its data, parameters, start, least squares, noise and intervals.

A fit goes `settings` → `problem` → `start` → `search` (`least_squares`, `pursuit`) → `nuisances` (`noise`,
`likelihood`) → `intervals` → `model_discrepancy` → `fit`.
"""

__all__ = [
    "epsilon_theta",
    "fit",
    "intervals",
    "least_squares",
    "levels",
    "likelihood",
    "lmfit_models",
    "model_discrepancy",
    "noise",
    "nuisances",
    "problem",
    "pursuit",
    "search",
    "settings",
    "start",
]
