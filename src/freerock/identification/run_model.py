"""What a candidate makes of one run: the curve as the laser reads it, and its derivatives.

One model holds a run: θ = θ_law(t; p, ν, θ₀, t₀, δ) + noise. p are the numbers of the law. ν are the inputs
of the laboratory, in standard uncertainties off their stated values. δ is the scatter of the impacts: after
impact i the rate is multiplied by 1 + δ_i.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.settings import freed
from freerock.models.block import Block
from freerock.models.contact import Foundation
from freerock.models.free_parameters import OF_RECORD, PARAMETERS, PER_RUN
from freerock.models.laws import CANDIDATES, Rules, law_of
from freerock.models.simulate import Solver, restarts
from freerock.noise.spectrum import averaged
from freerock.rotation.as_measured import as_measured, as_released
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.view import View, view_of
from freerock.runs.motion import Motion

RTOL = 1e-8  # of the integrator: its error is below 1 % of the noise
RTOL_SCREENING = 1e-5
# Of difference quotients, as a share of a positive number; absolute of δ and of an angle [rad]. A number of
# the law is nearly a sum of impacts: quotients must be exact to 1e-5, or they tell what the samples do not.
STEP = 3e-7
JUMP_RAD = 3e-5  # a step `STEP` moves a curve by less: by 100 rad over the logarithm of a number
STEP_BOTH_WAYS = 1e-4  # where the integrator's error is larger: edges, an offset, the tensionless rule
FARTHEST_INPUT = 8.0  # standard uncertainties: a law that needs more is rejected by its pull
MOST_STEPS = 20_000  # of a curve: a real one takes a tenth; where an optimiser wanders, one takes minutes
INPUT_STEP = 0.01  # standard uncertainties


@dataclass(frozen=True)
class Samples:
    """Samples of a run that count in a fit.

    Parameters
    ----------
    time_s, theta : ndarray, shape (n_samples,)
        Time since the release [s] and measured rotation [rad].
    m : int
        How many samples are averaged into one.
    """

    time_s: Floats
    theta: Floats
    m: int = 1

    def averaged(self, values: Floats) -> Floats:
        """Means of m samples each, times √m: white noise keeps its variance."""
        return np.ascontiguousarray(averaged(values, self.m))


@dataclass(frozen=True)
class Point:
    """Where in its parameters a model is evaluated.

    Parameters
    ----------
    values : mapping of str to float
        Numbers of the law, and of `RunModel.names` [SI].
    inputs : ndarray, shape (n_inputs,)
        Standard uncertainties by which the inputs are off their stated values.
    impacts : ndarray, shape (n_impacts,)
        δ of the first impacts.
    """

    values: Mapping[str, float]
    inputs: Floats
    impacts: Floats


Seen = tuple[Block, View | None, Laboratory | None]  # block, view and laboratory with its inputs moved


@dataclass(frozen=True, eq=False)
class RunModel:
    """A candidate and the run that it is fitted to.

    Parameters
    ----------
    candidate : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
        As stated.
    motion : Motion
        The measured run.
    settings : FitSettings
    moves_inputs : bool
        Whether the inputs of the laboratory are free within their priors.

    Raises
    ------
    FreerockError
        The run has no more valid samples than there are parameters.
    """

    candidate: str
    block: Block
    motion: Motion
    settings: FitSettings = field(default_factory=FitSettings)
    moves_inputs: bool = True
    _seen: dict[bytes, "tuple[Block, View | None, Laboratory | None]"] = field(
        default_factory=dict, repr=False
    )

    def __post_init__(self) -> None:
        if np.isfinite(self.motion.theta).sum() <= len(self.names):
            what = "fewer valid samples than parameters"
            raise FreerockError("fit", what, "exclude the run or widen it by an override")

    @property
    def law(self) -> str:
        """The law of the candidate."""
        return CANDIDATES[self.candidate].law

    @cached_property
    def law_names(self) -> tuple[str, ...]:
        """Numbers of the law, and what else the runs of a record share: width, tilt, edges where freed."""
        free = freed(self.candidate, self.settings.free)
        return (*law_of(self.candidate).parameters, *(name for name in OF_RECORD if name in free))

    @property
    def laws_own(self) -> tuple[str, ...]:
        """Numbers of the law alone."""
        return law_of(self.candidate).parameters

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All numbers of the law and of the release."""
        return (*self.law_names, *(name for name in PER_RUN if name in self.settings.free))

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """Inputs of the laboratory that the fit moves within their priors.

        Not those that are exact or freed; forces are as the mass, so that k, c and λ take up all of it.
        """
        laboratory = self.motion.laboratory
        if laboratory is None or not self.moves_inputs:
            return ()
        return tuple(each for each in laboratory.inputs if self._moves(each))

    def farthest(self, source: Input) -> float:
        """Lowest number of standard uncertainties by which a fit moves an input; a response stays above 0."""
        laboratory = self.motion.laboratory
        if source.name != "response_ms" or laboratory is None:
            return -FARTHEST_INPUT
        response = max(each.response_ms for each in laboratory.lasers.values())
        return max(-(response**2) / ((response + source.u) ** 2 - response**2), -FARTHEST_INPUT)

    def _moves(self, source: Input) -> bool:
        is_freed = {"levelled_deg": "tilt", "com_offset_m": "tilt", "contact_width_m": "width"}
        takes_mass = law_of(self.candidate).is_foundation and not self.settings.given(self.candidate)
        taken_up = source.name == "mass_kg" and (takes_mass or not law_of(self.candidate).is_foundation)
        return source.u > 0 and not taken_up and is_freed.get(source.name) not in self.names

    @cached_property
    def whole(self) -> Samples:
        """All valid samples after the finger has left the block, one by one."""
        begin = np.searchsorted(self.motion.time_s, self.motion.fit_start_s)
        time_s, theta = self.motion.time_s[begin:], self.motion.theta[begin:]
        valid = np.isfinite(theta)
        return Samples(time_s[valid], theta[valid])

    def until(self, horizon_s: float, most: int) -> Samples:
        """Valid samples up to a horizon [s], thinned to about `most`."""
        whole = self.whole
        end = int(np.searchsorted(whole.time_s, horizon_s, "right"))
        some = slice(0, end, max(1, end // most))
        return Samples(np.ascontiguousarray(whole.time_s[some]), np.ascontiguousarray(whole.theta[some]))

    def curve(self, at: Point, time_s: Floats, rtol: float = RTOL, rate: Floats | None = None) -> Floats:
        """θ as the stated laboratory would read it [rad], shape (n_time,).

        An overturned block lies at ±π/2. `rate`, shape (n_time,), receives the rate of what is seen [rad/s].
        """
        block, view, moved = self._there(at)
        values, time_s = self._values(at, moved), self._on_clock(time_s, moved)
        theta = as_measured(
            self.law,
            block,
            values,
            time_s,
            view,
            rules=self.rules,
            solver=Solver(rtol, MOST_STEPS),
            theta_rate=rate,
        )
        return self._reread(theta, moved)

    def derivatives(
        self, at: Point, samples: Samples, rtol: float = RTOL, wanted: Sequence[str] | None = None
    ) -> tuple[Floats, Floats]:
        """The curve [rad] and its derivatives by numbers and impacts.

        Parameters
        ----------
        at : Point
        samples : Samples
        rtol : float
            Of the integrator.
        wanted : sequence of str, optional
            Of `names`; by default all.

        Returns
        -------
        theta : ndarray, shape (n_samples,)
        by_numbers : ndarray, shape (n_samples, n_wanted + n_impacts)
            In SI units; columns of the impacts come last.
        """
        names = self.names if wanted is None else wanted
        rate, time_s = np.empty(samples.time_s.size), samples.time_s
        theta = self.curve(at, time_s, rtol, rate)
        columns = np.zeros((theta.size, len(names) + at.impacts.size), order="F")
        self._by_impacts(at, time_s, rtol, theta, columns[:, len(names) :])
        for j, name in enumerate(names):
            if name == "t0":
                columns[:, j] = -rate
            elif name == "r" and at.impacts.size:  # r of impact i is r (1 + δ_i)
                columns[:, j] = columns[:, len(names) :] @ ((1 + at.impacts) / at.values["r"])
                columns[:, j] += self._by_later_r(at, time_s, rtol, theta)
            else:
                columns[:, j] = self._quotient(at, name, time_s, rtol, theta)
        return theta, columns

    def _by_later_r(self, at: Point, time_s: Floats, rtol: float, theta: Floats) -> Floats:
        """Derivative by the restitution of the impacts after those that have a δ."""
        r = at.values["r"]
        kept = (1 + at.impacts) * r / (r - STEP) - 1
        moved = Point({**at.values, "r": r - STEP}, at.inputs, kept)
        return (theta - self.curve(moved, time_s, rtol)) / STEP

    @cached_property
    def is_smooth(self) -> bool:
        """Whether curves are exact enough for quotients over `STEP`, as series and closed forms are."""
        block = self.block.as_found({name: 0.0 for name in ("edge_radius",) if name in self.names})
        rounded = "edge_radius" in self.names or bool(block.edge_radius)
        return not (rounded or block.e or self.settings.debonding == "tensionless")

    def _quotient(self, at: Point, name: str, time_s: Floats, rtol: float, theta: Floats) -> Floats:
        """Derivative of the curve by a number of the law or the release angle."""
        value = at.values[name]
        step = STEP if self.is_smooth else STEP_BOTH_WAYS
        if PARAMETERS[name].is_logarithm or name == "width":
            step *= abs(value)
        elif name == "r":
            step = -step
        later = self.curve(replace(at, values={**at.values, name: value + step}), time_s, rtol)
        only = value - step < PARAMETERS[name].bounds[0]
        if only or (self.is_smooth and np.max(np.abs(later - theta)) < JUMP_RAD):
            return (later - theta) / step
        earlier = self.curve(replace(at, values={**at.values, name: value - step}), time_s, rtol)
        if not self.is_smooth:
            return (later - earlier) / (2 * step)
        # within the step a swing begins or ceases to lift the block, and an impact has its δ or has it not
        return min(later - theta, theta - earlier, key=lambda by: float(np.max(np.abs(by)))) / step

    def by_inputs(self, at: Point, time_s: Floats, rtol: float = RTOL) -> Floats:
        """Derivatives of the curve by the inputs [rad per standard uncertainty], shape (n_time, n_inputs)."""
        columns = np.zeros((time_s.size, len(self.inputs)), order="F")
        here = self.curve(at, time_s, rtol) if self.inputs else columns
        for j, source in enumerate(self.inputs):
            steps = np.zeros(len(self.inputs))
            # what a slow sensor does grows with the square of its time
            steps[j] = 1.0 if source.name == "response_ms" else INPUT_STEP
            later = self.curve(replace(at, inputs=at.inputs + steps), time_s, rtol)
            columns[:, j] = (later - here) / steps[j]
        return columns

    @cached_property
    def rules(self) -> Rules:
        """The rules of the simulation."""
        return CANDIDATES[self.candidate].rules(self.settings.debonding)

    def simulated(self, at: Point) -> tuple[Block, dict[str, float]]:
        """The block that turns, and what `freerock.models.simulate.simulate_fitted` takes of a point."""
        block, view, moved = self._there(at)
        return block, as_released(self.law, block, self._values(at, moved), view)

    def _by_impacts(self, at: Point, time_s: Floats, rtol: float, theta: Floats, out: Floats) -> None:
        """Fill the derivatives by δ of each impact, shape (n_time, n_impacts)."""
        if not at.impacts.size:
            return
        block, view, moved = self._there(at)
        values = as_released(self.law, block, self._values(at, moved), view)
        turning, own_time_s = block.as_found(values), self._on_clock(time_s, moved)
        solver = Solver(rtol, MOST_STEPS)
        bed = Foundation.of(values) if law_of(self.candidate).is_foundation else None
        if view is not None and len(view.moments[0]) > 1:  # a slow sensor delays all derivatives alike
            view = view.at_once
            seen = {**values, "theta0": view.seen_at_rest(values["theta0"], turning, bed)}
            whole = as_measured(self.law, block, seen, own_time_s, view, rules=self.rules, solver=solver)
            theta = self._reread(whole, moved)

        def later_curves(step: float) -> Iterator[tuple[int, int, Floats]]:
            for i, begin, later, z_cb in restarts(
                self.law, block, values, own_time_s, rules=self.rules, solver=solver, step=step
            ):
                lost = np.isnan(later)
                if lost.any():
                    later[lost], z_cb = np.copysign(np.pi / 2, values["theta0"]), np.where(lost, 0.0, z_cb)
                if view is not None and not view.is_plain(turning, bed):
                    later = view.seen(later[None], np.ascontiguousarray(z_cb)[None], turning, bed)
                yield i, begin, self._reread(later, moved)

        if self.is_smooth:
            for i, begin, later in later_curves(STEP):
                out[begin:, i] = (later - theta[begin:]) / STEP
            return
        both = zip(later_curves(STEP_BOTH_WAYS), later_curves(-STEP_BOTH_WAYS), strict=True)
        for (i, begin, later), (_, _, earlier) in both:
            out[begin:, i] = (later - earlier) / (2 * STEP_BOTH_WAYS)

    def _values(self, at: Point, moved: Laboratory | None) -> dict[str, float]:
        """What a simulation takes of a point; the release angle as the moved laboratory reads it."""
        values = {"theta0": self.motion.theta0, **at.values}
        laboratory = moved or self.motion.laboratory
        if moved is not None and self.motion.laboratory is not None:
            seen = np.array([values["theta0"]])
            values["theta0"] = float(self.motion.laboratory.reread(seen, moved)[0])
        if laboratory is not None and laboratory.tilt and "tilt" not in values:
            values["tilt"] = laboratory.tilt
        if at.impacts.size:
            values["impacts"] = at.impacts  # type: ignore[assignment]
        return values

    def _there(self, at: Point) -> "Seen":
        """Block, view and laboratory with the inputs moved; of the last inputs they are known."""
        stated = self.motion.laboratory
        if stated is None or not at.inputs.any():
            return self.block, self.motion.view, None
        key = at.inputs.tobytes()
        if key not in self._seen:
            moved = stated.at(self.inputs, at.inputs)
            self._seen.clear()
            self._seen[key] = moved.block, view_of([*moved.lasers.values()], moved.block), moved
        return self._seen[key]

    def _on_clock(self, time_s: Floats, moved: Laboratory | None) -> Floats:
        stated = self.motion.laboratory
        return time_s if moved is None or stated is None else time_s * (moved.clock / stated.clock)

    def _reread(self, theta: Floats, moved: Laboratory | None) -> Floats:
        stated = self.motion.laboratory
        return theta if moved is None or stated is None else moved.reread(theta, stated)
