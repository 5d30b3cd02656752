"""How the models' inner loops are compiled."""

from numba import njit


def compiled(**options):
    """Compile with a cache on disk, or without one where no folder for it can be written."""
    options |= {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}

    def decorate(function):
        try:
            return njit(cache=True, **options)(function)
        except RuntimeError:
            return njit(**options)(function)

    return decorate
