"""Inputs of the laboratory as nuisances with priors.

What a laboratory knows (width, height, beam, scale, clock, response, level, release) is ν with ν⁰ ± u. One
objective holds a run and these:

    S(p, ν) = |r|²/s² + Σ ((ν - ν⁰)/u)²,    r = θ_model(p, ν) - θ_measured(ν),

with s² the power of the noise where the parameters have theirs. A law is rejected only where it leaves more
than noise after the inputs moved within their priors (HistFactory, CERN-OPEN-2012-016; Conway 2011,
arXiv:1103.0354).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import lmfit
import numpy as np
from scipy.fft import rfft, rfftfreq

from freerock.arrays import Floats, Mask
from freerock.identification.against_noise import AgainstRest, against_rest, noise_of
from freerock.identification.least_squares import minimised, numbers_of, parameters_of
from freerock.identification.likelihood import Whitened
from freerock.identification.problem import Problem, Samples
from freerock.models.laws import law_of
from freerock.noise.spectrum import Noise, averaged
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.u_total import Contributions
from freerock.rotation.view import view_of


@dataclass(frozen=True)
class InputSettings:
    """How inputs move; by judgement.

    Parameters
    ----------
    step : float
        Standard uncertainties to either side, of the difference quotients by an input.
    moved : float
        Norm over all samples, in times the noise, by which such a step may move them; one that moves them
        further is shortened in proportion. Set on a run with little damping, which determines the width to
        0.02 of its uncertainty.
    read_step : float
        Of a rotation, for the slope of its reading [rad].
    near : float
        Standard uncertainties by which inputs move, within which their first derivatives suffice.
    farthest : float
        Standard uncertainties by which an input may move: at such a pull the law is rejected whatever it
        leaves.
    worn_m : float
        Prior standard uncertainty of a contact width that is freed [m]: that of one measured by a rule.
    ftol, most, rounds : float, int, int
        Relative change of the objective at which the search ends, its evaluations with the derivatives by
        the inputs of its start, and how often it begins anew with renewed ones where they do not suffice. Set
        on a run with rounded edges, which took five rounds.
    takes : float
        Whitened length of a direction of the inputs, from which the run and not the prior tells it.
    beyond : float
        Times the residual that all inputs together may cause by one standard uncertainty, from which they
        can't be the cause: five of them, squared.
    """

    step: float = 0.1
    moved: float = 200.0
    read_step: float = 1e-5
    near: float = 0.3
    farthest: float = 8.0
    worn_m: float = 3e-4
    ftol: float = 1e-7
    most: int = 25
    rounds: int = 9
    takes: float = 1.0
    beyond: float = 25.0


INPUTS = InputSettings()


@dataclass(frozen=True, eq=False)
class Nuisances:
    """The inputs that a fit of one run moves.

    Parameters
    ----------
    problem : Problem
        Posed with the stated inputs.
    sources : tuple of Input
        Inputs that are neither exact nor freed; without the mass where k, c and λ vary: forces are as the
        mass, so that these take up all of it.
    """

    problem: Problem
    sources: tuple[Input, ...]
    _last: dict[bytes, tuple[Laboratory, Problem]] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, problem: Problem) -> "Nuisances":
        """The nuisances of a problem; none where several runs are fitted or no laboratory is known."""
        laboratory = problem.motions[0].laboratory
        if laboratory is None or len(problem.motions) > 1 or problem.directions is not None:
            return cls(problem, ())
        sources = tuple(each for each in laboratory.inputs if moves(each, problem))
        return cls(replace(problem, walled=not sources), sources)

    def starting(self, moved: Mapping[Input, float] | None) -> Floats:
        """Inputs at a start by standard uncertainties, within what they may move; zeros as stated."""
        most = INPUTS.farthest * (1 - 1e-3)
        return np.array([np.clip((moved or {}).get(each, 0.0), -most, most) for each in self.sources])

    def posed(self, z: Floats) -> Problem:
        """The problem with inputs moved by z standard uncertainties, shape (n_sources,)."""
        return in_laboratory(self.problem, self._there(z)[0]) if z.any() else self.problem

    def by_inputs(self, z: Floats, x: Floats, samples: Samples) -> Floats:
        """Derivatives by z of the residual [rad] and, below, of what is measured of the release (`rows`)."""
        most = INPUTS.moved * noise_of(self.problem.motions[0]).variance ** 0.5
        columns = []
        for j, source in enumerate(self.sources):
            if source.name == "response_ms" and not z[j]:
                # at 0 its derivative is none: what it does grows with its square
                columns.append(self._quotient(j, (0.0, 1.0), z, x, samples))
                continue
            by_j = self._quotient(j, (z[j] - INPUTS.step, z[j] + INPUTS.step), z, x, samples)
            moved = INPUTS.step * float(np.linalg.norm(by_j[: len(samples.time_s)]))
            if 0 < most < moved < np.inf:
                closer = INPUTS.step * most / moved
                by_j = self._quotient(j, (z[j] - closer, z[j] + closer), z, x, samples)
            columns.append(by_j)
        n_rows = len(self.problem.prior_of_release(x)[0])
        return np.reshape(columns, (-1, len(samples.time_s) + n_rows)).T

    def _quotient(
        self, j: int, between: tuple[float, float], z: Floats, x: Floats, samples: Samples
    ) -> Floats:
        """Difference quotient by the j-th input, of both `rows` one below the other."""
        ends = []
        for there in between:
            moved = z.copy()
            moved[j] = there
            ends.append(np.concatenate(self.rows(moved, x, samples, self.problem.exact_rtol)))
        return np.asarray((ends[1] - ends[0]) / (between[1] - between[0]))

    def rows(
        self, z: Floats, x: Floats, samples: Samples, rtol: float | None = None
    ) -> tuple[Floats, Floats]:
        """Modelled minus measured rotation at samples of the stated problem [rad], and how many standard
        uncertainties the release lies off what was measured."""
        if not z.any():
            return self.problem.curve(x, samples, rtol) - samples.theta, self.problem.prior_of_release(x)[0]
        (_, posed), own = self._there(z), self.on_clock(z, samples)
        return self.read(z, posed.curve(x, own, rtol)) - samples.theta, posed.prior_of_release(x)[0]

    def jacobian(self, z: Floats, x: Floats, samples: Samples) -> tuple[Floats, Floats]:
        """Derivatives of `rows` by x, shapes (n_samples, n_parameters) and (n_rows, n_parameters)."""
        if not z.any():
            return self.problem.jacobian(x, samples), self.problem.prior_of_release(x)[1]
        (_, posed), own = self._there(z), self.on_clock(z, samples)
        exact = posed.exact_curve(x, own)
        by_x = posed.jacobian(x, own, known=exact) * self.slope(z, exact[0])[:, None]
        return by_x, posed.prior_of_release(x)[1]

    def on_clock(self, z: Floats, samples: Samples) -> Samples:
        """Samples of the stated problem at the instants of a clock that is moved with the inputs."""
        return replace(samples, time_s=samples.time_s * self._there(z)[0].clock / self._stated.clock)

    def read(self, z: Floats, theta: Floats) -> Floats:
        """Rotation [rad] of inputs moved by z as the stated ones read it, where the noise is the sensor's."""
        return self._there(z)[0].reread(theta, self._stated) if z.any() else theta

    def slope(self, z: Floats, theta: Floats) -> Floats:
        """Derivative of `read` by the rotation."""
        if not z.any():
            return np.ones(len(theta))
        return (self.read(z, theta + INPUTS.read_step) - self.read(z, theta - INPUTS.read_step)) / (
            2 * INPUTS.read_step
        )

    @property
    def _stated(self) -> Laboratory:
        laboratory = self.problem.motions[0].laboratory
        assert laboratory is not None
        return laboratory

    def _there(self, z: Floats) -> "tuple[Laboratory, Problem]":
        """The laboratory with inputs moved, and the problem as it sees it; of the last z it is known."""
        key = z.tobytes()
        if key not in self._last:
            moved = self._stated.at(self.sources, z)
            self._last.clear()
            self._last[key] = moved, _seen_in(self.problem, moved)
        return self._last[key]


