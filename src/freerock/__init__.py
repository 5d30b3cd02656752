"""freerock: free-rocking tests, from laser volts to identified models.

`__init__.pyi` lists the public names. They load what they need when they are first used, so that
`import freerock` costs nothing.
"""

import ast
import importlib
from pathlib import Path
from typing import Any

_LISTED = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
_MODULES = {each.names[0].name: each.module for each in _LISTED if isinstance(each, ast.ImportFrom)}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'freerock' has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(_MODULES[name]), name)
    return found


def __dir__() -> list[str]:
    return __all__
