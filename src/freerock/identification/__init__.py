"""Runs to parameters: fits, how well they are known, which law a run needs, what they predict, and plans."""

__all__ = ["choice", "estimate", "fit", "misfit", "plan", "population", "predict"]
