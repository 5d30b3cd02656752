"""Starts of a fit: a scan over a grid on the first swings, then horizons that grow with the impacts free."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import minimize_scalar

from freerock.arrays import Floats, Mask
from freerock.identification.posed import Ended, Posed, minimised
from freerock.identification.run_model import RTOL, RTOL_SCREENING, Point, RunModel, Samples
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import LAWS, law_of
from freerock.runs.motion import Motion


@dataclass(frozen=True)
class StartSettings:
    """How starts are sought and followed; by judgement, shown in docs/validation.md on drawn scenes.

    Parameters
    ----------
    grid, screening : int
        Samples of the error over a grid, and of a horizon before the whole run.
    followed : int
        Local minima of the grid that are followed.
    sigma_r : float
        Prior of the impacts' scatter while horizons grow: wide, so that no start loses the phase.
    ftol, most : float, int
        Relative change at which a horizon ends, and its evaluations.
    first : int
        Evaluations of the first horizon: a grid knows nothing of a width that is freed.
    worn : tuple of float
        Shares of the stated width, from which one that is freed starts.
    lost : float
        Times the mean square of the horizon before it, from which an end has lost the phase.
    hurried : (int, float)
        Evaluations and relative change of a law that is far from the run.
    clear : float
        Standard deviations of the noise, above which a rotation has a sign.
    missing : float
        Times the two swings before it, from which a swing holds one that the noise hides.
    growth : int
        Times the swings of a horizon, those of the next one; where that loses the phase, half of it.
    screened : int
        Swings of the first run, on which candidates are screened.
    promising : float
        Times the least mean square of a horizon, up to which its ends are followed.
    misfit : float
        Times the noise's power, from which a residual sets the level of a sample itself.
    same : float
        Relative difference of the first number, up to which two ends are one.
    """

    grid: int = 250
    screening: int = 1000
    followed: int = 3
    sigma_r: float = 0.03
    ftol: float = 1e-3
    most: int = 12
    first: int = 60
    worn: tuple[float, ...] = (0.9, 0.95, 1.0)
    lost: float = 4.0
    hurried: tuple[int, float] = (8, 3e-3)
    clear: float = 10.0
    missing: float = 1.4
    growth: int = 2
    screened: int = 6
    promising: float = 5.0
    misfit: float = 1.5
    same: float = 3e-3


START = StartSettings()


def crossings_s(motion: Motion) -> Floats:
    """Instants at which the measured rotation changes its sign while the block moves [s].

    Swings grow shorter: what follows one that is missing in the noise is left out.
    """
    counts = np.isfinite(motion.theta) & (motion.time_s >= 0)
    time_s, theta = motion.time_s[counts], motion.theta[counts]
    clear = np.abs(theta) > START.clear * motion.sigma_theta
    time_s, theta = time_s[clear], theta[clear]
    turned = np.flatnonzero(np.signbit(theta[1:]) != np.signbit(theta[:-1]))
    found = 0.5 * (time_s[turned] + time_s[turned + 1])
    swings = np.diff(found)
    longer = np.flatnonzero(swings[2:] > START.missing * np.maximum(swings[1:-1], swings[:-2]))
    return np.asarray(found[: longer[0] + 3] if longer.size else found)


def moving_s(motion: Motion) -> float:
    """Last instant at which the block moves [s]; 0 where it never does."""
    moves = _moves(motion)
    return float(motion.time_s[moves][-1]) if moves.any() else 0.0


def _moves(motion: Motion) -> Mask:
    """Which samples stand out of the noise, and of the ringing of a base in full contact."""
    return np.asarray(np.abs(motion.theta) > max(10 * motion.sigma_theta, 1e-3 * abs(motion.theta0)))


def horizons_s(motion: Motion) -> list[float]:
    """Ends of growing horizons [s]: the first peak after an impact, then more and more swings.

    What follows these is no more than noise, and holds impacts that no one sees. Up to the first peak the
    error has few minima.
    """
    crossings = crossings_s(motion)
    if crossings.size < 3:
        return [1.1 * moving_s(motion) + 0.1]
    last = float(crossings[-1])
    found, n = [0.5 * float(crossings[0] + crossings[1])], 2
    while n < crossings.size:
        found.append(float(crossings[n]))
        n *= START.growth
    return [*(each for each in found if each < 0.95 * last), last]


def scan(model: RunModel) -> list[Point]:
    """Starts of a law: the lowest local minima of the error over a grid, on the first swing.

    A law with cases starts from the minima of these, with a trace of the number that each lacks.
    """
    return _scan(model, horizons_s(model.motion)[0], START.followed)


def scan_whole(model: RunModel, most: int) -> list[Point]:
    """Starts of a law whose every impact is believed, from the error of the whole run."""
    return _scan(model, np.inf, most)


def _scan(model: RunModel, horizon_s: float, most: int) -> list[Point]:
    law = law_of(model.candidate)
    beside = _beside(model)
    if not law.is_foundation:
        return _scan_rigid(model, horizon_s, beside, most)
    samples = model.until(horizon_s, START.grid)
    laws = law.cases or (model.law,)
    found = list[tuple[float, Point]]()
    for case in laws:
        ratio = LAWS[case].ratios[0]
        k_grid = np.geomspace(*PARAMETERS["k"].grid)
        ratios = np.geomspace(*PARAMETERS[ratio].grid)
        lacking = {name: PARAMETERS[name].trace for name in law.ratios if name != ratio}
        middle = {ratio: float(ratios[len(ratios) // 2]), **lacking}
        first_s = horizons_s(model.motion)[0]
        k_grid = np.sort(np.append(k_grid, _first_swing_k(model, first_s, middle, beside)))
        points = [
            _at(
                model,
                {
                    **beside,
                    **free,
                    "k": k,
                    ratio: k * c,
                    **{name: k * each for name, each in lacking.items()},
                },
            )
            for free, k, c in product(_widths(model, beside), k_grid.tolist(), ratios.tolist())
        ]
        shape = len(points) // (len(k_grid) * len(ratios)), len(k_grid), len(ratios)
        found += _lowest(model, points, shape, samples, most)
    return [point for _, point in sorted(found, key=lambda each: each[0])[:most]]


def _widths(model: RunModel, beside: Mapping[str, float]) -> list[dict[str, float]]:
    """Widths from which a freed one starts [m]: as stated, and of a worn block that stands at the release."""
    if "width" not in beside:
        return [{}]
    stands = model.block.height_m * float(np.tan(abs(model.motion.theta0)))
    widths = beside["width"] * np.array(START.worn)
    return [{"width": width} for width in widths[widths > 1.05 * stands].tolist()] or [{}]


def _beside(model: RunModel) -> dict[str, float]:
    """What is freed beside the law, as stated."""
    stated = {"width": 2 * model.block.b, "tilt": 0.0, "edge_radius": PARAMETERS["edge_radius"].trace}
    stated["theta0"], stated["t0"] = model.motion.theta0, 0.0
    own = law_of(model.candidate).parameters
    return {name: stated[name] for name in model.names if name not in own}


def _at(model: RunModel, values: Mapping[str, float]) -> Point:
    return Point({name: values[name] for name in model.names}, np.zeros(len(model.inputs)), np.zeros(0))


def _lowest(
    model: RunModel, points: list[Point], shape: tuple[int, ...], samples: Samples, most: int
) -> list[tuple[float, Point]]:
    """Lowest local minima of the mean square error on a grid of so many points each way."""
    errors = np.array(
        [
            np.mean((model.curve(point, samples.time_s, 10 * RTOL_SCREENING) - samples.theta) ** 2)
            for point in points
        ]
    )
    cells = errors.reshape(shape)
    beside = np.lib.stride_tricks.sliding_window_view(np.pad(cells, 1, mode="edge"), (3,) * cells.ndim)
    minima = np.flatnonzero(cells == beside.min(axis=tuple(range(cells.ndim, 2 * cells.ndim))))
    best = sorted(minima.tolist(), key=lambda i: errors[i])[:most]
    return [(float(errors[i]), points[i]) for i in best]


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
        theta = model.curve(_at(model, values), time_s, 10 * RTOL_SCREENING)
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
            at = _at(model, {"r": 0.9, **beside, "width": width})
            return float(np.mean((model.curve(at, fall.time_s) - fall.theta) ** 2))

        limits = max(low * model.block.width_m, stands), high * model.block.width_m
        width = float(minimize_scalar(error, bounds=limits, options={"xatol": 1e-3 * limits[1]}).x)
        beside = {**beside, "width": width}
    points = [_at(model, {"r": r, **beside}) for r in grid.tolist()]
    samples = model.until(horizon_s, START.grid)
    return [point for _, point in _lowest(model, points, (len(points),), samples, most)]


class Followed:
    """The starts of a run, followed over growing horizons with the impacts free.

    A horizon of one swing knows nothing of what follows; with the impacts free none loses the phase. Where a
    law leaves more than the noise, the level of a sample is that of its residual.

    Parameters
    ----------
    model : RunModel
    noise : float
        Standard deviation of the noise of a sample [rad].
    starts : list of Point, optional
        By default those of `scan`.
    """

    def __init__(self, model: RunModel, noise: float, starts: list[Point] | None = None) -> None:
        self.model, self.noise = model, noise
        self._starts, self._ends, self._done, self._left = starts, list[Ended](), 0, 1.0
        self._horizons, self._crossings = horizons_s(model.motion), crossings_s(model.motion)
        self.search = START.most, START.ftol

    @property
    def _hurries(self) -> bool:
        """Whether the law is far from the run."""
        return self.search == START.hurried

    def hurry(self) -> None:
        """Follow a law that is far from the run with fewer evaluations."""
        self.search = START.hurried

    def screened(self) -> Ended:
        """The best end of the first horizon that holds `START.screened` swings, or of the last one."""
        while self._done < len(self._horizons) and self._swings(self._done - 1) < START.screened:
            self._grow()
        return min(self._ends, key=lambda end: end.objective)

    def to_the_end(self) -> Ended:
        """The best end of the last horizon."""
        while self._done < len(self._horizons):
            self._grow()
        return min(self._ends, key=lambda end: end.objective)

    def over_noise(self, end: Ended) -> float:
        """Mean square of the residual and the priors at an end, over the noise."""
        return end.mean_square * (end.posed.level / self.noise) ** 2

    def _swings(self, i: int) -> int:
        """Swings that a horizon holds; none before the first."""
        return int(np.searchsorted(self._crossings, self._horizons[i])) if i >= 0 else 0

    def _grow(self) -> None:
        """One horizon more; inputs move up to that of `screened`, and in the last one."""
        horizon_s = self._horizons[self._done]
        begun = [end.at for end in promising(self._ends)] if self._ends else self._starts or scan(self.model)
        last, (most, ftol) = self._done == len(self._horizons) - 1, self.search
        n_impacts, before = self._swings(self._done), self._swings(self._done - 1)
        samples = self.model.until(horizon_s, START.screening)
        level = self.noise * float(np.sqrt(self._left)) if self._left > START.misfit else self.noise
        rtol, holds = RTOL if last else 10 * RTOL, not last and before >= START.screened
        posed = Posed(self.model, samples, START.sigma_r, level, rtol, holds_inputs=holds)
        most = most if self._ends else max(most, START.first)
        ends = [minimised(posed, with_impacts(start, n_impacts), most, ftol) for start in begun]
        left = min(map(self.over_noise, ends))
        is_lost = self._ends and not self._hurries and left > START.lost * max(self._left, 1.0)
        if is_lost and self._halved(horizon_s):
            return
        self._ends, self._left = ends, left
        self._done += 1

    def _halved(self, horizon_s: float) -> bool:
        """Whether a horizon with half of the further swings could be put before one."""
        before = int(np.searchsorted(self._crossings, self._horizons[self._done - 1]))
        further = int(np.searchsorted(self._crossings, horizon_s)) - before
        if further < 2:
            return False
        self._horizons.insert(self._done, float(self._crossings[before + further // 2]))
        return True


def promising(ends: list[Ended]) -> list[Ended]:
    """Ends that are worth following, without those that have come to the same numbers."""
    least, found = min(end.mean_square for end in ends), list[Ended]()
    for end in sorted(ends, key=lambda each: each.mean_square):
        name = end.posed.model.names[0]
        alike = [abs(other.at.values[name] / end.at.values[name] - 1) < START.same for other in found]
        if end.mean_square <= START.promising * least and not any(alike):
            found.append(end)
    return found


def with_impacts(at: Point, n_impacts: int) -> Point:
    """A point with the scatter of so many impacts; that of further ones is zero."""
    impacts = np.zeros(n_impacts)
    known = min(n_impacts, at.impacts.size)
    impacts[:known] = at.impacts[:known]
    return replace(at, impacts=impacts)
