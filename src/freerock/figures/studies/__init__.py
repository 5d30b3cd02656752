"""Figures of the studies: one module per study, by its name."""
