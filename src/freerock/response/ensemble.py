"""An ensemble of responses: ground motions, times their scales, times draws of the parameters."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, law_of
from freerock.models.simulate import Solver, simulate
from freerock.response.motions import Accelerogram, measures

RTOL = 1e-5  # of θ_cr per step: a trajectory is one of an ensemble, chaos makes more digits worth nothing
AFTER = 6.0  # times 1/p that are followed after the ground has come to rest
FINE = 40.0  # samples in 1/p, in which the highest rotation is sought
COLUMNS = ["motion", "scale", "pga_g", "pgv_m_s", "pgv_over_pga_s", "draw", "max_theta_ratio", "overturned"]
FAILED = ("step_limit", "non_finite")


def respond(
    model: str,
    block: Block,
    parameters: Sequence[Mapping[str, float]],
    motions: Sequence[Accelerogram],
    scales: Sequence[float] = (1.0,),
    debonding: str = "geometric",
    rtol: float = RTOL,
) -> pd.DataFrame:
    """What a block does under ground motions, from rest.

    Parameters
    ----------
    model : str
        A candidate of `models.laws`, whose kinematics it has.
    block : Block
    parameters : sequence of mapping
        Sets of the law's parameters [SI].
    motions : sequence of Accelerogram
    scales : sequence of float
        Factors on every motion.
    debonding : str
    rtol : float
        Of the integrator, relative to θ_cr.

    Returns
    -------
    pandas.DataFrame
        Columns `COLUMNS`, a row per motion, scale and set: the highest |θ| over θ_cr, 1 and more where it
        overturned; NaN of both where the integration failed.
    """
    rows = [
        row for motion in motions for row in _rows(model, block, parameters, motion, scales, debonding, rtol)
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def _rows(
    model: str,
    block: Block,
    parameters: Sequence[Mapping[str, float]],
    motion: Accelerogram,
    scales: Sequence[float],
    debonding: str,
    rtol: float,
) -> Iterator[tuple[object, ...]]:
    """The rows of one motion."""
    until = float(motion.time_s[-1]) + AFTER / block.p
    time_s = np.linspace(0.0, until, max(2, math.ceil(until * block.p * FINE)))
    law, rules, solver = CANDIDATES[model].law, CANDIDATES[model].rules(debonding), Solver(rtol)
    uplift = block.b / block.h
    for measure in measures(motion, scales):
        ground = motion.scaled(measure["scale"])
        stands = not law_of(model).is_foundation and measure["pga_g"] <= uplift
        for number, values in enumerate(parameters):
            ratio, outcome = 0.0, "at_rest"
            if not stands:  # a rigid block is not lifted by less
                found = simulate(
                    law, block, values, time_s, base_excitation=ground, rules=rules, solver=solver
                )
                outcome = found.outcome
                ratio = float(np.nanmax(np.abs(found.theta), initial=0.0)) / block.theta_cr
            over = outcome == "overturned"
            if outcome in FAILED:
                ratio = math.nan
            elif over:
                ratio = max(ratio, 1.0)
            failed = outcome in FAILED
            yield motion.name, *measure.values(), number, ratio, math.nan if failed else float(over)
