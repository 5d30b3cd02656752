"""The modules that draw a campaign's figures, in the order of the report."""

from freerock.figures import (
    backbone,
    comparison,
    foundation_effect,
    parameters,
    predictions,
    residuals,
    restitution,
    set_up,
)

FIGURES = (set_up, foundation_effect, comparison, restitution, parameters, predictions, residuals, backbone)
