"""What a fit knows at its end: covariance by noise, inputs and scatter, and pulls of the inputs."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from freerock.arrays import Floats, Indices, Mask
from freerock.identification.goodness import Goodness, goodness, level_of, louder, minus_two_log, through
from freerock.identification.posed import Ended, Posed, tied
from freerock.identification.run_model import Point
from freerock.identification.scatter import Told
from freerock.models.free_parameters import LOGARITHMS, PARAMETERS
from freerock.models.laws import law_of
from freerock.noise.spectrum import Noise
from freerock.runs.u_of_measured import Contributions

WORN_M = (
    3e-4  # prior standard uncertainty of a contact width that is freed [m]: that of one measured by a rule
)
TENSE = 0.01  # chance of the shifts of the inputs, from which their uncertainty grows
SEEN_SHARE = 0.05  # of the prior's variance of an input, that a run must take away to tell its shift
SEEN = 1.0  # share of its prior's information, from which the run and not the prior tells a nuisance


@dataclass(frozen=True, eq=False)
class Posterior:
    """The linear model of a run where its fit ended.

    Parameters
    ----------
    posed : Posed
    at : Point
    noise : Noise
        Of the sensor at rest.
    theta : ndarray, shape (n_time,)
        The curve at the samples [rad].
    rows : ndarray, shape (n_rows, n_all)
        Derivatives of `Posed.residual` by all numbers, inputs and impacts, in this order.
    varied : ndarray of bool, shape (n_all,)
        What the fit moved.
    ties : ndarray, shape (n_all, n_varied)
        Derivatives of all by what the fit moved.
    """

    posed: Posed
    at: Point
    noise: Noise
    theta: Floats
    rows: Floats
    varied: Mask
    ties: Floats

    @classmethod
    def of(cls, ended: Ended) -> "Posterior":
        """At the end of a fit."""
        posed, at, parameters = ended.posed, ended.at, ended.result.params
        theta = posed.model.means(at, posed.samples, posed.rtol)
        rows = posed.jacobian(at, posed.model.by_inputs(at, posed.samples, posed.rtol))
        varied = np.array([each.vary for each in parameters.values()])
        ties = np.eye(len(varied))[:, varied]
        if any(each.expr for each in parameters.values()):
            ties = tied(parameters, np.flatnonzero(varied).tolist())
        return cls(posed, at, posed.model.noise, theta, rows, varied, ties)

    @property
    def n_names(self) -> int:
        """Numbers of the law and of the release; the inputs that the fit moves follow, then the impacts."""
        return len(self.posed.model.names)

    @cached_property
    def residual(self) -> Floats:
        """Model less measurement, averaged as the noise is [rad], shape (n,)."""
        return self.theta - self.posed.samples.measured

    @cached_property
    def inverse(self) -> Floats:
        """Covariance under noise of the level and the priors, shape (n_all, n_all); 0 of what is held."""
        rows = self.rows @ self.ties
        scale = np.linalg.norm(rows, axis=0)
        scale[scale == 0] = 1.0
        scaled = rows / scale
        own = np.linalg.pinv(scaled.T @ scaled, hermitian=True) / np.outer(scale, scale)
        return np.asarray(self.ties @ own @ self.ties.T)

    @cached_property
    def step(self) -> Floats:
        """Step to the minimum of the linear model, shape (n_all,); 0 where a search came to its end."""
        half_slope = self.rows.T @ self.posed.residual(self.at, self.theta)
        return np.asarray(-self.inverse @ half_slope)

    @property
    def ahead(self) -> float:
        """Fall of the objective that the linear model still predicts; 0 at a minimum."""
        return float(np.sum((self.rows @ self.step) ** 2))

    @cached_property
    def covariance(self) -> Floats:
        """Covariance of all by noise as its spectrum has it and by the priors, shape (n_all, n_all).

        (H⁻¹ B H⁻¹), with H that of the objective and B of its gradient: the sandwich of White 1982
        (doi:10.2307/1912526). A residual that does not agree with the noise counts octave by octave.
        """
        n = len(self.residual)
        samples = self.rows[:n]
        own = self.rows[n:].T @ self.rows[n:]
        middle = through(louder(self.noise, self.goodness), samples) / self.posed.level**2 + own
        found = self.inverse @ middle @ self.inverse
        return np.asarray(0.5 * (found + found.T))

    @cached_property
    def goodness(self) -> Goodness:
        """The residual beside the noise; what the run tells of inputs and impacts counts as fitted.

        The run itself determines the numbers, and directions of the nuisances.
        """
        law = self.varied.copy()
        law[self.n_names :] = False
        nuisance = self.varied & ~law
        own = self.rows[: len(self.residual), law]
        others = self.rows[: len(self.residual), nuisance] * self._prior_u[nuisance]
        if others.shape[1]:
            alone = without(own, others)
            values, vectors = np.linalg.eigh(alone.T @ alone)
            own = np.hstack([own, others @ vectors[:, values > SEEN]])
        return goodness(self.residual, own, self.noise)

    @cached_property
    def _prior_u(self) -> Floats:
        """Prior standard uncertainty of each number, shape (n_all,); infinite of those of the law."""
        found = np.full(len(self.varied), np.inf)
        names = list(self.posed.model.names)
        for name, _, u in self.posed.release:
            found[names.index(name)] = u
        first = self.n_names + self.at.inputs.size
        found[self.n_names : first], found[first:] = 1.0, self.posed.sigma_r
        return found

    @cached_property
    def told(self) -> Told:
        """What the samples tell of the impacts."""
        first = self.n_names + self.at.inputs.size
        # a δ that leaves no trace tells nothing
        with_prior = np.linalg.pinv(self.inverse[first:, first:], hermitian=True)
        precision = with_prior - np.eye(self.at.impacts.size) / self.posed.sigma_r**2
        return Told(0.5 * (precision + precision.T), with_prior @ self.at.impacts)

    def level(self, own: Indices | None = None) -> float:
        """s that numbers meet: of the noise, times what the residual has more [rad].

        Of the numbers at some places, by default of all that vary; without any, of one sample.
        """
        own = np.flatnonzero(self.varied[: self.n_names]) if own is None else own
        louder_by = 1.0 if self.goodness.agrees else max(1.0, self.goodness.over_noise)
        return level_of(self.noise, self.rows[: len(self.residual), own]) * louder_by

    def minus_two_log(self, noise: Noise | None = None) -> float:
        """-2 ln of the evidence (Laplace), but for a constant, under some noise; by default that at rest.

        A nuisance is charged by what the data learn of it, ln det(1 + U A U): one that the run can't see
        costs nothing. A number of the law costs the logarithm of the samples.
        """
        noise = noise or self.noise
        n = len(self.residual)
        priors = self.posed.residual(self.at, self.theta)[n:]
        law = np.array(
            [name in law_of(self.posed.model.candidate).parameters for name in self.posed.model.names]
        )
        of_law = np.append(law, np.zeros(len(self.varied) - len(law), bool)) & self.varied
        nuisance, prior_u = self.varied & ~of_law, self._prior_u.copy()
        for i, name in enumerate(self.posed.model.names):
            if not of_law[i] and not np.isfinite(prior_u[i]):
                prior_u[i] = WORN_M if PARAMETERS[name].unit == "m" else 0.02
        density = level_of(noise, self.rows[:n, of_law]) / self.posed.level or 1.0  # no number leaves a trace
        own = self.rows[:n, of_law] / density
        others = self.rows[:n, nuisance] * prior_u[nuisance] / density
        alone = without(own, others)
        charge = np.linalg.slogdet(np.eye(alone.shape[1]) + alone.T @ alone)[1]
        per_law = float(of_law.sum()) * np.log(n)
        return float(minus_two_log(self.residual, noise) + priors @ priors + charge + per_law)

    @cached_property
    def birge(self) -> float:
        """By how much shifts of the inputs exceed what priors and run allow; 1 where chance explains them.

        Birge's ratio √(χ²/ν) (Birge 1932, doi:10.1103/PhysRev.40.207), where a χ² as large has a chance below
        `TENSE`. Priors are then too narrow, or an error of the law pulls at them.
        """
        n_inputs = self.at.inputs.size
        if not n_inputs:
            return 1.0
        own = slice(self.n_names, self.n_names + n_inputs)
        values, vectors = np.linalg.eigh(np.eye(n_inputs) - self.inverse[own, own])
        seen = values > SEEN_SHARE
        chi2 = float(np.sum((vectors.T @ self.at.inputs)[seen] ** 2 / values[seen]))
        n = int(seen.sum())
        return math.sqrt(chi2 / n) if n and float(chdtrc(n, chi2)) < TENSE else 1.0

    def contributions(self) -> Contributions:
        """What each input of the laboratory contributes to the numbers, and its pull."""
        model, n = self.posed.model, self.n_names
        laboratory = model.motion.laboratory
        inputs = laboratory.inputs if laboratory else ()
        m = len(inputs)
        none = np.zeros((n, m)), np.zeros(m), np.ones(m), np.full(m, np.nan), np.zeros((n, m))
        found = Contributions(inputs, *none)  # of inputs that are held
        own = slice(n, n + self.at.inputs.size)
        remaining = np.sqrt(np.maximum(np.diag(self.inverse)[own], 0.0))
        values = self.inverse[:n, own]
        for j, source in enumerate(model.inputs):
            at = inputs.index(source)
            left = min(float(remaining[j]), 1 - 1e-9)
            found.values[:, at] = values[:, j]
            found.moved[at], found.remaining[at] = self.at.inputs[j], remaining[j]
            found.pulls[at] = self.at.inputs[j] / np.sqrt(1 - left**2) if left < 1 - 1e-6 else np.nan
            found.impacts[:, at] = values[:, j] / remaining[j]
        for at, source in enumerate(inputs):
            if (
                source.name == "mass_kg"
                and source not in model.inputs
                and law_of(model.candidate).is_foundation
            ):
                for i, name in enumerate(model.names):
                    if (
                        PARAMETERS[name].fitted_as in LOGARITHMS
                        and name in law_of(model.candidate).parameters
                    ):
                        found.values[i, at] = self.at.values[name] * source.u / model.block.mass_kg
        return found


def without(own: Floats, others: Floats) -> Floats:
    """Columns, shape (n, n_others), without what others of the same rows, (n, n_own), take up."""
    basis = own / np.maximum(np.linalg.norm(own, axis=0), np.finfo(float).tiny)
    return np.asarray(others - basis @ (np.linalg.pinv(basis.T @ basis, hermitian=True) @ (basis.T @ others)))
