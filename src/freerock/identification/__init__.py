"""One hypothesis on one run: its data, numbers, start, least squares, noise and intervals.

A fit goes `settings` → `problem` → `scan` → `search` (`least_squares`, `pursuit`, `resolution`) →
`nuisances` → `noise` → `likelihood` → `covariance` → `intervals` → `diagnosis` → `fit`.
"""

__all__ = [
    "as_measured",
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
    "swings",
]
