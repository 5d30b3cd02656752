"""Runs and blocks together: means, predictions, uncertainty budget, misfit maps."""

__all__ = [
    "between_blocks",
    "estimate",
    "impact_energy",
    "means",
    "misfit",
    "predict",
    "random_effects",
    "sensitivity",
    "shared_foundation",
]
