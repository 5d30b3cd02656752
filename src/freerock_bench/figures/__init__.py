"""Figures of the studies: a module each, by the study's name, and in it one function, `draw(frame)`.

The frame is the one that `run` of the study gives; `PAGES`, where there are several, names them. Returned
are the figure and the rows drawn.
"""

__all__ = [
    "coverage",
    "parsimony",
    "speed_accuracy",
    "stability",
]
