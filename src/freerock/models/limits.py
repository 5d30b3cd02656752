"""Bounds of a fit: the frame inside the stability atlas (docs/studies.md) in which every simulation ends."""

K_RANGE = (1e4, 1e11)  # stiffness k [N/m²]
RATIO_RANGE = {"c": (1e-5, 1.0), "lambda": (1e-2, 1e4)}  # damping over stiffness: c/k [s], λ/k [s/m]
WIDTH_RANGE = (0.5, 1.05)  # distance of the corners a block rocks about over its width
