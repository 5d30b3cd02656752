"""One hypothesis on one run: its data, numbers, start, least squares, noise and intervals.

A fit goes `settings` → `problem` → `start` → `search` (`least_squares`, `pursuit`) → `nuisances` → `noise` →
`likelihood` → `covariance` → `intervals` → `diagnosis` → `fit`.
"""

__all__ = [
    "diagnosis",
    "discrepancy",
    "estimate",
    "fit",
    "least_squares",
    "levels",
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
