"""freerock: free-rocking tests, from laser volts to identified models.

The public names below load what they need when they are first used, so that `import freerock` costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from freerock.acquisition import list_channels, read_record
    from freerock.compare import epsilon_theta
    from freerock.config import load_campaign, load_config
    from freerock.datasets import open_fits, open_record
    from freerock.errors import FreerockError
    from freerock.identify import Fit, fit_record, fit_run
    from freerock.impacts import Impacts, find_impacts
    from freerock.laser import Laser
    from freerock.models.block import Block
    from freerock.models.ground import GroundMotion, accelerogram, pulse
    from freerock.models.simulate import Response, simulate
    from freerock.motion import Motion
    from freerock.rotation import rotation as find_rotation
    from freerock.runs import Run, find_runs

_ROOMS = {  # module: the public names it holds
    "acquisition": ("list_channels", "read_record"),
    "compare": ("epsilon_theta",),
    "config": ("load_campaign", "load_config"),
    "datasets": ("open_fits", "open_record"),
    "errors": ("FreerockError",),
    "identify": ("Fit", "fit_record", "fit_run"),
    "impacts": ("Impacts", "find_impacts"),
    "laser": ("Laser",),
    "models.block": ("Block",),
    "models.ground": ("GroundMotion", "accelerogram", "pulse"),
    "models.simulate": ("Response", "simulate"),
    "motion": ("Motion",),
    "rotation": ("find_rotation",),
    "runs": ("Run", "find_runs"),
}
_OWN_NAMES = {"find_rotation": "rotation"}  # where the name of the module is in the way

__all__ = [
    "Block",
    "Fit",
    "FreerockError",
    "GroundMotion",
    "Impacts",
    "Laser",
    "Motion",
    "Response",
    "Run",
    "accelerogram",
    "epsilon_theta",
    "find_impacts",
    "find_rotation",
    "find_runs",
    "fit_record",
    "fit_run",
    "list_channels",
    "load_campaign",
    "load_config",
    "open_fits",
    "open_record",
    "pulse",
    "read_record",
    "simulate",
]


def __getattr__(name: str) -> Any:
    for room, names in _ROOMS.items():
        if name in names:
            found = getattr(importlib.import_module(f"freerock.{room}"), _OWN_NAMES.get(name, name))
            globals()[name] = found
            return found
    raise AttributeError(f"module 'freerock' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
