"""Rocking models: their parameters and units."""

MODELS = {"housner": ("r",), "winkler": ("k", "c"), "hunt_crossley": ("k", "lambda")}

UNITS = {"r": "1", "k": "N m-2", "c": "N s m-2", "lambda": "N s m-3", "theta0": "rad", "t0": "s"}
