"""One hypothesis on one run: its data, parameters, start, least squares, noise and intervals.

A fit goes `settings` → `problem` → `start` → `search` (`least_squares`, `diverging_motions`) →
`inputs_with_priors` (`against_noise`, `likelihood`) → `intervals` → `model_discrepancy` → `fit`.
"""

__all__ = [
    "against_noise",
    "diverging_motions",
    "epsilon_theta",
    "fit",
    "inputs_with_priors",
    "intervals",
    "least_squares",
    "likelihood",
    "lmfit_models",
    "model_discrepancy",
    "problem",
    "search",
    "settings",
    "significance_levels",
    "start",
]
