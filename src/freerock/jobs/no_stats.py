"""Keeps lmfit from importing scipy.stats and Matplotlib, 0.3 s of a fit; to be imported before it.

No step of ours uses what lmfit takes of them. A distribution is imported when something of it is asked for.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any


class _Later:
    """A distribution of scipy.stats, which is imported when it is used."""

    def __init__(self, name: str) -> None:
        if name.startswith("__"):
            raise AttributeError(name)
        self.name = name

    def __getattr__(self, asked: str) -> Any:
        if sys.modules.get("scipy.stats") is STATS:
            del sys.modules["scipy.stats"]
        return getattr(getattr(import_module("scipy.stats"), self.name), asked)


STATS = ModuleType("scipy.stats")
vars(STATS)["__getattr__"] = _Later
sys.modules.setdefault("scipy.stats", STATS)
sys.modules.setdefault("matplotlib", None)  # type: ignore[arg-type]
