"""What a candidate makes of one run: the curve as the laser reads it, and its derivatives.

One model holds a run: θ = θ_law(t; p, ν, θ₀, t₀, δ) + noise. p are the numbers of the law. ν are the inputs
of the laboratory, in standard uncertainties off their stated values. δ is the scatter of the impacts: after
impact i the rate is multiplied by 1 + δ_i.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.samples import Samples
from freerock.identification.settings import freed
from freerock.models.block import Block
from freerock.models.free_parameters import LOGARITHMS, OF_RECORD, PARAMETERS, PER_RUN
from freerock.models.laws import CANDIDATES, Foundation, Rules, law_of
from freerock.models.simulate import Solver, simulate_fitted, tangents
from freerock.noise.spectrum import Noise, averaged, white_noise
from freerock.rotation.laboratory import OF_BLOCK, Input, Laboratory
from freerock.rotation.view import View, as_measured, as_released, view_of
from freerock.runs.motion import Motion

RTOL = 1e-8  # of the integrator: its error is below 1 % of the noise
# Of searches before the rounds; derivatives at their ends are taken at `RTOL`.
RTOL_SEARCH = 1e-6
RTOL_SCREENING = 1e-5
# Of difference quotients, as a share of a positive number; absolute of δ and of an angle [rad]. A number of
# the law is nearly a sum of impacts: quotients must be exact to 1e-5, or they tell what the samples do not.
STEP = 3e-7
STEP_BOTH_WAYS = 1e-4  # where the integrator's error is larger: edges, an offset, the tensionless rule
MOST_STEPS = 20_000  # of a curve: a real one takes a tenth; where an optimiser wanders, one takes minutes
INPUT_STEP = 1e-4  # standard uncertainties: over 0.01 of them that of a width is off by 1 %
SMALL_STEP = 1e-7  # rad, m: of what a sensor reads
WIDEST = 0.75  # spread of an average, over the distance of averages, up to which a curve is smoothed
MOST_PLACES = 50
Made = TypeVar("Made")


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
    rates : ndarray, shape (n_impacts,), optional
        |θ̇| that these impacts leave the block [rad/s], from which δ follow; where it is 0, δ counts. A swing
        depends little on what was before such an impact, so that searches hold rates.
    """

    values: Mapping[str, float]
    inputs: Floats
    impacts: Floats
    rates: Floats | None = None

    @property
    def passages(self) -> Floats:
        """Rows that a simulation fills at each impact; the rates that it is to leave are in them already."""
        found = np.full((self.impacts.size, 5), np.nan)
        if self.rates is not None:
            found[:, 4] = self.rates
        return found


def _key(at: Point, rtol: float) -> bytes:
    rates = b"" if at.rates is None else at.rates.tobytes()
    numbers = np.fromiter((rtol, *at.values.values()), float).tobytes()
    return numbers + at.inputs.tobytes() + at.impacts.tobytes() + rates


@dataclass(frozen=True)
class Place:
    """What the inputs make of the laboratory.

    Parameters
    ----------
    block : Block
    view : View or None
    moved : Laboratory or None
        With its inputs moved; None of the stated one.
    clock : float
        Seconds on its clock, of a second on that of the stated laboratory.
    response_s2 : float
        Square of the time of the sensor [s²]; inputs may move it below zero.
    """

    block: Block
    view: View | None
    moved: Laboratory | None
    clock: float
    response_s2: float


