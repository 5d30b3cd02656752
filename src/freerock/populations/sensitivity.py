"""How much the identified parameters move with what the laboratory knows: contributions to a total
uncertainty of a fit that holds its inputs."""

from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.diverging_motions import multiplies_errors
from freerock.identification.fit import Fit
from freerock.identification.inputs_with_priors import INPUTS, Nuisances, contributed, moves
from freerock.identification.problem import RTOL_RESIDUAL, Problem
from freerock.identification.start import posed
from freerock.models.laws import law_of
from freerock.rotation.laboratory import Laboratory
from freerock.rotation.u_total import Contributions
from freerock.runs.motion import Motion


def contributions(fit: Fit, motion: Motion, laboratory: Laboratory, settings: FitSettings) -> Contributions:
    """Contributions of the laboratory's inputs to a fit of one run (`held_contributions`).

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
        NaN of a motion that multiplies errors (`diverging_motions`), for which first order is too little.
    """
    problem = replace(posed(fit.model, (laboratory.block,), (motion,), settings), rtol=RTOL_RESIDUAL).rough()
    unlike = problem.names != fit.parameters  # an impact more or less: no such fit
    if unlike or multiplies_errors(problem, problem.start_at(fit.values)):
        unknown = np.full((len(fit.parameters), len(laboratory.inputs)), np.nan)
        return Contributions.held(laboratory.inputs, unknown)
    return held_contributions(problem, problem.start_at(fit.values), laboratory)


def with_contributions(fit: Fit, motion: Motion, laboratory: Laboratory, settings: FitSettings) -> Fit:
    """A fit of one run with the contributions of the inputs; as it is where it moves them or failed.

    Parameters are those of `contributions`.
    """
    if not fit.success or fit.contributions is not None:
        return fit
    return replace(fit, contributions=contributions(fit, motion, laboratory, settings))


def held_contributions(
    problem: Problem, x: Floats, laboratory: Laboratory, most: int = 1000
) -> Contributions:
    """What the inputs contribute to a fit of one run that holds them, to first order.

    By the theorem of implicit functions: where the least squares of the residual ρ(x, ν) lie, an input ν that
    moves by dν moves the fitted numbers by dx = -(JᵀJ)⁻¹ Jᵀ dρ, J = ∂ρ/∂x, where ρ is no more than noise. Of
    a law that leaves more, whose derivatives' own change counts too, they are rough. (JCGM 100:2008, 5.1:
    sensitivities c_i and contributions c_i u(x_i).) A release angle at its bound moves with what is measured.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    laboratory : Laboratory
        Whose block was fitted.
    most : int
        Samples that suffice for derivatives.
    """
    problem = replace(problem, motions=(replace(problem.motions[0], laboratory=laboratory),))
    nuisances = Nuisances(problem, tuple(each for each in laboratory.inputs if moves(each, problem)))
    samples, n_z, free = problem.samples(most=most), len(nuisances.sources), ~problem.held(x)
    jacobian = problem.jacobian(x, samples, law_of(problem.model).is_foundation)
    by_inputs = nuisances.by_inputs(np.zeros(n_z), x, samples)[: len(jacobian)]
    of_x = np.zeros((len(x), n_z))
    if "theta0" in problem.names and not free[problem.names.index("theta0")]:
        ends = INPUTS.step * np.concatenate([np.eye(n_z), -np.eye(n_z)])
        up, down = np.split(np.array([nuisances.posed(z).motions[0].theta0 for z in ends]), 2)
        of_x[problem.names.index("theta0")] = (up - down) / (2 * INPUTS.step)
    own = jacobian[:, free]
    scale = np.maximum(np.linalg.norm(own, axis=0), np.finfo(float).tiny)
    of_x[free] = -(np.linalg.pinv(own / scale) @ (by_inputs + jacobian @ of_x)) / scale[:, None]
    return contributed(nuisances, x, of_x)
