"""Figures of the studies: a module each, by the study's name, and in it one function, `draw(frame, labels)`.

The frame is the one that `run` of the study gives; `labels` are printed names of blocks and foundations, for
the figures that name them. Returned are the figure, or its pages, and the rows drawn.
"""

__all__ = [
    "bits",
    "confusion",
    "cost",
    "coverage",
    "paper",
    "shared",
    "speed_accuracy",
    "stability",
]
