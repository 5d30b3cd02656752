"""Names of the figures in the order of the report; each is a module of `freerock.figures`."""

from typing import TYPE_CHECKING, Literal, TypeAlias

FIGURES: tuple[str, ...] = ("set_up", "models", "residuals", "decay", "backbone", "restitution", "parameters")
FIGURES += ("predictions", "contact_force")
FIGURES_BY_DEFAULT = FIGURES
FIGURES += ("foundation_effect", "misfit_map", "energy", "phase_portrait", "evidence", "budget", "parts")
FIGURES += ("pulls", "overturning")
if TYPE_CHECKING:  # words known only at run time
    Figure: TypeAlias = str
else:
    Figure = Literal[*FIGURES]
