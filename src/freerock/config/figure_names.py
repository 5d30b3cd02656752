"""Names of the figures in the order of the report; each is a module of `freerock.figures`."""

from typing import TYPE_CHECKING, Literal, TypeAlias

FIGURES: tuple[str, ...] = ("set_up", "foundation_effect", "comparison", "restitution", "parameters")
FIGURES += ("predictions", "residuals", "backbone")
if TYPE_CHECKING:  # words known only at run time
    Figure: TypeAlias = str
else:
    Figure = Literal[*FIGURES]
"""Figures of a campaign."""
