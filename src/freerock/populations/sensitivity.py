"""How much the identified parameters move with what the laboratory knows: contributions to a total
uncertainty.

To first order by the theorem of implicit functions: where the least squares of the residual ρ(x, q) lie, an
input q that moves by dq moves the fitted numbers by dx = -(JᵀJ)⁻¹ Jᵀ dρ, J = ∂ρ/∂x, where ρ is no more than
noise. Of a law that leaves more, whose derivatives' own change counts too, they are rough. (JCGM 100:2008,
5.1: sensitivities c_i and contributions c_i u(x_i).)
"""

from dataclasses import replace

import numpy as np

from freerock.arrays import Floats
from freerock.identification.fit import Fit
from freerock.identification.problem import COARSE, Problem, Samples
from freerock.identification.pursuit import multiplies_errors
from freerock.identification.settings import FitSettings
from freerock.identification.start import posed
from freerock.models.laws import law_of
from freerock.rotation.laboratory import Contributions, Input, Laboratory
from freerock.rotation.view import view_of
from freerock.runs.motion import Motion

SHARE = 0.01  # of its uncertainty, by which an input is moved
TILTS = 0.1  # of its uncertainty, by which a level base is tilted to either side
FARTHEST = 1.0  # by which the logarithm of a force may move then
MOST = 1000  # samples of a run suffice for derivatives


def contributions(fit: Fit, motion: Motion, laboratory: Laboratory, settings: FitSettings) -> Contributions:
    """Contributions of the laboratory's inputs to a fit of one run.

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
    return contributions_at(problem, problem.start_at(fit.values), laboratory)


def contributions_at(problem: Problem, x: Floats, laboratory: Laboratory) -> Contributions:
    """The same where the fitted numbers of a problem of one run lie at x."""
    at = _Minimum(problem, x, laboratory)
    columns = [at.shift(source) for source in laboratory.inputs]
    return Contributions.held(laboratory.inputs, np.reshape(columns, (-1, len(problem.names))).T)


class _Minimum:
    """Where a fit ended, and how it moves with an input."""

    def __init__(self, problem: Problem, x: Floats, laboratory: Laboratory) -> None:
        self.problem, self.x, self.laboratory = problem, x, laboratory
        samples = problem.samples(most=MOST)
        self.curve = problem.curve(x, samples)
        self.residual = self.curve - samples.theta
        self.held = problem.held(x)
        self.jacobian = self._jacobian(problem, x, samples)
        scale = np.sqrt(np.sum(self.jacobian**2, axis=0))
        self.inverse = np.linalg.pinv(self.jacobian / scale) / scale[:, None]

    def _jacobian(self, problem: Problem, x: Floats, samples: Samples) -> Floats:
        central = law_of(problem.model).is_foundation
        return problem.jacobian(x, samples, central)[:, ~self.held]

    def shift(self, source: Input) -> Floats:
        """Of the parameters, for one standard uncertainty of an input, shape (n_parameters,) [SI]."""
        if source.u == 0 or (source.name == "levelled_deg" and "tilt" in self.problem.names):
            return np.zeros(len(self.x))
        if source.name == "mass_kg" and self.problem.varied.all():
            return self._by_mass(source)
        if source.name == "levelled_deg":  # the motions of either tilt are much alike
            ends = [self._end(self.laboratory.moved(source, share)) for share in (TILTS, -TILTS)]
            return np.asarray((ends[0] - ends[1]) / (2 * TILTS))
        if source.name == "response_ms":  # what it does grows with its square
            return np.asarray(self._end(self.laboratory.moved(source, 1.0)) - self.problem.physical(self.x))
        end = self._end(self.laboratory.moved(source, SHARE))
        return np.asarray((end - self.problem.physical(self.x)) / SHARE)

    def _by_mass(self, source: Input) -> Floats:
        """Forces are as the mass: so are k, c and λ, and nothing else changes."""
        shift = np.zeros(len(self.x))
        if law_of(self.problem.model).is_foundation:
            forces = self.problem.is_logarithm
            shift[forces] = self.problem.physical(self.x)[forces] * source.u / self.laboratory.block.mass_kg
        return shift

    def _end(self, moved: Laboratory) -> Floats:
        """Where the fit would have ended for another laboratory, to first order [SI]."""
        problem = self._posed(moved)
        samples, tilted = problem.samples(most=MOST), {"tilt": moved.tilt} if moved.tilt else None
        x = np.array(self.x)
        now, then = (np.array(each.bounds()) for each in (problem, self.problem))
        nearer = np.argmin(np.abs(then - self.x[:, None]), axis=1)
        x[self.held] += (now - then)[np.arange(len(x)), nearer][self.held]
        only_reread = replace(moved, scales=self.laboratory.scales) == self.laboratory
        alike = only_reread and np.array_equal(x, self.x) and "theta0" in self.problem.names
        curve = self.curve if alike else problem.curve(x, samples, added=tilted)
        x[~self.held] -= self.inverse @ (curve - samples.theta - self.residual)
        forces = problem.is_logarithm  # one that the motion does not determine may go anywhere
        x[forces] = np.clip(x[forces], self.x[forces] - FARTHEST, self.x[forces] + FARTHEST)
        return problem.physical(x)

    def _posed(self, moved: Laboratory) -> Problem:
        """The problem that another laboratory would have posed."""
        (motion,) = self.problem.motions
        clock, view = moved.clock / self.laboratory.clock, view_of([*moved.lasers.values()], moved.block)
        read = self.laboratory.reread(np.append(motion.theta, motion.theta0), moved)
        motion = replace(
            motion,
            time_s=motion.time_s * clock,
            fit_start_s=motion.fit_start_s * clock,
            theta=read[:-1],
            theta0=float(read[-1]),
            view=view,
        )
        return replace(self.problem, blocks=(moved.block,), motions=(motion,))