@dataclass(frozen=True, eq=False)
class Posterior:
    """A run and its inputs, or runs whose inputs are held: where a fit ended, and the linear model there.

    Parameters
    ----------
    nuisances : Nuisances
    samples : Samples
        Of the stated problem.
    x, z : ndarray, shapes (n_parameters,) and (n_sources,)
        The fitted numbers, and by how many standard uncertainties each input moved.
    problem : Problem
        With the inputs as moved.
    curve, residual : ndarray, shape (n_samples,)
        Modelled rotation by the moved inputs; and as the stated inputs read it, less the measured one [rad].
    jacobian, rows_by_inputs : ndarray, shapes (n_samples, n_parameters) and (n_samples + n_rows, n_sources)
        Derivatives of the residual by x, and by z as `Nuisances.by_inputs` gives them.
    result : lmfit.minimizer.MinimizerResult or None
        None where nothing was minimised.
    noise : Noise or None
        As rest and residual show it together; None where nothing shows that the residual is noise.
    """

    nuisances: Nuisances
    samples: Samples
    x: Floats
    z: Floats
    problem: Problem
    curve: Floats
    residual: Floats
    jacobian: Floats
    rows_by_inputs: Floats
    result: "lmfit.minimizer.MinimizerResult | None" = None
    noise: Noise | None = None

    @property
    def by_inputs(self) -> Floats:
        """Derivatives of the residual by z, shape (n_samples, n_sources)."""
        return self.rows_by_inputs[: len(self.residual)]

    @property
    def own(self) -> Samples:
        """The samples on the clock of the moved inputs."""
        return self.nuisances.on_clock(self.z, self.samples) if self.z.any() else self.samples

    @cached_property
    def free(self) -> Mask:
        """Which of the fitted numbers do not lie at a bound."""
        return ~self.problem.held(self.x)

    @cached_property
    def columns(self) -> Floats:
        """Derivatives by the free numbers and by the inputs, side by side."""
        return np.asfortranarray(np.hstack([self.jacobian[:, self.free], self.by_inputs]))

    @cached_property
    def prior(self) -> tuple[Floats, Floats]:
        """Rows that the priors add: their values, and their derivatives by the numbers of `columns`; those of
        the release first."""
        value, rows = self.problem.prior_of_release(self.x)
        n, n_z = int(self.free.sum()), len(self.z)
        of_release = np.hstack([rows[:, self.free], self.rows_by_inputs[len(self.residual) :]])
        of_inputs = np.hstack([np.zeros((n_z, n)), np.eye(n_z)])
        return np.append(value, self.z), np.vstack([of_release, of_inputs])

    @property
    def mean_square(self) -> float:
        """Mean square of the residual, with what the priors add to the objective [rad²]."""
        value, left = self.prior[0], float(np.mean(self.residual**2))
        return left + self.level**2 * float(value @ value) / len(self.residual) if len(value) else left

    @cached_property
    def whitened(self) -> Whitened:
        """Residual and derivatives without the law of the noise, beside the priors."""
        return self.beside(self.prior)

    def beside(self, prior: tuple[Floats, Floats]) -> Whitened:
        """The same beside other priors."""
        motions = self.problem.motions
        noises, level = [each.noise for each in motions], motions[0].sigma_theta if len(prior[0]) else 1.0
        return Whitened(self.residual, self.columns, self.samples.lengths, noises, prior, level)

    @cached_property
    def _inputs_alone(self) -> Floats:
        """Whitened derivatives by the inputs, without what the free numbers take up."""
        n = int(self.free.sum())
        own, by_z = np.split(self.whitened.rows[:, 1:], [n], axis=1)
        return without_own(own, by_z)

    @cached_property
    def taken(self) -> Floats:
        """Derivatives by what the run itself tells: the free numbers, and directions of the inputs."""
        if not len(self.z):
            return self.columns
        _, size, directions = np.linalg.svd(self._inputs_alone, full_matrices=False)
        n = int(self.free.sum())
        return np.hstack([self.columns[:, :n], self.by_inputs @ directions[size > INPUTS.takes].T])

    @cached_property
    def against_rest(self) -> AgainstRest:
        """The residual against the noise at rest."""
        noises = list(map(noise_of, self.problem.motions))
        return against_rest(self.residual, self.taken, self.samples.lengths, noises)

    @cached_property
    def charge(self) -> float:
        """What the priors add to minus twice the logarithm of the evidence: ln det(1 + Dᵀ D).

        D are the whitened derivatives by the inputs beside those by the free numbers (Laplace): an input that
        the run can't see costs nothing, one that it determines what a freed number does. A freed contact
        width is an input with a wide prior, `InputSettings.worn_m`, where the noise is known.
        """
        wide = self.is_wide[self.free]
        if wide.any():
            worn = INPUTS.worn_m / self.problem.gradient(self.x).diagonal()[self.free][wide]
            own, by_z = np.split(self.whitened.rows[:, 1:], [len(wide)], axis=1)
            alone = without_own(own[:, ~wide], np.hstack([own[:, wide] * worn, by_z]))
        else:
            alone = self._inputs_alone if len(self.z) else np.empty((1, 0))
        return float(np.linalg.slogdet(np.eye(alone.shape[1]) + alone.T @ alone)[1])

    @property
    def is_wide(self) -> Mask:
        """Which of the fitted numbers are inputs whose prior is widened."""
        known = all(motion.noise is not None for motion in self.problem.motions)
        return np.array([known and name == "width" for name in self.problem.names], bool)

    @cached_property
    def level(self) -> float:
        """s of the objective [rad]: root of the mean power of the noise where the derivatives have theirs.

        Least squares of noise that is not white know a number by the power of the noise at the frequencies at
        which it moves the curve. A rest alone tells little of the slowest: there is no less than white noise.
        """
        motion = self.problem.motions[0]
        noise = self.noise or noise_of(motion)
        columns = averaged(self.jacobian[:, self.free], noise.averaged)
        power = np.abs(rfft(columns, axis=0)) ** 2
        power /= np.maximum(power.sum(axis=0), np.finfo(float).tiny)
        of_columns = noise.density(rfftfreq(len(columns))) @ power
        square = float(np.mean(of_columns)) if of_columns.size else noise.variance
        least = 0.0 if self.noise else motion.sigma_theta**2
        return float(np.sqrt(max(square, least, np.finfo(float).tiny)))

    @cached_property
    def spread(self) -> Floats:
        """Covariance of the free numbers and inputs by noise of `level` and the priors, shape (n, n)."""
        rows = self.prior[1]
        if not len(rows):
            return np.zeros((self.columns.shape[1],) * 2)
        scale = np.sqrt(np.sum(self.columns**2, axis=0) / self.level**2 + np.sum(rows**2, axis=0))
        scale[scale == 0] = 1.0  # friction where no corner slips
        scaled, own = self.columns / (self.level * scale), rows / scale
        inverse = np.linalg.pinv(scaled.T @ scaled + own.T @ own, hermitian=True)
        return np.asarray(inverse / np.outer(scale, scale))

    @property
    def by_prior(self) -> Floats:
        """Derivatives of the free numbers and inputs by the centre of each prior, shape (n, n_rows)."""
        return np.asarray(self.spread @ self.prior[1].T)

    @property
    def impacts(self) -> Floats:
        """Shifts of the free numbers where one input is held its remaining standard uncertainty away and all
        else is fitted again, shape (n_free, n_sources)."""
        n = int(self.free.sum())
        return np.asarray(self.spread[:n, n:] / np.sqrt(np.diag(self.spread)[n:]))


