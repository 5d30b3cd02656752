"""Figures: a module each, found by the figure's name, and in it one function, `draw`.

It takes the tables and datasets it draws, the `origin` of their records ("simulated" or "measured"; the
figure says so) and `labels`, printed names of blocks and foundations. It returns the figure, or its pages,
and the numbers drawn; `style.save` writes both. What a figure of a campaign says of these numbers in its
caption, such as the runs drawn, is told by the function `caption` beside. What is read for a figure, and from
where, stands in the workflow's rule of figures.
"""

__all__ = [
    "foundation_effect",
    "looks",
    "misfit_map",
    "models",
    "parameters",
    "plan",
    "predictions",
    "quality",
    "quick_look",
    "restitution",
    "scene",
    "studies",
    "style",
]
