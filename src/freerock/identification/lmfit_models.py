"""The laws as `lmfit.Model`s."""

from collections.abc import Mapping
from dataclasses import dataclass
from inspect import Parameter, Signature
from typing import Any, ClassVar

import lmfit
import numpy as np

from freerock.arrays import Floats, increasing, sampled
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError, of_kind
from freerock.identification.posed import bounds_of
from freerock.identification.run_model import RunModel
from freerock.identification.start import Followed
from freerock.models.block import Block
from freerock.models.free_parameters import LOGARITHMS, PARAMETERS, PER_RUN
from freerock.models.given import legal
from freerock.models.laws import GEOMETRIC, LAWS, Candidate, Rules
from freerock.models.simulate import Solver
from freerock.rotation.view import View, as_measured
from freerock.runs.motion import Motion

EXACT = Solver(1e-11)  # lmfit moves a number by as little as 1.5e-8 of it


@dataclass(frozen=True)
class _Theta:
    """θ(t) [rad] of a law as the sensor shows it: the function that lmfit calls."""

    law: str
    block: Block
    view: View | None
    rules: Rules

    @property
    def __name__(self) -> str:
        return self.law

    @property
    def names(self) -> dict[str, str]:
        """Names of the parameters by those that lmfit allows."""
        return {legal(name): name for name in (*LAWS[self.law].parameters, *PER_RUN)}

    @property
    def __signature__(self) -> Signature:
        return Signature([Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in ("time", *self.names)])

    def __call__(self, time: Floats, **values: float) -> Floats:
        self.__signature__.bind(time, **values)
        named = {self.names[name]: float(value) for name, value in values.items()}
        instants = increasing(time)
        return as_measured(self.law, self.block, named, instants, self.view, rules=self.rules, solver=EXACT)


