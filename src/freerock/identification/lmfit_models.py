"""The laws as `lmfit.Model`s."""

from collections.abc import Mapping
from inspect import Parameter, Signature
from typing import Any, ClassVar

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.run_model import RTOL, RunModel
from freerock.identification.start import Followed
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS, PER_RUN
from freerock.models.given import legal
from freerock.models.laws import GEOMETRIC, LAWS, Candidate, Rules
from freerock.models.simulate import Solver
from freerock.rotation.as_measured import as_measured
from freerock.rotation.view import View
from freerock.runs.motion import Motion


class RockingModel(lmfit.Model):  # type: ignore[misc]
    """θ(t) [rad] of a block that is released at an angle theta0 [rad] at the instant t0 [s].

    Its parameters are those of the law, lambda as `lambda_`, then theta0 and t0 [SI]; `time` [s] is the
    independent variable. A fit takes the noise to be white; `fit_run` takes it as at rest, and the
    laboratory's inputs for what they are.

    Parameters
    ----------
    block : Block
    view : View, optional
        What the sensor makes of a motion; without it the rotation is compared as it is.
    rules : Rules, optional
        Of debonding and kinematics.
    **options
        Of `lmfit.Model`, such as prefix.
    """

    law: ClassVar[str]

    def __init__(self, block: Block, *, view: View | None = None, rules: Rules = GEOMETRIC, **options: Any):
        self.block, self.view, self.rules = block, view, rules
        self.sources = {legal(name): name for name in (*LAWS[self.law].parameters, *PER_RUN)}

        def theta(time: Floats, **values: float) -> Floats:
            named = {self.sources[name]: float(value) for name, value in values.items()}
            return as_measured(self.law, block, named, time, view, rules=rules, solver=Solver(RTOL))

        arguments = [Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in ("time", *self.sources)]
        theta.__signature__ = Signature(arguments)  # type: ignore[attr-defined]
        super().__init__(theta, **{"independent_vars": ["time"], "name": self.law, **options})
        self.set_param_hint("theta0", value=block.theta_cr / 2)
        self.set_param_hint("t0", value=0.0)
        for name in LAWS[self.law].parameters:
            low, high = PARAMETERS[name].bounds
            if PARAMETERS[name].fitted_as == "ratio":
                low, high = low * PARAMETERS["k"].bounds[0], np.inf
            self.set_param_hint(legal(name), min=low, max=high, value=_first_value(name))

    def guess(self, data: Floats, time: Floats, **given: Any) -> lmfit.Parameters:
        """Parameters to start a fit from, as `fit_run` finds its own start.

        Parameters
        ----------
        data, time : ndarray, shape (n_time,)
            θ [rad], and time since the release [s].
        **given
            Values or dicts in lmfit's words, which replace what is guessed.
        """
        theta, time = np.asarray(data, float), np.asarray(time, float)
        # median of |second differences| of white noise of standard deviation 1: 0.6745 √6
        sigma = float(np.nanmedian(np.abs(np.diff(theta, 2)))) / (0.6745 * np.sqrt(6.0))
        motion = Motion(time, theta, sigma, float(theta[0]), sigma, float(time[1] - time[0]))
        kinematics = self.rules.kinematics if LAWS[self.law].is_foundation else LAWS[self.law].kinematics[0]
        candidate = Candidate(self.law, kinematics).name
        settings = FitSettings(debonding=self.rules.debonding)
        model = RunModel(candidate, self.block, motion, settings, moves_inputs=False)
        found = dict(Followed(model, sigma).to_the_end().at.values)
        return self.make_params(**({legal(name): value for name, value in found.items()} | given))

    def derivatives(
        self, params: lmfit.Parameters, data: Floats, weights: Floats | None, **given: Any
    ) -> Floats:
        """Of the weighted residual by the parameters that vary, shape (n_time, n): central differences."""
        columns = []
        for name in [name for name, each in params.items() if each.vary]:
            row, value = PARAMETERS[self.sources[name.removeprefix(self.prefix)]], params[name].value
            step, ends = row.step * (value if row.is_logarithm else 1.0), []
            for there in (value + step, value - step):
                moved = params.copy()
                moved[name].set(value=there, min=-np.inf, max=np.inf)
                ends.append(self.func(**self.make_funcargs(moved, given)))
            columns.append((ends[1] - ends[0]) / (2 * step))  # lmfit subtracts the model
        weight = np.reshape(1.0 if weights is None else weights, (-1, 1))
        return np.asarray(np.array(columns).T * weight, float)

    def fit(
        self,
        data: Floats,
        params: lmfit.Parameters | None = None,
        weights: Floats | None = None,
        method: str = "leastsq",
        fit_kws: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> "lmfit.model.ModelResult":
        """As `lmfit.Model.fit`; least squares take `derivatives`, since the integrator rounds."""
        own: dict[str, dict[str, Any]] = {"leastsq": {}, "least_squares": {"x_scale": "jac"}}
        if method in own:
            fit_kws = {"Dfun": self.derivatives, **own[method], **(fit_kws or {})}
        return super().fit(data, params, weights=weights, method=method, fit_kws=fit_kws, **options)


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


def _first_value(name: str) -> float:
    """The middle of the grid on which a fit seeks its start [SI]."""
    if name == "r":
        return 0.9
    middle = {
        each: float(np.sqrt(PARAMETERS[each].grid[0] * PARAMETERS[each].grid[1])) for each in (name, "k")
    }
    return middle[name] * (middle["k"] if PARAMETERS[name].fitted_as == "ratio" else 1.0)
