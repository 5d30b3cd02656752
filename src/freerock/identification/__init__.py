"""Runs to parameters: fits, how well they are known, which law a run needs, what they predict, and plans.

A fit goes `settings` → `problem` → `scan` → `search` (`least_squares`, `pursuit`, `resolution`) → `noise` →
`likelihood` → `covariance` → `intervals` → `diagnosis` → `fit`.
"""

__all__ = [
    "as_measured",
    "between_blocks",
    "candidates",
    "choice",
    "cramer_rao",
    "discrepancy",
    "doubts",
    "estimate",
    "fit",
    "holdout",
    "identified",
    "impact_energy",
    "ladder",
    "misfit",
    "plan",
    "plan_campaign",
    "plan_total",
    "population",
    "predict",
    "random_effects",
    "rivals",
    "screening",
    "sensitivity",
    "settings",
]