def settled(
    problem: Problem,
    x: Floats,
    most: float = np.inf,
    ftol: float = INPUTS.ftol,
    moved: Mapping[Input, float] | None = None,
) -> Posterior:
    """The best of a run and its inputs from a start near it, by `lmfit.Minimizer`.

    The start itself, without a result, where no input may move, or where the inputs can't be the cause of
    what it leaves.

    Parameters
    ----------
    problem : Problem
    x : ndarray, shape (n_parameters,)
        The fitted numbers.
    most : float
        Samples that suffice.
    ftol : float
        Relative change of the objective at which the search ends.
    moved : mapping of Input to float, optional
        From where the inputs start [standard uncertainties]; by default as stated.
    """
    nuisances = Nuisances.of(problem)
    samples = problem.samples(most=most)
    start = at(nuisances, x, nuisances.starting(moved), samples)
    if not nuisances.sources:
        return start
    power = noise_of(problem.motions[0]).variance
    both = np.column_stack([start.residual, start.by_inputs])
    left, *causes = np.sum(without_own(start.jacobian[:, start.free], both) ** 2, axis=0)
    if not moved and left > INPUTS.beyond * (len(samples.time_s) * power + sum(causes)):
        return start
    end = _minimised(start, ftol)
    rest = end.against_rest
    far = np.any(np.abs(end.z) > INPUTS.near) and np.all(np.abs(end.z) < INPUTS.farthest - INPUTS.near)
    if far or rest.is_noise:
        end = _minimised(replace(end, noise=rest.noises[0] if rest.is_noise else None), ftol)
    return end


