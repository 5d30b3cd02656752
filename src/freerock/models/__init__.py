"""Physics: blocks, laws of the foundation, their motion. Imports nothing of the pipeline."""

__all__ = ["block", "contact", "ground", "housner", "laws", "simulate"]
