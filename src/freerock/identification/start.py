"""Starts of a fit: a scan over a grid on the first swing, then swings that last as long as measured."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.posed import RATE_CHANGE, Ended, Posed, minimised
from freerock.identification.run_model import RTOL_SCREENING, RTOL_SEARCH, Point, RunModel
from freerock.identification.samples import Samples
from freerock.models.block import Block
from freerock.models.block_on_bed import static_depth
from freerock.models.free_parameters import PARAMETERS, PER_RUN
from freerock.models.laws import CANDIDATES, Foundation, law_of
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class StartSettings:
    """How starts are sought and followed; by judgement, shown in docs/validation.md on drawn scenes.

    Parameters
    ----------
    grid, samples : int
        Samples of the error over a grid, and of what follows before the rounds of `fit`.
    followed : int
        Local minima of the grid that are followed.
    worn : tuple of float
        Shares of the stated width, from which one that is freed starts.
    sigma_r : float
        Prior of the impacts' scatter meanwhile: wide.
    passes, steep : int, float
        Curves at most, over which the swings are brought to the durations that were measured; times the
        change of a rate that a rigid block needs, beyond which a swing does not tell its rate.
    in_step, lost : float
        Of a swing, up to which the instants of its impacts agree with the measured ones; from which a fit has
        lost a swing.
    quick, search : (int, float)
        Evaluations, and the relative change at which they end: of all candidates on the first swings and of
        laws that are far off on the whole run; of those that may hold.
    clear, sure : float
        Standard deviations of the noise, above which a rotation has a sign; and the instant of an impact is
        known to a hundredth of the swing.
    missing : float
        Times the two swings before it, from which a swing holds one that the noise hides.
    screened : int
        Swings of the first run, on which candidates are screened.
    promising : float
        Times the least mean square of the starts of a law, and of their ends on the first swings, up to which
        they are followed.
    misfit : float
        Times the noise's power, from which a residual sets the level of a sample itself.
    same : float
        Relative difference of the first number, up to which two ends are one.
    """

    grid: int = 250
    samples: int = 1000
    followed: int = 3
    worn: tuple[float, ...] = (0.9, 0.95, 1.0)
    sigma_r: float = 0.03
    passes: int = 3
    steep: float = 5.0
    in_step: float = 0.01
    lost: float = 0.2
    quick: tuple[int, float] = (8, 1e-2)
    search: tuple[int, float] = (25, 1e-3)
    clear: float = 10.0
    sure: float = 30.0
    missing: float = 1.4
    screened: int = 6
    promising: float = 5.0
    misfit: float = 1.5
    same: float = 3e-3


START = StartSettings()


def crossings_s(motion: Motion, clear: float = START.clear) -> Floats:
    """Instants at which the measured rotation changes its sign while the block moves [s].

    Swings grow shorter: what follows one that is missing in the noise is left out.
    """
    counts = np.isfinite(motion.theta) & (motion.time_s >= 0)
    found = _crossings_s(motion.time_s[counts], motion.theta[counts], clear * motion.sigma_theta)
    swings = np.diff(found)
    longer = np.flatnonzero(swings[2:] > START.missing * np.maximum(swings[1:-1], swings[:-2]))
    return np.asarray(found[: longer[0] + 3] if longer.size else found)


def whole_s(motion: Motion) -> float:
    """End of what a fit takes of a run [s]: the last impact that is seen.

    What follows it is no more than noise, and holds impacts that no one sees.
    """
    crossings = crossings_s(motion)
    if crossings.size > 2:
        return float(crossings[-1])
    # the last that stands out of the noise, and of the ringing of a base in full contact
    moves = np.abs(motion.theta) > max(10 * motion.sigma_theta, 1e-3 * abs(motion.theta0))
    return 1.1 * (float(motion.time_s[moves][-1]) if moves.any() else 0.0) + 0.1


def first_peak_s(motion: Motion) -> float:
    """Instant of the first peak after an impact [s]; up to it the error has few minima."""
    crossings = crossings_s(motion)
    return 0.5 * float(crossings[0] + crossings[1]) if crossings.size > 2 else whole_s(motion)


def in_step(model: RunModel, at: Point, end_s: float, enough: float = START.in_step) -> Point:
    """A point with δ of the impacts up to an instant, by which swings last as long as measured.

    What precedes the first impact that is off by more than `enough` of its swing stays. How long a swing
    lasts after which rate is read off the swings of the model itself.
    """
    measured = crossings_s(model.motion)
    at = with_impacts(at, int(np.searchsorted(measured, end_s)))
    samples, rtol = model.until(1.1 * end_s, 4 * START.samples), 10 * RTOL_SCREENING
    n = min(measured.size, at.impacts.size + 1)
    for _ in range(START.passes):
        at = model.held(at, samples, rtol)
        own = _crossings_s(samples.time_s, model.here(at, samples, rtol).theta, model.motion.sigma_theta)
        seen = min(own.size, n)
        off = np.abs(own[1:seen] - measured[1:seen]) > enough * np.diff(measured[:seen])
        if seen < 2 or (seen == n and not off.any()):
            break
        # the impact after which a swing does not last as measured
        i = int(np.argmax(off)) if off.any() else seen - 1
        wanted = np.diff(np.append(own[i], measured[i + 1 : n]))
        rates = at.passages[:, 4]
        rates[i : n - 1] = _lasting(model.block, wanted, np.diff(own), rates, i)
        at = replace(at, rates=rates, impacts=np.where(rates > 0, at.impacts, 0.0))
    at = model.held(at, samples, rtol)
    impacts = np.clip(at.impacts, RATE_CHANGE[0] / 2, RATE_CHANGE[1] / 2)
    return _shared(replace(at, impacts=impacts, rates=None))


def _shared(at: Point) -> Point:
    """A point at which what the impacts of a rigid block share is its restitution."""
    if "r" not in at.values or not at.impacts.size:
        return at
    shared = float(np.exp(np.mean(np.log1p(at.impacts))))
    values = {**at.values, "r": min(at.values["r"] * shared, 0.999)}
    return replace(at, values=values, impacts=(1 + at.impacts) / shared - 1)


def _lasting(block: Block, wanted_s: Floats, own_s: Floats, rates: Floats, first: int) -> Floats:
    """Rates after which swings last as wanted, from the durations that swings with known rates have.

    Beyond these as of a rigid block. A base in full contact swings as long whatever its rate: where the rate
    changes by more than `START.steep` times what a rigid block needs, it is 0, none.
    """
    own_s = own_s[: rates.size]
    order = np.argsort(own_s)
    near = np.clip(wanted_s, own_s.min(), own_s.max())
    found = np.interp(near, own_s[order], rates[order])
    found *= _rate_after(block, wanted_s) / _rate_after(block, near)
    known = slice(first, min(own_s.size, first + wanted_s.size))
    n = known.stop - known.start
    rigid = np.log(_rate_after(block, wanted_s[:n]) / _rate_after(block, own_s[known]))
    found[:n][np.abs(np.log(found[:n] / rates[known])) > START.steep * np.abs(rigid)] = 0.0
    return np.asarray(found)


def _crossings_s(time_s: Floats, theta: Floats, least: float) -> Floats:
    """Instants at which a rotation changes its sign [s], between samples above a least angle [rad]."""
    clear = np.abs(theta) > least
    time_s, theta = time_s[clear], theta[clear]
    i = np.flatnonzero(np.signbit(theta[1:]) != np.signbit(theta[:-1]))
    return np.asarray(time_s[i] + np.diff(time_s)[i] * theta[i] / (theta[i] - theta[i + 1]))


def _rate_after(block: Block, duration_s: Floats) -> Floats:
    """Rate after an impact of a slender rigid block whose swing lasts so long, over a constant.

    With φ = θ_cr - |θ| and φ̈ = p² φ (Housner 1963, equation 6, doi:10.1785/BSSA0530020403) it is
    p θ_cr tanh(p T/2) after a duration T.
    """
    return np.asarray(np.tanh(0.5 * block.p * duration_s))


def scan(model: RunModel, horizon_s: float, most: int, every: int = 1) -> list[Point]:
    """Starts of a law without cases: the lowest local minima of the error over a grid, up to an instant [s].

    Such a law has one damping, or is rigid. Of the grid's dampings each `every`-th is tried.
    """
    law, beside = law_of(model.candidate), _beside(model)
    if not law.is_foundation:
        return _scan_rigid(model, horizon_s, beside, most)
    (ratio,), widths = law.ratios, list[dict[str, float]]([{}])
    if "width" in beside:  # as stated, and of a worn block that stands at the release
        worn = beside["width"] * np.array(START.worn)
        stands = model.block.height_m * float(np.tan(abs(model.motion.theta0)))
        widths = [{"width": width} for width in worn[worn > 1.05 * stands].tolist()] or widths
    ratios = np.geomspace(*PARAMETERS[ratio].grid)[::every]
    middle = {ratio: float(ratios[len(ratios) // 2])}
    first_k = _first_swing_k(model, first_peak_s(model.motion), middle, beside)
    k_grid = np.unique(np.append(np.geomspace(*PARAMETERS["k"].grid), first_k))
    points = [
        point_of(model, {**beside, **free, "k": k, ratio: k * c})
        for free, k, c in product(widths, k_grid.tolist(), ratios.tolist())
    ]
    shape = len(widths), len(k_grid), len(ratios)
    return _lowest(model, points, shape, model.until(horizon_s, START.grid), most)


def _beside(model: RunModel) -> dict[str, float]:
    """What is freed beside k, r and dampings, where a fit starts: as stated, else a trace."""
    stated = {"width": 2 * model.block.b, "theta0": model.motion.theta0}
    others = [name for name in model.names if name not in ("k", "r", *law_of(model.candidate).ratios)]
    return {name: stated.get(name, PARAMETERS[name].trace) for name in others}


def point_of(model: RunModel, values: Mapping[str, float], inputs: Floats | None = None) -> Point:
    """A point with these numbers and none of the impacts; inputs are as stated unless given."""
    inputs = np.zeros(len(model.inputs)) if inputs is None else inputs
    return Point({name: values[name] for name in model.names}, inputs, np.zeros(0))


def _lowest(
    model: RunModel, points: list[Point], shape: tuple[int, ...], samples: Samples, most: int
) -> list[Point]:
    """Lowest local minima of the mean square error on a grid of so many points each way."""
    curves = (model.here(point, samples, 10 * RTOL_SCREENING).theta for point in points)
    errors = np.array([np.mean((curve - samples.theta) ** 2) for curve in curves])
    cells = errors.reshape(shape)
    beside = np.lib.stride_tricks.sliding_window_view(np.pad(cells, 1, mode="edge"), (3,) * cells.ndim)
    minima = np.flatnonzero(cells == beside.min(axis=tuple(range(cells.ndim, 2 * cells.ndim))))
    best = sorted(minima.tolist(), key=lambda i: errors[i])[:most]
    return [points[i] for i in best]


def _first_swing_k(
    model: RunModel, horizon_s: float, ratios: Mapping[str, float], beside: Mapping[str, float]
) -> float:
    """Stiffness that puts the first impact where it was measured; near overturning the grid is too coarse."""
    crossings = crossings_s(model.motion)
    measured = float(crossings[0]) if crossings.size else horizon_s
    time_s = np.linspace(0.0, horizon_s, 4 * START.grid)
    low, high, _ = PARAMETERS["k"].grid
    while high > 1.002 * low:
        k = float(np.sqrt(low * high))
        values = {"k": k, **{name: k * each for name, each in ratios.items()}, **beside}
        theta = model.curve(point_of(model, values), time_s, 10 * RTOL_SCREENING)
        crossed = np.flatnonzero(theta * model.motion.theta0 < 0)
        late = time_s[crossed[0]] > measured if crossed.size else True
        low, high = (k, high) if late else (low, k)
    return float(high)


def _scan_rigid(model: RunModel, horizon_s: float, beside: Mapping[str, float], most: int) -> list[Point]:
    """Restitution of a rigid block; a width that is freed first, from the time of the first impact.

    Until then the motion is that of the width alone; the swings after it give r by their height.
    """
    grid = 1 - np.geomspace(*PARAMETERS["r"].grid)[::3]
    if "width" in beside:
        crossings = crossings_s(model.motion)
        fall = model.until(float(crossings[0]) if crossings.size else horizon_s, START.grid)
        low, high, _ = PARAMETERS["width"].grid
        stands = 1.002 * model.block.height_m * float(np.tan(abs(model.motion.theta0)))

        def error(width: float) -> float:
            at = point_of(model, {"r": 0.9, **beside, "width": width})
            return float(np.mean((model.curve(at, fall.time_s) - fall.theta) ** 2))

        limits = max(low * model.block.width_m, stands), high * model.block.width_m
        width = float(minimize_scalar(error, bounds=limits, options={"xatol": 1e-3 * limits[1]}).x)
        beside = {**beside, "width": width}
    points = [point_of(model, {"r": r, **beside}) for r in grid.tolist()]
    samples = model.until(horizon_s, START.grid)
    return _lowest(model, points, (len(points),), samples, most)


@dataclass(frozen=True, eq=False)
class Followed:
    """The starts of a run, followed over the first swings and the whole run with the impacts free.

    Where a law leaves more than the noise, the level of a sample is that of its residual.

    Parameters
    ----------
    model : RunModel
    known : Ended, optional
        Where another run of the record ends; its numbers of the law are the start.
    others : mapping of str to Followed
        Other candidates on the same run. A law with cases starts where these cases end; a case that is not
        among them is followed anew.
    """

    model: RunModel
    known: Ended | None = None
    others: "Mapping[str, Followed]" = field(default_factory=dict)

    def whole(self, roughly: bool = False) -> Ended:
        """The best end of the whole run, from the numbers of the law; `roughly` if it is far from the run."""
        known = [self.known] if self.known else self.glimpsed if roughly else self.screened
        # a search ends where the noise leaves durations of swings exact to a hundredth
        starts, sure = list[Point](), crossings_s(self.model.motion, START.sure)
        end_s = float(sure[-1]) if sure.size > START.screened else whole_s(self.model.motion)
        for end in known:
            values = {**_shared(end.at).values, "theta0": self.model.motion.theta0, "t0": 0.0}
            starts.append(point_of(self.model, values, end.at.inputs if self.known else None))
        if not (roughly and law_of(self.model.candidate).is_foundation):
            search = START.quick if roughly else START.search
            left = known[0].mean_square * (known[0].posed.level / self.model.sigma) ** 2
            return self._ends(end_s, starts, left, search)[0]
        # it leaves so much that priors hold the numbers only beside its residual
        start, posed = in_step(self.model, starts[0], end_s), self._posed(end_s, 1.0)
        off = posed.residual(start)[: posed.samples.measured.size] * posed.level / self.model.sigma
        return minimised(self._posed(end_s, float(np.mean(off**2))), start, *START.quick)

    @cached_property
    def glimpsed(self) -> list[Ended]:
        """Promising ends of a few evaluations on the first swings, the best one first."""
        motion, crossings = self.model.motion, crossings_s(self.model.motion)
        end_s = float(crossings[START.screened]) if crossings.size > START.screened else whole_s(motion)
        starts = self._from_cases() or scan(self.model, first_peak_s(motion), START.followed)
        return promising(self._ends(end_s, starts, 1.0, START.quick))

    def _from_cases(self) -> list[Point]:
        """Where the cases end on the first swings, with a trace of the damping that each lacks."""
        model, ends, cases = self.model, list[Ended](), CANDIDATES[self.model.candidate].cases
        for name in cases:
            with suppress(FreerockError, np.linalg.LinAlgError):  # another case may do
                ends += (self.others.get(name) or Followed(self._of(name))).glimpsed
        if cases and not ends:
            raise FreerockError("fits", f"{' and '.join(cases)} have no fit to start from", "exclude the run")
        best, found = sorted(ends, key=lambda end: end.over_noise)[: START.followed], list[Point]()
        for end in best:
            values = _shared(end.at).values
            lacking = {name: PARAMETERS[name].trace * values["k"] for name in law_of(model.candidate).ratios}
            of_law = {name: each for name, each in values.items() if name not in PER_RUN}
            found.append(point_of(model, lacking | _beside(model) | of_law))
        return found

    def _of(self, candidate: str) -> RunModel:
        """Another candidate on the same run."""
        model = self.model
        return RunModel(candidate, model.block, model.motion, model.settings, model.moves_inputs)

    @cached_property
    def screened(self) -> list[Ended]:
        """Promising ends on the first swings, sought until little changes, the best one first."""
        return promising([minimised(end.posed, _shared(end.at), *START.search) for end in self.glimpsed])

    def _ends(self, end_s: float, starts: list[Point], left: float, search: tuple[int, float]) -> list[Ended]:
        """Ends of starts on the samples up to an instant, the best one first."""
        posed = self._posed(end_s, left)
        begun = [in_step(self.model, start, end_s) for start in starts]
        errors = [float(np.sum(posed.residual(start) ** 2)) for start in begun]
        near = [
            start
            for start, error in zip(begun, errors, strict=True)
            if error <= START.promising * min(errors)
        ]
        return sorted((minimised(posed, start, *search) for start in near), key=lambda end: end.result.chisqr)

    def _posed(self, end_s: float, left: float) -> Posed:
        level = self.model.sigma * (float(np.sqrt(left)) if left > START.misfit else 1.0)
        every = self.model.until(end_s, 10**9)
        samples = replace(every, m=max(1, every.time_s.size // START.samples))
        return Posed(self.model, samples, START.sigma_r, level, RTOL_SEARCH)


def promising(ends: list[Ended]) -> list[Ended]:
    """Ends that are worth following, without those that have come to the same numbers."""
    least, found = min(end.mean_square for end in ends), list[Ended]()
    for end in sorted(ends, key=lambda each: each.mean_square):
        name = end.posed.model.names[0]
        alike = [abs(other.at.values[name] / end.at.values[name] - 1) < START.same for other in found]
        if end.mean_square <= START.promising * least and not any(alike):
            found.append(end)
    return found


def n_lifting(model: RunModel, at: Point) -> int:
    """How many impacts end a measured swing that lifts a side of the base, or come before one that does.

    What follows is the ringing of a base in full contact, at whose passages nothing is hit.
    """
    crossings = crossings_s(model.motion)
    if not law_of(model.candidate).is_foundation:
        return crossings.size
    block, bed, whole = model.block.as_found(at.values), Foundation.of(at.values), model.whole
    lifts = np.flatnonzero(np.abs(whole.theta) > static_depth(block, bed, 0.0) / block.flat)
    last_s = whole.time_s[lifts[-1]] if lifts.size else -np.inf
    return min(int(np.searchsorted(crossings, last_s)) + 1, crossings.size)


def with_impacts(at: Point, n_impacts: int) -> Point:
    """A point with the scatter of so many impacts; that of further ones is zero."""
    impacts = np.zeros(n_impacts)
    known = min(n_impacts, at.impacts.size)
    impacts[:known] = at.impacts[:known]
    return replace(at, impacts=impacts)