def held(problem: Problem, x: Floats) -> Posterior:
    """The linear model of one run, or of several, where the inputs are as stated."""
    return at(Nuisances(problem, ()), x, np.zeros(0), problem.samples())


def at(nuisances: Nuisances, x: Floats, z: Floats, samples: Samples) -> Posterior:
    """The linear model at given numbers and inputs; samples are those of the stated problem."""
    posed, own = nuisances.posed(z), nuisances.on_clock(z, samples) if z.any() else samples
    exact = posed.exact_curve(x, own)
    jacobian = posed.jacobian(x, own, law_of(posed.model).is_foundation, known=exact)
    residual = nuisances.read(z, exact[0]) - samples.theta
    jacobian *= nuisances.slope(z, exact[0])[:, None]
    by_inputs = nuisances.by_inputs(z, x, samples)
    return Posterior(nuisances, samples, x, z, posed, exact[0], residual, jacobian, by_inputs)


def in_found(problem: Problem, found: Contributions | None) -> Problem:
    """A problem of one run with the inputs as a fit of it found them."""
    laboratory = problem.motions[0].laboratory
    if found is None or laboratory is None or not found.moved.any():
        return problem
    return in_laboratory(problem, laboratory.at(found.inputs, found.moved))


def at_end(problem: Problem, values: Mapping[str, float], found: Contributions | None) -> Posterior:
    """The linear model where a fit of a problem ended: its parameters [SI], and the inputs that it found."""
    nuisances = Nuisances.of(problem)
    z = np.zeros(len(nuisances.sources))
    if found is not None and nuisances.sources:
        z = found.moved[[found.inputs.index(each) for each in nuisances.sources]]
    return at(nuisances, nuisances.posed(z).start_at(values), z, problem.samples())


