"""Runs and blocks together: means, predictions, uncertainty budget."""

__all__ = [
    "band",
    "estimate",
    "impact_energy",
    "law_error",
    "means",
    "random_effects",
]
