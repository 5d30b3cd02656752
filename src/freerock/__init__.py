"""freerock: free-rocking tests, from laser volts to identified models.

The public names below load what they need when they are first used, so that `import freerock` costs nothing.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from freerock.config.campaign import load_campaign, load_config
    from freerock.config.defaults import FitSettings, ImpactLimits, RotationOptions, RunLimits
    from freerock.errors import FreerockError
    from freerock.identification.epsilon_theta import epsilon_theta
    from freerock.identification.fit import Fit, fit_record, fit_run
    from freerock.identification.lmfit_models import HousnerModel, HuntCrossleyModel, WinklerModel
    from freerock.models.block import Block
    from freerock.models.contact import State
    from freerock.models.ground import GroundMotion, accelerogram, pulse
    from freerock.models.laws import Rules
    from freerock.models.simulate import Response, Solver, simulate
    from freerock.products.estimates import parameters_in
    from freerock.products.netcdf import open_fits, open_record
    from freerock.records.read import list_channels, read_record
    from freerock.rotation.faults import SignalQuality
    from freerock.rotation.rotation import find_rotation
    from freerock.rotation.sensor import Laser
    from freerock.rotation.view import view_of
    from freerock.runs.by_hand import ByHand
    from freerock.runs.impacts import Impacts, find_impacts
    from freerock.runs.motion import Motion
    from freerock.runs.quiet import quiet_stretches, sensor_noise
    from freerock.runs.segment import Run, find_runs

_ROOMS = {  # module: the public names it holds
    "config.campaign": ("load_campaign", "load_config"),
    "config.defaults": ("FitSettings", "ImpactLimits", "RotationOptions", "RunLimits"),
    "errors": ("FreerockError",),
    "identification.epsilon_theta": ("epsilon_theta",),
    "identification.fit": ("Fit", "fit_record", "fit_run"),
    "identification.lmfit_models": ("HousnerModel", "HuntCrossleyModel", "WinklerModel"),
    "models.block": ("Block",),
    "models.contact": ("State",),
    "models.ground": ("GroundMotion", "accelerogram", "pulse"),
    "models.laws": ("Rules",),
    "models.simulate": ("Response", "Solver", "simulate"),
    "products.estimates": ("parameters_in",),
    "products.netcdf": ("open_fits", "open_record"),
    "records.read": ("list_channels", "read_record"),
    "rotation.faults": ("SignalQuality",),
    "rotation.rotation": ("find_rotation",),
    "rotation.sensor": ("Laser",),
    "rotation.view": ("view_of",),
    "runs.by_hand": ("ByHand",),
    "runs.impacts": ("Impacts", "find_impacts"),
    "runs.motion": ("Motion",),
    "runs.quiet": ("quiet_stretches", "sensor_noise"),
    "runs.segment": ("Run", "find_runs"),
}

__all__ = [
    "Block",
    "ByHand",
    "Fit",
    "FitSettings",
    "FreerockError",
    "GroundMotion",
    "HousnerModel",
    "HuntCrossleyModel",
    "ImpactLimits",
    "Impacts",
    "Laser",
    "Motion",
    "Response",
    "RotationOptions",
    "Rules",
    "Run",
    "RunLimits",
    "SignalQuality",
    "Solver",
    "State",
    "WinklerModel",
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
    "parameters_in",
    "pulse",
    "quiet_stretches",
    "read_record",
    "sensor_noise",
    "simulate",
    "view_of",
]


def __getattr__(name: str) -> Any:
    for room, names in _ROOMS.items():
        if name in names:
            found = getattr(importlib.import_module(f"freerock.{room}"), name)
            globals()[name] = found
            return found
    raise AttributeError(f"module 'freerock' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