def contributed(nuisances: Nuisances, x: Floats, by_inputs: Floats) -> Contributions:
    """What all inputs of a laboratory contribute to the numbers of a fit.

    Forces are as the mass: where a fit takes it for granted, k, c and λ shift as it does, and nothing else.

    Parameters
    ----------
    nuisances : Nuisances
    x : ndarray, shape (n_parameters,)
        The fitted numbers at their best.
    by_inputs : ndarray, shape (n_parameters, n_sources)
        Their derivatives by the centres of the inputs.
    """
    problem, laboratory = nuisances.problem, nuisances.problem.motions[0].laboratory
    inputs = laboratory.inputs if laboratory else ()
    every = Contributions.held(inputs, np.zeros((len(x), len(inputs))))
    at = [inputs.index(each) for each in nuisances.sources]
    every.values[:, at] = problem.gradient(x) @ by_inputs
    for j, each in enumerate(inputs):
        if each.name == "mass_kg" and j not in at and law_of(problem.model).is_foundation:
            forces = problem.is_logarithm
            every.values[forces, j] = problem.physical(x)[forces] * each.u / problem.blocks[0].mass_kg
    return Contributions.held(inputs, every.values)


def _minimised(start: Posterior, ftol: float) -> Posterior:
    """Where the objective ends, with the derivatives by the inputs renewed until they suffice."""
    for _ in range(INPUTS.rounds):
        start = _round(start, ftol)
        if start.result is None or not start.result.aborted:
            break
    return start


