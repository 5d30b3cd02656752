"""The least-squares problem: samples, fitted parameters, residual and derivatives.

Positive parameters are fitted as logarithms, damping as the logarithm of its ratio to k, the width as its
ratio to the nominal one (`models.free_parameters.PARAMETERS`).
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from freerock.arrays import Floats, Mask
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.models.free_parameters import OF_RECORD, PARAMETERS, PER_RUN, parameter_of
from freerock.models.given import Given, evaluated, in_order
from freerock.models.laws import CANDIDATES, MODELS, Rules, extended_by, law_of
from freerock.models.simulate import Solver
from freerock.noise.spectrum import averaged
from freerock.rotation.as_measured import as_measured
from freerock.runs.motion import Motion
from freerock.runs.release import FAR, lowered

RTOL_RESIDUAL, RTOL_DERIVATIVES = 1e-6, 1e-8  # rtol of the residual, and of its derivatives
STRIDE = 30.0  # times the steps of the difference quotients, at the tolerance of the residual


@dataclass(frozen=True)
class ReleaseLimits:
    """How far the release of a fit may be off what was measured.

    Parameters
    ----------
    wall : float
        Standard uncertainties to either side, within which a search keeps it.
    least_share, least_s : float
        Least uncertainty of the angle, as a share of it, and of the instant [s].
    loose_share, loose_s : float
        The same to either side of a release that is loose: a push, or a slow finger.
    """

    wall: float = 6.0
    least_share: float = 0.002 / 6.0
    least_s: float = 1e-3 / 6.0
    loose_share: float = FAR
    loose_s: float = 0.05


RELEASE = ReleaseLimits()


@dataclass(frozen=True)
class Samples:
    """Samples that count, of one run after the other.

    Parameters
    ----------
    time_s, theta : ndarray, shape (n_samples,)
        Time since the release [s] and measured rotation [rad].
    lengths : tuple of int
        Samples of each run.
    m : int
        How many samples are averaged into one.
    """

    time_s: Floats
    theta: Floats
    lengths: tuple[int, ...]
    m: int = 1

    @cached_property
    def runs(self) -> list[slice]:
        """Where the samples of each run lie."""
        ends = np.cumsum(self.lengths)
        return [slice(end - n, end) for n, end in zip(self.lengths, ends, strict=True)]

    def averaged(self, values: Floats) -> Floats:
        """Means of m samples each, times √m: their noise is that of one sample."""
        if len(self.lengths) == 1:
            return np.ascontiguousarray(averaged(values, self.m))
        return np.ascontiguousarray(np.concatenate([averaged(values[run], self.m) for run in self.runs]))


@dataclass(frozen=True)
class Problem:
    """A model, the runs it is fitted to, and what is freed.

    Parameters
    ----------
    model : str
    blocks : tuple of Block
        That of each run.
    motions : tuple of Motion
    settings : FitSettings
    r_low : float
        Least r: a block that stops too soon is out of step for less time, which would be a false minimum.
    rtol : float
        Of the integrator.
    fine : float
        Loosest rtol of the derivatives.
    stride : float
        Times the steps of the difference quotients, which a looser `fine` requires.
    tilt : float
        Of the base, to the right, from which a fit starts that frees it [rad].
    directions : ndarray, shape (n_parameters, n_parameters), or None
        Steps of all the fitted numbers, a column each, along which the difference quotients of a single run
        are taken; None takes them number by number.
    walled : bool
        Whether a search keeps the release near what was measured (`release_bounds`); else its prior does.
    """

    model: str
    blocks: tuple[Block, ...]
    motions: tuple[Motion, ...]
    settings: FitSettings
    r_low: float
    rtol: float = RTOL_RESIDUAL
    fine: float = RTOL_DERIVATIVES
    stride: float = 1.0
    tilt: float = 0.0
    directions: Floats | None = None
    walled: bool = True

    @cached_property
    def common(self) -> tuple[str, ...]:
        """Parameters that all runs share."""
        return (*MODELS[self.model], *(name for name in OF_RECORD if name in self.settings.free))

    @cached_property
    def own(self) -> tuple[str, ...]:
        """Parameters of each run."""
        return tuple(name for name in PER_RUN if name in self.settings.free)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All parameters; those of a run are numbered where there are several."""
        numbered = [
            name if len(self.motions) == 1 else f"{name}_{i}"
            for i in range(1, len(self.motions) + 1)
            for name in self.own
        ]
        return (*self.common, *numbered)

    @cached_property
    def is_logarithm(self) -> Mask:
        """Which of the fitted numbers are logarithms."""
        return np.array([parameter_of(name).is_logarithm for name in self.names])

    @cached_property
    def is_ratio(self) -> Mask:
        """Which of them are ratios to the stiffness, the first parameter; none where parameters are given."""
        return np.array([not self.given and parameter_of(name).fitted_as == "ratio" for name in self.names])

    @cached_property
    def given(self) -> dict[str, Given]:
        """What is said beforehand of the law's parameters, by name."""
        return self.settings.given(self.model)

    @cached_property
    def varied(self) -> Mask:
        """Which of the fitted numbers a fit finds: neither fixed nor tied."""
        return np.array([name not in self.given or self.given[name].varies for name in self.names])

    @cached_property
    def rules(self) -> Rules:
        """The rules of the simulation."""
        return CANDIDATES[self.model].rules(self.settings.debonding)

    def physical(self, x: Floats) -> Floats:
        """Parameters in SI units from the fitted numbers."""
        value = np.array(x, dtype=float)
        value[self.is_ratio] += value[0]
        value[self.is_logarithm] = np.exp(value[self.is_logarithm])
        if "width" in self.common:
            value[self.common.index("width")] *= self.blocks[0].width_m
        for name, each in self.given.items():
            if each.value is not None and not each.varies:
                value[self.names.index(name)] = each.value
        for name in in_order(self.given):
            known = dict(zip(MODELS[self.model], value.tolist(), strict=False))
            value[self.names.index(name)] = found = evaluated(self.given[name].expr, known)
            if PARAMETERS[name].is_logarithm and found <= 0:
                where, what = f"fits.parameters: {name}", f"{self.given[name].expr} is {found:.4g}"
                raise FreerockError(where, what, "tie it to a positive expression")
        return value

    def named(self, x: Floats) -> dict[str, float]:
        """Parameters in SI units by their names, from the fitted numbers."""
        return dict(zip(self.names, self.physical(x).tolist(), strict=True))

    def gradient(self, x: Floats, step: float = 1e-6) -> Floats:
        """Derivatives of the parameters in SI units by the fitted numbers, 0 by those that do not vary.

        `step` is that of the fitted numbers where some are tied.
        """
        if not self.varied.all():
            steps = step * np.diag(self.varied.astype(float))
            return np.array([self.physical(x + s) - self.physical(x - s) for s in steps]).T / (2 * step)
        gradient = np.eye(len(x))
        gradient[self.is_ratio, 0] = 1.0
        scale = np.where(self.is_logarithm, self.physical(x), 1.0)
        if "width" in self.common:
            scale[self.common.index("width")] = self.blocks[0].width_m
        return scale[:, None] * gradient

    def fitted(self, values: Sequence[float]) -> list[float]:
        """The fitted numbers of the model's parameters from those in SI units, the inverse of `physical`."""
        return [
            fitted(name, value / values[0] if PARAMETERS[name].fitted_as == "ratio" else value)
            for name, value in zip(MODELS[self.model], values, strict=True)
        ]

    def start(self, common: Sequence[float]) -> Floats:
        """All fitted numbers to start from, of those of the law, in which dampings are ratios to k; all as
        they are given where `common` holds all."""
        if len(common) == len(self.names):
            return self.completed(np.array(common)) if self.given else np.array(common)
        width = 2 * self.blocks[0].b / self.blocks[0].width_m
        start = {"width": width, "tilt": self.tilt, "edge_radius": PARAMETERS["edge_radius"].trace}
        as_given = [start[name] for name in self.common[len(common) :]]
        own = [measured_start(motion)[name] for motion in self.motions for name in self.own]
        x = np.array([*common, *as_given, *own])
        return self.completed(x) if self.given else x

    def completed(self, x: Floats) -> Floats:
        """Fitted numbers of a start of which parameters are given: dampings by themselves, within bounds, and
        what does not vary as it is given."""
        x = np.array(x, dtype=float)
        first = len(MODELS[self.model])
        ratios = [parameter_of(name).fitted_as == "ratio" for name in MODELS[self.model]]
        x[:first] += np.where(ratios, x[0], 0.0)
        low, high = np.array(self.bounds()).T
        return self.consistent(np.where(self.varied, np.clip(x, low, high), x))

    def consistent(self, x: Floats) -> Floats:
        """Fitted numbers of which those that do not vary are as those that do have them."""
        if self.varied.all():
            return x
        x, value = np.array(x, dtype=float), self.physical(x)
        for i in np.flatnonzero(~self.varied):
            x[i] = fitted(self.names[i], value[i])
        return x

    def start_at(self, values: Mapping[str, float]) -> Floats:
        """All fitted numbers to start from, with the parameters given [SI]; what is not is as measured."""
        x = self.start(self.fitted([values[name] for name in MODELS[self.model]]))
        for i, name in enumerate(self.names):
            if name in values and name not in MODELS[self.model]:
                x[i] = values[name] / (self.blocks[0].width_m if name == "width" else 1.0)
        return x

    @property
    def shares_curve(self) -> bool:
        """Whether a curve of the residual is exact enough for derivatives, as one in closed form is."""
        return self.rtol <= self.fine or not (law_of(self.model).is_foundation or "tilt" in self.names)

    def rough(self) -> "Problem":
        """The same problem with derivatives that are no more exact than the residual; those of a rigid
        block are in closed form."""
        return replace(self, fine=RTOL_RESIDUAL, stride=STRIDE) if law_of(self.model).is_foundation else self

    def alone(self) -> "Problem":
        """The same problem on the first run only."""
        return replace(self, blocks=self.blocks[:1], motions=self.motions[:1])

    def bounds(self) -> list[tuple[float, float]]:
        """Lower and upper bound of each fitted number."""
        least = 1e-4 if law_of(self.model).cases else 1.0  # one of its dampings may be a trace
        bounds: list[tuple[float, float]] = []
        r_most = 1 - PARAMETERS["r"].grid[0]
        for name in self.common:
            low, high = (self.r_low, r_most) if name == "r" else PARAMETERS[name].bounds
            if PARAMETERS[name].fitted_as == "ratio":
                low *= least
            given = self.given.get(name, Given())
            if self.given and PARAMETERS[name].fitted_as == "ratio":
                low, high = low * np.exp(bounds[0][0]), high * np.exp(bounds[0][1])
            if given.max is not None and given.max <= low:  # r may be said to stop the block
                low = PARAMETERS[name].bounds[0]
            low = low if given.min is None else max(given.min, low)
            high = high if given.max is None else min(given.max, high)
            bounds.append((fitted(name, low), fitted(name, high)))
        for motion in self.motions:
            half = release_bounds(motion)
            if self.settings.loose_release or not self.walled:
                half |= {"theta0": RELEASE.loose_share * abs(motion.theta0), "t0": RELEASE.loose_s}
            centre = measured_start(motion)
            bounds += [(centre[name] - half[name], centre[name] + half[name]) for name in self.own]
        return bounds

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper bound of each parameter [SI]; a damping fitted as a ratio has those of its sign."""
        low, high = np.array(self.bounds()).T
        low, high = (
            np.where(self.is_logarithm, np.exp(np.where(self.is_logarithm, each, 0.0)), each)
            for each in (low, high)
        )
        if "width" in self.common:
            at = self.common.index("width")
            low[at], high[at] = low[at] * self.blocks[0].width_m, high[at] * self.blocks[0].width_m
        return np.where(self.is_ratio, 0.0, low), np.where(self.is_ratio, np.inf, high)

    def prior_of_release(self, x: Floats) -> tuple[Floats, Floats]:
        """What is measured of each release, as rows of a least-squares problem.

        Returns
        -------
        value : ndarray, shape (n_rows,)
            How many standard uncertainties theta0 and t0 lie off what was measured.
        rows : ndarray, shape (n_rows, n_parameters)
            Their derivatives by the fitted numbers. No row where the release is free.
        """
        n_common, n_own = len(self.common), len(self.own)
        rows, value = [], []
        if not (self.settings.loose_release or self.walled):
            for i, motion in enumerate(self.motions):
                u, block = release_uncertainty(motion), self.blocks[i]
                # a finger that fades lowers the top
                fall = block.p**2 * np.sin(block.theta_cr - abs(motion.theta0))
                u["theta0"] = float(np.hypot(u["theta0"], lowered(fall, motion.fit_start_s)))
                centre = measured_start(motion)
                for j, name in enumerate(self.own):
                    at = n_common + i * n_own + j
                    value.append((x[at] - centre[name]) / u[name])
                    rows.append(np.eye(len(x))[at] / u[name])
        return np.array(value), np.reshape(rows, (-1, len(x)))

    def at_bound(self, x: Floats) -> Mask:
        """Which of the fitted numbers lie at a bound."""
        low, high = np.array(self.bounds()).T
        return np.asarray((np.minimum(x - low, high - x) < 1e-4 * (high - low)) & self.varied)

    def held(self, x: Floats) -> Mask:
        """Which of the fitted numbers a fit can't move: at a bound, fixed or tied."""
        return self.at_bound(x) | ~self.varied

    def samples(self, horizon_s: float = np.inf, most: float = np.inf, m: int = 1) -> Samples:
        """Samples that count up to the horizon, thinned to `most` per run or averaged m by m."""
        times, thetas = [], []
        for motion in self.motions:
            begin = np.searchsorted(motion.time_s, motion.fit_start_s)
            counts = slice(begin, np.searchsorted(motion.time_s, horizon_s, "right"))
            time_s, theta = motion.time_s[counts], motion.theta[counts]
            valid = np.isfinite(theta)
            if not valid.all():
                time_s, theta = time_s[valid], theta[valid]
            some = slice(None, None, max(1, int(len(theta) // most)))
            times.append(time_s[some])
            thetas.append(theta[some])
        return Samples(np.concatenate(times), np.concatenate(thetas), tuple(map(len, times)), m)

    def motion(
        self,
        x: Floats,
        i: int,
        time_s: Floats,
        rtol: float | None = None,
        added: Mapping[str, float] | None = None,
        rate: Floats | None = None,
    ) -> Floats:
        """Modelled θ of run i at the measured run's clock, as its sensor would have it [rad]; an overturned
        block lies at ±π/2.

        `added` is what neither the law nor the fit has, of a wider law or of the record [SI]; `rate`, if
        given, receives the rate of what is seen [rad/s].
        """
        value, n_common, n_own = self.physical(x).tolist(), len(self.common), len(self.own)
        own = dict(zip(self.own, value[n_common + i * n_own :], strict=False))
        values = {"theta0": self.motions[i].theta0, **dict(zip(self.common, value, strict=False)), **own}
        model = next((m for each, m in extended_by(self.model).items() if each in (added or {})), self.model)
        laboratory = self.motions[i].laboratory
        if laboratory is not None and laboratory.tilt and "tilt" not in self.common:
            values["tilt"] = laboratory.tilt
        return as_measured(
            CANDIDATES[model].law,
            self.blocks[i],
            {**values, **added} if added else values,
            time_s,
            self.motions[i].view,
            rules=self.rules,
            solver=Solver(rtol or self.rtol),
            theta_rate=rate,
        )

    def curve(
        self,
        x: Floats,
        samples: Samples,
        rtol: float | None = None,
        added: Mapping[str, float] | None = None,
        rate: Floats | None = None,
    ) -> Floats:
        """Modelled θ of all runs at the samples [rad]; all else as in `motion`."""
        if "t0" not in self.own:
            rate = None
        curves = []
        for i, run in enumerate(samples.runs):
            own = None if rate is None else rate[run]
            curves.append(self.motion(x, i, samples.time_s[run], rtol, added, own))
        return np.concatenate(curves) if len(curves) > 1 else curves[0]

    @property
    def exact_rtol(self) -> float:
        """Tolerance of the derivatives."""
        return min(self.rtol, self.fine)

    def exact_curve(self, x: Floats, samples: Samples) -> tuple[Floats, Floats]:
        """`curve` and its rate [rad/s], given where t0 is fitted, as exact as derivatives require."""
        rate = np.empty(len(samples.time_s))
        return self.curve(x, samples, self.exact_rtol, rate=rate), rate

    def residual(self, x: Floats, samples: Samples) -> Floats:
        """Modelled minus measured θ [rad]."""
        return samples.averaged(self.curve(x, samples) - samples.theta)

    def jacobian(
        self,
        x: Floats,
        samples: Samples,
        central: bool = False,
        wanted: Collection[str] | None = None,
        known: tuple[Floats, Floats] | None = None,
    ) -> Floats:
        """Derivatives of θ, shape (n_samples, n_parameters): difference quotients, but -θ̇ for the release.

        The steps are about as small as the smallest standard errors, which requires the tolerance `fine`.
        Central ones leave no range: at a radius of 0 the quotient is the forward one.
        Those of parameters that are not `wanted` are left 0. `known` is `exact_curve` at x.
        """
        if self.directions is not None:
            return self._along(self.directions, x, samples)
        known = known or self.exact_curve(x, samples)
        jacobian = np.zeros((len(samples.time_s), len(x)), order="F")  # sums go down columns
        n_common, n_own = len(self.common), len(self.own)
        for i, run in enumerate(samples.runs):
            for j, name in enumerate((*self.common, *self.own)):
                column = j if j < n_common else j + i * n_own
                if not self.varied[column] or (wanted is not None and name not in wanted):
                    continue
                if name == "t0":
                    quotient = -known[1][run]
                else:
                    parameter = parameter_of(name)
                    up, step = np.array(x, dtype=float), self.stride * parameter.step
                    traces = self._traces(x, column)
                    up[column] += step if traces <= 1 else np.log1p(step * traces)
                    later = self.motion(up, i, samples.time_s[run], self.exact_rtol)
                    quotient = (later - known[0][run]) / (step * max(traces, 1.0))
                    least = parameter.bounds[0] if parameter.fitted_as == "value" else -np.inf
                    if central and traces <= 1 and x[column] - step >= least:  # no edges of a radius below 0
                        up[column] -= 2 * step
                        later -= self.motion(up, i, samples.time_s[run], self.exact_rtol)
                        quotient = later / (2 * step)
                jacobian[run, column] = quotient
        return jacobian

    def _traces(self, x: Floats, column: int) -> float:
        """A parameter's trace over its value, 0 of one that is no ratio.

        Below its trace, steps are those of the trace: the errors of the integrator hide smaller ones.
        """
        parameter = parameter_of(self.names[column])
        if parameter.fitted_as != "ratio":
            return 0.0
        return parameter.trace * float(np.exp((0.0 if self.is_ratio[column] else x[0]) - x[column]))

    def _along(self, directions: Floats, x: Floats, samples: Samples) -> Floats:
        """Derivatives by the fitted numbers from central difference quotients along the directions."""
        moved = [
            (self.curve(x + step, samples, self.exact_rtol) - self.curve(x - step, samples, self.exact_rtol))
            / 2
            for step in directions.T
        ]
        return np.asarray(np.linalg.solve(directions.T, np.array(moved)).T)


def measured_start(motion: Motion) -> dict[str, float]:
    """What was measured of the start of a run: theta0 [rad] and t0 [s]."""
    return {"theta0": motion.theta0, "t0": 0.0}


def release_bounds(motion: Motion) -> dict[str, float]:
    """How far theta0 [rad] and t0 [s] of a search may be off what was measured."""
    return {name: RELEASE.wall * u for name, u in release_uncertainty(motion).items()}


def release_uncertainty(motion: Motion) -> dict[str, float]:
    """Standard uncertainty of the measured theta0 [rad] and t0 [s], at least 0.03 % and 0.17 ms."""
    return {
        "theta0": max(motion.theta0_stderr, RELEASE.least_share * abs(motion.theta0)),
        "t0": max(motion.t0_stderr, RELEASE.least_s),
    }


def fitted(name: str, value: float) -> float:
    """The number that is fitted, of a value or of a ratio to k."""
    return float(np.log(value)) if PARAMETERS[name].is_logarithm else value
