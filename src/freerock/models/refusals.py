"""Refusal of what can't be simulated."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats, numbers
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.block_on_bed import State
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import CANDIDATES, DEBONDING, GEOMETRIC, KINEMATICS, LAWS, Rules


def check_scene(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time: ArrayLike,
    start: State,
    rules: Rules,
    rtol: float,
) -> Floats:
    """The instants as an array; raises where an argument is no use."""
    _check_parameters(model, parameters, rules)
    if not rtol > 0:
        raise FreerockError("rtol", f"{rtol} is not positive", "give a tolerance such as 1e-8")
    if not np.all(np.isfinite(start)) or abs(start.theta) > math.pi / 2:
        raise FreerockError(
            "theta0", f"the start is {start.theta:g} rad", "give the angle in rad and the rate in rad/s"
        )
    instants = np.ascontiguousarray(numbers("time", time))
    if instants.ndim != 1 or not np.all(np.isfinite(instants)) or np.any(np.diff(instants) < 0):
        raise FreerockError("time", "not an increasing array of finite instants", "sort it and drop NaN")
    rounded = [name for name, law in LAWS.items() if "edge_radius" in law.may_free]
    if block.edge_radius_m and (model not in rounded or rules.debonding != GEOMETRIC.debonding):
        what = "rounded edges are implemented for geometric debonding only, under "
        raise FreerockError("edge_radius_m", what + ", ".join(rounded), "leave it out")
    return instants


def _check_parameters(model: str, parameters: Mapping[str, float], rules: Rules) -> None:
    """Raise where the parameters are not those of the model, or the rules not implemented for it."""
    if model in CANDIDATES and model not in LAWS:
        own = CANDIDATES[model]
        remedy = f"use {own.law} with Rules(kinematics={own.kinematics!r}) and the block's contact_width_m"
        raise FreerockError("model", f"{model} is a candidate of a fit, not a law", remedy)
    if model not in LAWS:
        raise FreerockError("model", f"unknown model {model!r}", f"use one of {', '.join(LAWS)}")
    law = LAWS[model]
    for name in law.parameters:
        where, unit = f"parameters.{name}", PARAMETERS[name].unit
        if name not in parameters:
            raise FreerockError(where, "missing", f"give {name} [{unit}] for the {model} model")
        value, positive = parameters[name], PARAMETERS[name].fitted_as == "logarithm"
        if not math.isfinite(value) or value < 0 or (positive and value == 0):
            what = f"{value} is not a {'positive' if positive else 'non-negative'} number"
            raise FreerockError(where, what, f"give {name} in {unit}")
        if name == "r" and value > 1:
            raise FreerockError(
                where, f"{value} is above 1", "an impact cannot add energy: give r between 0 and 1"
            )
    known = (("debonding", "rule", DEBONDING), ("kinematics", "kinematics", KINEMATICS))
    for name, kind, choices in known:
        if getattr(rules, name) not in choices:
            what = f"unknown {kind} {getattr(rules, name)!r}"
            raise FreerockError(name, what, f"use {' or '.join(choices)}")
    if not law.allows(rules.debonding, sum(parameters[name] > 0 for name in law.ratios)):
        what = f"the tensionless rule is not available for {' and '.join(law.parameters[1:])} together"
        raise FreerockError("debonding", what, "use geometric")