def _round(start: Posterior, ftol: float) -> Posterior:
    """The same with those of the start, up to `InputSettings.most` evaluations."""
    nuisances, samples, s, n_z = start.nuisances, start.samples, start.level, len(start.z)
    problem = nuisances.problem
    n, varied = int(problem.varied.sum()), problem.varied
    by_inputs, by_release = np.split(start.rows_by_inputs, [len(start.residual)])
    m = noise_of(nuisances.problem.motions[0]).averaged
    fewer = replace(samples, m=m)
    by_z = np.vstack([fewer.averaged(by_inputs) / s, by_release, np.eye(n_z)])

    def parted(both: Floats) -> tuple[Floats, Floats]:
        x = np.array(start.x)
        x[varied] = both[:n]
        return problem.consistent(x), both[n:]

    def residual(both: Floats) -> Floats:
        x, z = parted(both)
        left, release = nuisances.rows(z, x, samples)
        return np.concatenate([fewer.averaged(left) / s, release, z])

    def jacobian(both: Floats) -> Floats:
        x, z = parted(both)
        own, release = nuisances.jacobian(z, x, samples)
        by_x = np.vstack([fewer.averaged(own) / s, release, np.zeros((n_z, len(x)))])
        return np.hstack([by_x if varied.all() else by_x[:, varied], by_z])

    bounds = [*np.array(problem.bounds())[varied].tolist(), *[(-INPUTS.farthest, INPUTS.farthest)] * n_z]
    low, high = np.array(bounds).T
    both = np.append(start.x[varied], start.z)
    both = np.clip(both, low + 1e-6 * (high - low), high - 1e-6 * (high - low))
    names = [name for name, varies in zip(problem.names, varied, strict=True) if varies]
    names += [f"input_{j}_{each.name}" for j, each in enumerate(nuisances.sources)]
    result = minimised(parameters_of(names, both, (low, high)), residual, jacobian, ftol, most=INPUTS.most)
    end = at(nuisances, *parted(numbers_of(result)), samples)
    return replace(end, result=result, noise=start.noise)


def in_laboratory(problem: Problem, moved: Laboratory) -> Problem:
    """The problem of one run that a laboratory with other inputs would have posed."""
    stated, posed = problem.motions[0].laboratory, _seen_in(problem, moved)
    assert stated is not None
    (motion,), clock = problem.motions, moved.clock / stated.clock
    motion = replace(
        posed.motions[0],
        time_s=motion.time_s * clock,
        fit_start_s=motion.fit_start_s * clock,
        theta=stated.reread(motion.theta, moved),
    )
    return replace(posed, motions=(motion,))


def _seen_in(problem: Problem, moved: Laboratory) -> Problem:
    """The problem of one run with block, sensor and release of another laboratory."""
    (motion,) = problem.motions
    stated = motion.laboratory
    assert stated is not None
    theta0 = float(stated.reread(np.array([motion.theta0]), moved)[0])
    view = view_of([*moved.lasers.values()], moved.block)
    motion = replace(motion, theta0=theta0, view=view, laboratory=moved)
    return replace(problem, blocks=(moved.block,), motions=(motion,))


def moves(source: Input, problem: Problem) -> bool:
    """Whether a fit moves an input: not one that is exact, freed, or taken up by the forces."""
    freed = {"levelled_deg": "tilt", "com_offset_m": "tilt", "contact_width_m": "width"}.get(source.name)
    taken_up = source.name == "mass_kg" and (problem.varied.all() or not law_of(problem.model).is_foundation)
    return source.u > 0 and not taken_up and freed not in problem.names


def without_own(own: Floats, others: Floats) -> Floats:
    """Columns, shape (n_rows, n_others), without what others of the same rows, (n_rows, n_own), take up."""
    basis = own / np.maximum(np.linalg.norm(own, axis=0), np.finfo(float).tiny)
    return np.asarray(others - basis @ np.linalg.lstsq(basis, others, rcond=None)[0])
