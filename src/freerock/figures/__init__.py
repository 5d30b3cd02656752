"""Figures: one function each, which returns the figure and the numbers drawn in it; `save` writes both."""
