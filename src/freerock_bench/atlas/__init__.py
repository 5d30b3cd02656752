"""The stability atlas in parts: what makes a cell, the maps of integration, and those of fits."""

__all__ = ["cells", "fits", "integration"]
