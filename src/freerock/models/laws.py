"""Rocking models: their parameters, units and bounds."""

# "general" is the law f = k z + c ż + λ z ż; Winkler's is its case λ = 0, Hunt and Crossley's its case c = 0.
MODELS = {
    "housner": ("r",),
    "winkler": ("k", "c"),
    "hunt_crossley": ("k", "lambda"),
    "general": ("k", "c", "lambda"),
}

PAPER_MODELS = ("housner", "winkler", "hunt_crossley")  # doi:10.1016/j.proeng.2017.09.024

UNITS = {
    "r": "1",
    "k": "N m-2",
    "c": "N s m-2",
    "lambda": "N s m-3",
    "width": "m",
    "theta0": "rad",
    "t0": "s",
}

# Bounds of a fit: the frame inside the stability atlas (docs/studies.md) in which every simulation ends.
K_RANGE = (1e4, 1e11)  # stiffness k [N/m²]
RATIO_RANGE = {"c": (1e-5, 1.0), "lambda": (1e-2, 1e4)}  # damping over stiffness: c/k [s], λ/k [s/m]
WIDTH_RANGE = (0.5, 1.05)  # distance of the corners a block rocks about over its width

MODEL_LABELS = {
    "housner": "Housner",
    "winkler": "Winkler",
    "hunt_crossley": "Hunt–Crossley",
    "general": "General",
}
SYMBOLS = {"r": "r", "k": "k", "c": "c", "lambda": "λ", "theta0": "θ₀", "t0": "t₀", "width": "2b"}
