"""Runs and blocks together: means, predictions, uncertainty budget."""

__all__ = [
    "between_blocks",
    "estimate",
    "impact_energy",
    "means",
    "predict",
    "random_effects",
    "sensitivity",
    "shared_foundation",
]
