"""Free-rocking runs in θ(t), the impacts in a run, and the input of a fit.

`segment.find_runs` finds the runs and judges them (`reasons_as_measured`), `impacts.find_impacts` the impacts
of one.
"""

__all__ = [
    "beginning",
    "by_hand",
    "impacts",
    "measured_total",
    "motion",
    "release",
    "runs_with_impacts",
    "segment",
    "uneven_restitution",
    "verdict",
]