class RockingModel(lmfit.Model):  # type: ignore[misc]
    """θ(t) [rad] as the sensor shows it, of a block that is released at the instant t0 [s].

    theta0 [rad] is the angle that the sensor shows before the release; without a view it is the rotation.
    It is the base of `HousnerModel`, `WinklerModel` and `HuntCrossleyModel`. Its parameters are those of the
    law, lambda as `lambda_`, then theta0 and t0 [SI]; `time` [s] since the release is the independent
    variable. A fit takes the noise to be white and each impact as the law has it: fit the first swings of a
    real block, from when the finger has left. `fit_run` takes the noise as at rest, impacts that scatter, and
    the laboratory's inputs for what they are.
    Motions are so exact that the steps of any method of lmfit give ±, in sums and products too. k has no
    upper bound for that: near the lower of two far bounds, lmfit's steps are coarse.

    Parameters
    ----------
    block : Block
    view : View, optional
        What the sensor makes of a motion (`freerock.view_of`); without it the rotation is compared as it is.
        θ of a record that freerock has read needs it: a laser sees corners that sink.
    rules : Rules, optional
        Of debonding and kinematics.
    **options
        Of `lmfit.Model`, such as prefix, or nan_policy="omit" for a θ with flagged samples.

    Examples
    --------
    >>> import freerock
    >>> import numpy as np
    >>> block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> time = np.arange(0, 1, 1e-3)
    >>> theta = freerock.simulate("winkler", block, {"k": 6.8e6, "c": 2e4}, time, theta0=0.17).theta
    >>> theta += 1e-4 * np.random.default_rng(1).standard_normal(time.size)
    >>> model = freerock.WinklerModel(block)
    >>> params = model.guess(theta, time=time)
    >>> result = model.fit(theta, params, time=time, weights=1 / 1e-4)
    >>> print(f"{result.params['k'].value:.1e}, reduced chi-square {result.redchi:.1f}")
    6.8e+06, reduced chi-square 1.0
    """

    law: ClassVar[str]

    def __init__(self, block: Block, *, view: View | None = None, rules: Rules = GEOMETRIC, **options: Any):
        of_kind("block", block, Block, "give freerock.Block(...)")
        if view is not None:
            of_kind("view", view, View, "give freerock.view_of(laser, block)")
        of_kind("rules", rules, Rules, "give freerock.Rules(...)")
        given = {"independent_vars": ["time"], "name": self.law, **options}
        super().__init__(_Theta(self.law, block, view, rules), **given)
        self.set_param_hint("theta0", value=block.theta_cr / 2)
        self.set_param_hint("t0", value=0.0)
        for name in LAWS[self.law].parameters:
            low, high = (0.0, np.inf) if PARAMETERS[name].fitted_as == "ratio" else PARAMETERS[name].bounds
            self.set_param_hint(legal(name), min=low, max=_upper(name, high), value=_first_value(name))

    def fit(
        self, data: Floats, params: lmfit.Parameters | None = None, weights: Any = None, **options: Any
    ) -> "lmfit.model.ModelResult":
        """As `lmfit.Model.fit`; one weight is that of all samples.

        Raises
        ------
        FreerockError
            Arrays of different shapes, no increasing time, other units, or NaN that is not left out.
        """
        if "time" in options:
            sampled(options["time"], data)
        if self.nan_policy == "raise" and np.isnan(data).any():
            raise FreerockError("theta", "has samples that are NaN", 'make the model with nan_policy="omit"')
        if weights is not None:  # lmfit leaves samples out of arrays alone
            weights = np.broadcast_to(np.asarray(weights, float), np.shape(data))
        return super().fit(data, params, weights=weights, **options)

    def guess(self, data: Floats, time: Floats, **given: Any) -> lmfit.Parameters:
        """Parameters to start a fit from, with the bounds that `fit_run` has, as it finds its own start.

        Parameters
        ----------
        data, time : ndarray, shape (n_time,)
            θ [rad], and increasing time since the release [s].
        **given
            Values or dicts in lmfit's words, which replace what is guessed. The measured release angle, as
            `theta0=run.motion.theta0`, is where the search starts; else it is the mean of what stands before
            the release, or the first sample.

        Raises
        ------
        FreerockError
            Arrays of different shapes, no increasing time, or fewer samples than parameters.
        """
        time, theta = sampled(time, data)
        # median of |second differences| of white noise of standard deviation 1: 0.6745 √6
        noise = float(np.nanmedian(np.abs(np.diff(theta, 2)))) / (0.6745 * np.sqrt(6.0))
        said = {
            name.removeprefix(self.prefix): dict(each) if isinstance(each, Mapping) else {"value": each}
            for name, each in given.items()
        }
        if unknown := {*said} - {*self.func.names}:
            what = f"{min(unknown)!r} is no parameter of {self.law}"
            raise FreerockError("guess", what, f"use {', '.join(self.func.names)}")
        before = theta[: max(1, int(np.searchsorted(time, 0.0)))]
        theta0 = float(said.get("theta0", {}).get("value", np.nanmean(before)))
        sigma = max(noise, 1e-7 * abs(theta0))  # of a simulated motion
        motion = Motion(time, theta, sigma, theta0, sigma, float(np.ptp(time)) / max(1, time.size - 1))
        law, rules = LAWS[self.law], self.func.rules
        candidate = Candidate(self.law, rules.kinematics if law.is_foundation else law.kinematics[0]).name
        settings = FitSettings(debonding=rules.debonding)
        model = RunModel(candidate, self.func.block, motion, settings, moves_inputs=False)
        found = Followed(model).whole().at.values
        for name, value in found.items():
            low, high = bounds_of(model, name)
            own = {"value": value, "min": low, "max": _upper(name, high)}
            said[legal(name)] = own | said.get(legal(name), {})
        return self.make_params(**said)


class HousnerModel(RockingModel):
    """The rigid block of Housner (1963, doi:10.1785/BSSA0530020403): r, theta0, t0; see `RockingModel`."""

    law = "housner"


class WinklerModel(RockingModel):
    """The block on springs k and dashpots c; then theta0, t0; see `RockingModel`.

    After Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024).
    """

    law = "winkler"


class HuntCrossleyModel(RockingModel):
    """The block on springs k whose damping lambda_ grows with depth; then theta0, t0; see `RockingModel`.

    After Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024).
    """

    law = "hunt_crossley"


def _upper(name: str, high: float) -> float:
    """The upper bound of a parameter; none of those that the optimiser of `fit_run` moves by logarithms."""
    return np.inf if PARAMETERS[name].fitted_as in LOGARITHMS else high


def _first_value(name: str) -> float:
    """The middle of the grid on which a fit seeks its start [SI]."""
    if name == "r":
        return 0.9
    middle = {
        each: float(np.sqrt(PARAMETERS[each].grid[0] * PARAMETERS[each].grid[1])) for each in (name, "k")
    }
    return middle[name] * (middle["k"] if PARAMETERS[name].fitted_as == "ratio" else 1.0)
