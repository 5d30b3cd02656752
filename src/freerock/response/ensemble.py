"""An ensemble of responses: ground motions, times their scales, times draws of the parameters."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, law_of
from freerock.models.simulate import Solver, simulate
from freerock.response.motions import Accelerogram, measures

RTOL = 1e-5  # of θ_cr per step: a trajectory is one of an ensemble, chaos makes more digits worth nothing
AFTER = 6.0  # times 1/p that are followed after the ground has come to rest
FINE = 40.0  # samples in 1/p, in which the highest rotation is sought
RESPONSE_COLUMNS = [
    "motion",
    "scale",
    "pga_g",
    "pgv_m_s",
    "pgv_over_pga_s",
    "draw",
    "max_theta_ratio",
    "overturned",
]
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
        Columns `RESPONSE_COLUMNS`, a row per motion, scale and set: the highest |θ| over θ_cr, 1 and more
        where it overturned; NaN of both where the integration failed.
    """
    law, rules, solver = CANDIDATES[model].law, CANDIDATES[model].rules(debonding), Solver(rtol)
    rigid = not law_of(model).is_foundation
    rows: list[tuple[object, ...]] = []
    for motion in motions:
        until = float(motion.time_s[-1]) + AFTER / block.p
        time_s = np.linspace(0.0, until, max(2, math.ceil(until * block.p * FINE)))
        for measure in measures(motion, scales):
            ground = motion.scaled(measure["scale"])
            stands = rigid and measure["pga_g"] <= block.b / block.h  # it is not lifted by less
            for number, values in enumerate(parameters):
                ratio = over = 0.0
                if not stands:
                    found = simulate(
                        law, block, values, time_s, base_excitation=ground, rules=rules, solver=solver
                    )
                    over = math.nan if found.outcome in FAILED else float(found.outcome == "overturned")
                    highest = float(np.nanmax(np.abs(found.theta), initial=0.0)) / block.theta_cr
                    ratio = over if math.isnan(over) else max(highest, over)
                rows.append((motion.name, *measure.values(), number, ratio, over))
    return pd.DataFrame(rows, columns=RESPONSE_COLUMNS)
