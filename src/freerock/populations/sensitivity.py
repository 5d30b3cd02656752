"""How much the identified parameters move with what the laboratory knows: contributions to a total
uncertainty of a fit that holds its inputs."""

from dataclasses import replace

import numpy as np

from freerock.identification.fit import Fit
from freerock.identification.nuisances import held_contributions
from freerock.identification.problem import COARSE
from freerock.identification.pursuit import multiplies_errors
from freerock.identification.settings import FitSettings
from freerock.identification.start import posed
from freerock.rotation.laboratory import Contributions, Laboratory
from freerock.runs.motion import Motion


def contributions(fit: Fit, motion: Motion, laboratory: Laboratory, settings: FitSettings) -> Contributions:
    """Contributions of the laboratory's inputs to a fit of one run (`nuisances.held_contributions`).

    Parameters
    ----------
    fit : Fit
        Of one run, to be used.
    motion : Motion
        The run.
    laboratory : Laboratory
        Whose block was fitted.
    settings : FitSettings
        Those of the fit.

    Returns
    -------
    Contributions
        NaN of a motion that multiplies errors (`pursuit`), for which first order is too little.
    """
    problem = replace(posed(fit.model, (laboratory.block,), (motion,), settings), rtol=COARSE).rough()
    unlike = problem.names != fit.parameters  # an impact more or less: no such fit
    if unlike or multiplies_errors(problem, problem.start_at(fit.values)):
        unknown = np.full((len(fit.parameters), len(laboratory.inputs)), np.nan)
        return Contributions.held(laboratory.inputs, unknown)
    return held_contributions(problem, problem.start_at(fit.values), laboratory)
