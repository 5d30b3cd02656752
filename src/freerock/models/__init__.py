"""Rocking models: their parameters and units."""

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