@dataclass(frozen=True, eq=False)
class Moved:
    """A motion, and what the sensor makes of it at once.

    Parameters
    ----------
    place : Place
    turning : Block
        That of the place, with what a fit has freed of it.
    values : dict
        As `freerock.models.simulate.simulate_fitted` takes them.
    time_s : ndarray, shape (n_time,)
        On the clock of the moved laboratory [s].
    turned : ndarray, shape (n_time,)
        Rotation [rad].
    rates, passages : ndarray
        As of `simulate_fitted`.
    impacts : ndarray, shape (n_impacts,)
        δ of the impacts that have one.
    stated : Laboratory or None
        That reads it.
    """

    place: Place
    turning: Block
    values: dict[str, float]
    time_s: Floats
    turned: Floats
    rates: Floats
    passages: Floats
    impacts: Floats
    stated: Laboratory | None

    @cached_property
    def theta(self) -> Floats:
        """Rotation as the stated laboratory would read it [rad], shape (n_time,)."""
        return self.read()

    @cached_property
    def whole(self) -> Floats:
        """Rotation of each sample [rad], then δ of each impact, shape (n_time + n_impacts,)."""
        return np.append(self.theta, self.impacts)

    @cached_property
    def slopes(self) -> tuple[Floats, Floats, Floats]:
        """Derivatives of `theta` by the rotation, by the depth [1/m] and by time [rad/s]."""
        by_turned = (self.read(turned=SMALL_STEP) - self.theta) / SMALL_STEP
        by_z = (self.read(z_cb=SMALL_STEP) - self.theta) / SMALL_STEP
        rate = by_turned * self.rates[:, -1]
        return by_turned, by_z, rate + by_z * self.rates[:, 1] if self.rates.shape[1] > 1 else rate

    def read(self, place: Place | None = None, turned: float = 0.0, z_cb: float = 0.0) -> Floats:
        """Rotation as the stated laboratory would read it [rad], at a place, or turned or sunk by more.

        Parameters
        ----------
        place : Place, optional
            With the same block, where it is read; by default that of the motion.
        turned, z_cb : float
            What is added to the rotation [rad] and to the depth [m]; of a rigid block nothing is seen of a
            depth.
        """
        place, theta = place or self.place, self.turned + turned if turned else self.turned
        bed = Foundation.of(self.values) if "k" in self.values else None
        view, moved, stated = place.view, place.moved, self.stated
        if view is not None and view.sees_corners(self.turning, bed):
            sunk = self.rates[:, 0] + z_cb if z_cb else self.rates[:, 0]
            # of one beam, that of the place and of the stated laboratory at once
            by = None if moved is None or stated is None else moved.read_by(stated)
            return view.seen(theta[None], sunk[None], self.turning, bed, by=by)
        return theta if moved is None or stated is None else moved.reread(theta, stated)


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
    _places: dict[bytes, Place] = field(default_factory=dict, repr=False)
    _last: dict[str, dict[bytes, tuple[Floats, Any]]] = field(default_factory=dict, repr=False)

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
        is_freed = {"levelled_deg": "tilt", "com_offset_m": "tilt", "contact_width_m": "width"}
        takes_mass = not (law_of(self.candidate).is_foundation and self.settings.given(self.candidate))
        return tuple(
            each
            for each in laboratory.inputs
            if each.u > 0
            and not (each.name == "mass_kg" and takes_mass)
            and is_freed.get(each.name) not in self.names
        )

    @cached_property
    def noise(self) -> Noise:
        """That of the sensor at rest; where none was seen, white noise of its sigma_theta."""
        motion = self.motion
        if motion.noise is not None:
            return motion.noise
        return white_noise(motion.sigma_theta, (len(motion.time_s) - 1) / float(np.ptp(motion.time_s)))

    @cached_property
    def sigma(self) -> float:
        """Standard deviation of the noise of a sample [rad]."""
        return float(max(self.motion.sigma_theta, self.noise.variance**0.5))

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

    def curve(self, at: Point, time_s: Floats, rtol: float = RTOL) -> Floats:
        """θ as the stated laboratory would read it [rad], shape (n_time,); an overturned block is at ±π/2."""
        place = self._there(at)
        theta = as_measured(
            self.law,
            place.block,
            self._values(at, place.moved),
            time_s * place.clock,
            place.view,
            rules=self.rules,
            solver=Solver(rtol, MOST_STEPS),
            passages=at.passages,
        )
        if place.moved is not None and self.motion.laboratory is not None:
            theta = place.moved.reread(theta, self.motion.laboratory)
        return Samples(time_s, theta).smoothed(theta, place.response_s2) if place.response_s2 < 0 else theta

    def means(self, at: Point, samples: Samples, rtol: float = RTOL) -> Floats:
        """Means of m samples of the curve, times √m [rad], shape (n,)."""
        response_s2 = self._response_s2(at, samples)
        if response_s2 is not None:
            return samples.smoothed(self.here(at, samples, rtol).theta, response_s2)

        def means() -> Floats:
            return averaged(self.curve(at, samples.time_s, rtol), samples.m)

        return self._known("means", at, samples.middle_s, rtol, means)

    def held(self, at: Point, samples: Samples, rtol: float = RTOL) -> Point:
        """The point with the rate after each impact, and δ, as the motion there has them."""
        here = self.here(at, samples, rtol)
        left = np.where(np.isnan(here.passages[:, 0]), 0.0, np.abs(here.passages[:, 4]))
        held = replace(at, impacts=here.impacts, rates=left)
        self._last["motion"][_key(held, rtol)] = samples.middle_s, here
        return held

    def derivatives(self, at: Point, samples: Samples, rtol: float = RTOL) -> Floats:
        """Derivatives of `means` and of δ with the rates after impacts held.

        Shape (n + n_impacts, n_names + n_impacts): by the numbers of the model [SI], then by the logarithm of
        the rate after each impact.
        A slow sensor delays all derivatives alike: they are those at the middles of the samples.
        """
        at = self.held(at, samples, rtol)
        here = self.here(at, samples, rtol)
        by_turned, by_z, rate = here.slopes
        n, n_names = here.theta.size, len(self.names)
        columns = np.zeros((here.whole.size, n_names + at.impacts.size), order="F")
        if at.impacts.size:
            columns[n:, n_names:] = np.diag(1 + at.impacts)
            given = (
                self.law,
                here.turning,
                here.values,
                here.time_s,
                (here.turned, here.rates, here.passages),
            )
            steps = (STEP,) if self.is_smooth else (STEP_BOTH_WAYS, -STEP_BOTH_WAYS)
            found = tangents(*given, rules=self.rules, solver=Solver(rtol, MOST_STEPS), steps=steps)
            found.by_rates(by_turned, by_z, rate, columns[:, n_names:])
        for j, name in enumerate(self.names):
            if name == "t0":
                columns[:n, j] = -rate
            else:
                columns[:, j] = self._quotient(at, name, samples, rtol)
        return self._averaged(columns, at, samples)

    def _averaged(self, columns: Floats, at: Point, samples: Samples) -> Floats:
        """Derivatives at the middles of samples, made those of `means` in place."""
        n, response_s2 = samples.middle_s.size, self._response_s2(at, samples)
        if response_s2 is None:
            columns[:n] *= math.sqrt(samples.m)
        else:
            columns[:n] = samples.smoothed(columns[:n].T, response_s2).T
        return columns

    @cached_property
    def is_smooth(self) -> bool:
        """Whether curves are exact enough for quotients over `STEP`, as series and closed forms are."""
        block = self.block.as_found({name: 0.0 for name in ("edge_radius",) if name in self.names})
        rounded = "edge_radius" in self.names or bool(block.edge_radius_m)
        return not (rounded or block.e or self.settings.debonding == "tensionless")

    def _quotient(self, at: Point, name: str, samples: Samples, rtol: float) -> Floats:
        """Derivative of curve and δ by a number of the law or the release angle."""
        quotient = partial(self._new_quotient, at, name, samples, rtol)
        return self._known(name, at, samples.middle_s, rtol, quotient)

    def _new_quotient(self, at: Point, name: str, samples: Samples, rtol: float) -> Floats:
        value, time_s = at.values.get(name, self.motion.theta0), samples.middle_s
        step = STEP if self.is_smooth else STEP_BOTH_WAYS
        if PARAMETERS[name].fitted_as in LOGARITHMS or name == "width":
            step *= abs(value)
        elif name == "r":
            step = -step
        larger = replace(at, values={**at.values, name: value + step})
        later = self._simulated(larger, time_s, rtol).whole
        if self.is_smooth or value - step < PARAMETERS[name].bounds[0]:
            return (later - self.here(at, samples, rtol).whole) / step
        smaller = replace(at, values={**at.values, name: value - step})
        earlier = self._simulated(smaller, time_s, rtol).whole
        return (later - earlier) / (2 * step)

    def _released_by_seen(self, at: Point, here: Moved) -> float:
        """Derivative of the release angle of the block by the angle that is seen."""
        higher = {**at.values, "theta0": at.values.get("theta0", self.motion.theta0) + STEP}
        values = self._values(replace(at, values=higher), here.place.moved)
        released = as_released(self.law, here.turning, values, here.place.view)["theta0"]
        return (released - here.values["theta0"]) / STEP

    def by_inputs(self, at: Point, samples: Samples, rtol: float = RTOL) -> Floats:
        """Derivatives of `means` [rad] and of δ per standard uncertainty of the inputs.

        Of what moves the block there is another motion; of what moves laser and clock that of the block is
        read again, with the release as they show it. Shape (n + n_impacts, n_inputs); rates after impacts are
        held.
        """
        given, at = at, self.held(at, samples, rtol)
        n = samples.middle_s.size
        columns = np.zeros((n + at.impacts.size, len(self.inputs)), order="F")
        if not self.inputs:
            return columns
        time_s = samples.middle_s
        here = self.here(at, samples, rtol)
        by_release = self._quotient(at, "theta0", samples, rtol) / self._released_by_seen(at, here)
        for j, (source, step) in enumerate(zip(self.inputs, np.eye(len(self.inputs)), strict=True)):
            moved = replace(at, inputs=at.inputs + INPUT_STEP * step)
            if source.name in OF_BLOCK or source.name == "levelled_deg":
                columns[:, j] = (self._simulated(moved, time_s, rtol).whole - here.whole) / INPUT_STEP
            elif source.name != "response_ms":
                place = self._there(moved)
                values = as_released(self.law, here.turning, self._values(moved, place.moved), place.view)
                off = by_release * (values["theta0"] - here.values["theta0"])
                late_s = time_s * place.clock - here.time_s
                off[:n] += here.read(place) - here.theta + here.slopes[2] * late_s
                columns[:, j] = off / INPUT_STEP
        columns = self._averaged(columns, at, samples)
        for j, source in enumerate(self.inputs):
            if source.name == "response_ms":
                # what a slow sensor does grows with the square of its time: by one standard uncertainty
                slower = replace(at, inputs=at.inputs + np.eye(len(self.inputs))[j])
                columns[:n, j] = -self.means(given, samples, rtol)
                if self._response_s2(at, samples) is None:
                    columns[:n, j] += self.means(slower, samples, rtol)
                else:
                    columns[:n, j] += samples.smoothed(here.theta, self._there(slower).response_s2)
        return columns

    @cached_property
    def rules(self) -> Rules:
        """The rules of the simulation."""
        return Rules(self.settings.debonding, CANDIDATES[self.candidate].kinematics)

    def here(self, at: Point, samples: Samples, rtol: float = RTOL) -> Moved:
        """The motion, read at once, at the middles of the samples; that of the last point is known."""
        time_s = samples.middle_s
        return self._known("motion", at, time_s, rtol, lambda: self._simulated(at, time_s, rtol))

    def _known(self, what: str, at: Point, time_s: Floats, rtol: float, found: Callable[[], Made]) -> Made:
        """What is found at a point, kept until it is asked for at another one; nobody changes it in place."""
        key, known = _key(at, rtol), self._last.setdefault(what, {})
        if key not in known or known[key][0] is not time_s:
            last = found()
            known.clear()
            known[key] = time_s, last
        made: Made = known[key][1]
        return made

    def _simulated(self, at: Point, time_s: Floats, rtol: float) -> Moved:
        place = self._there(at)
        turning = place.block.as_found(at.values)
        values = as_released(self.law, turning, self._values(at, place.moved), place.view)
        time_s = time_s * place.clock
        rates = np.empty((time_s.size, 3 if law_of(self.candidate).is_foundation else 1))
        passages, impacts = at.passages, at.impacts
        turned = simulate_fitted(
            self.law,
            turning,
            values,
            time_s,
            rules=self.rules,
            solver=Solver(rtol, MOST_STEPS),
            rates=rates,
            passages=passages,
        )
        if at.rates is not None:
            reached = ~np.isnan(passages[:, 3])
            impacts = np.where(reached, passages[:, 3] - 1, at.impacts)
            values["impacts"] = impacts  # type: ignore[assignment]
        return Moved(place, turning, values, time_s, turned, rates, passages, impacts, self.motion.laboratory)

    def _response_s2(self, at: Point, samples: Samples) -> float | None:
        """Square of the sensor's time [s²] where a smoothed curve tells what it does; else None."""
        response_s2, (_, widest_s2, apart_s2) = self._there(at).response_s2, samples.spans_s2
        return response_s2 if widest_s2 + response_s2 / 12 <= WIDEST**2 * apart_s2 else None

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

    def _there(self, at: Point) -> Place:
        """Block, view and laboratory with the inputs moved; of the last inputs they are known."""
        stated, key = self.motion.laboratory, at.inputs.tobytes()
        if key not in self._places:
            if len(self._places) > MOST_PLACES:
                self._places.clear()
            block, view, moved, clock, less_ms2 = self.block, self.motion.view, None, 1.0, 0.0
            if stated is not None and at.inputs.any():
                moved = stated.moved(dict(zip(self.inputs, at.inputs.tolist(), strict=True)))
                view = view_of([*moved.lasers.values()], moved.block)
                block, clock = moved.block, moved.clock / stated.clock
                less_ms2 = moved.less_than_none_ms2
            response_ms2 = view.laser.response_ms**2 if view else 0.0
            self._places[key] = Place(block, view, moved, clock, (response_ms2 - less_ms2) / 1e6)
        return self._places[key]
