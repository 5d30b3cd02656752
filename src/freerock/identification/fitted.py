"""A candidate fitted to a run: numbers, uncertainties, curve and evidence, and what a user does with them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import lmfit
import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.posterior import Posterior
from freerock.identification.scatter import Scatter
from freerock.identification.u_total import Uncertainty
from freerock.models.free_parameters import PARAMETERS
from freerock.models.given import legal
from freerock.models.laws import MODEL_LABELS, law_of
from freerock.runs.impacts import Impacts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Curve:
    """Measured and modelled rotation.

    Parameters
    ----------
    time, theta, theta_model : ndarray, shape (n_time,)
        Time since the release [s], measured and modelled rotation [rad].
    """

    time: Floats
    theta: Floats
    theta_model: Floats

    @property
    def residual(self) -> Floats:
        """Model less measurement [rad]."""
        return self.theta_model - self.theta


@dataclass(frozen=True)
class Evidence:
    """How well a fit explains its run.

    Parameters
    ----------
    epsilon_theta : float
        ε_θ as a fraction.
    agrees : bool
        Whether the residual agrees with the noise at rest.
    noise_p, residual_over_noise, noise_low_hz, noise_high_hz : float
        See `freerock.identification.goodness.Goodness`.
    minus_two_log : float
        -2 ln of the evidence under the noise at rest, but for a constant of the run.
    n_parameters : int
        Numbers of the law, and a width that was freed.
    evaluations : int
        Of the residual.
    """

    epsilon_theta: float
    agrees: bool
    noise_p: float
    residual_over_noise: float
    noise_low_hz: float
    noise_high_hz: float
    minus_two_log: float
    n_parameters: int
    evaluations: int


@dataclass(frozen=True)
class ImpactScatter:
    """Scatter of the impacts of a run.

    Parameters
    ----------
    of_record : Scatter
        σ_r of the record that the run belongs to.
    delta, u_delta : ndarray, shape (n_impacts,)
        After impact i the rate is multiplied by 1 + δ_i; standard uncertainty of δ.
    covariance : ndarray, shape (n_impacts, n_impacts)
        Of δ.
    with_parameters : ndarray, shape (n_parameters, n_impacts)
        Covariance of the parameters with δ.
    """

    of_record: Scatter
    delta: Floats
    u_delta: Floats
    covariance: Floats
    with_parameters: Floats


class Minimizer(lmfit.Minimizer):  # type: ignore[misc]
    """lmfit's Minimizer, started from a finished fit.

    Where `lmfit.conf_interval` holds a parameter off its optimum, the others start where the linear model
    puts them. A search that starts with a swing out of phase gets stuck.

    Parameters
    ----------
    ended : lmfit.Minimizer
    end : lmfit.minimizer.MinimizerResult
    """

    def __init__(self, ended: lmfit.Minimizer, end: "lmfit.minimizer.MinimizerResult") -> None:
        super().__init__(ended.userfcn, end.params, scale_covar=False, **ended.kws)
        self.end = end

    def leastsq(
        self, params: lmfit.Parameters | None = None, **options: Any
    ) -> "lmfit.minimizer.MinimizerResult":
        """Least squares as in lmfit, after free parameters are moved by the linear model."""
        params = (params or self.params).copy()
        names, ends = self.end.var_names, self.end.params
        off = np.array([params[name].value - ends[name].value for name in names])
        varied = np.array([params[name].vary for name in names])
        rows = self.kws["Dfun"](ends)  # by what lmfit varies: rates, not δ
        scale = np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
        by = np.linalg.lstsq((rows / scale)[:, varied], -rows @ np.where(varied, 0.0, off), rcond=None)[0]
        for name, each in zip(np.array(names)[varied], by / scale[varied], strict=True):
            params[name].set(value=params[name].value + each)
        return super().leastsq(params, **options)


@dataclass(frozen=True)
class Fit:
    """A candidate fitted to a run.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    values : mapping of str to float
        Numbers of the law, then width, theta0, t0 where they were freed [SI]. theta0 is the angle that the
        sensor shows before the release, read with the stated inputs.
    uncertainty : Uncertainty
        Its `stderr` by noise and impacts, `u_law`, `u_total`, `covariance`, and `contributions` of inputs.
    curve : Curve
        Its `time` [s], and `theta`, `theta_model` and `residual` [rad].
    evidence : Evidence
        Whether the residual `agrees` with the noise at rest, and `residual_over_noise`.
    scatter : ImpactScatter
        σ_r of the record as `of_record.sigma_r`; `delta` of each impact and `u_delta`.
    success : bool
        Whether the least squares converged; `message` says why not.
    message : str
    result : lmfit.minimizer.MinimizerResult
        Of the least squares, with the covariance of `uncertainty`: its standard errors are `u_total`. `ndata`
        counts samples as independent ones: neighbours share slow noise.
    minimizer : Minimizer
        The minimizer that continues from `result`.
    posterior : Posterior or None
        The linear model at the end; None of the paper's fit.
    impacts : Impacts or None
        Impacts of the modelled motion.
    """

    model: str
    values: Mapping[str, float]
    uncertainty: Uncertainty
    curve: Curve
    evidence: Evidence
    scatter: ImpactScatter
    success: bool
    message: str
    result: "lmfit.minimizer.MinimizerResult" = field(compare=False, repr=False)
    minimizer: Minimizer | None = field(default=None, compare=False, repr=False)
    posterior: Posterior | None = field(default=None, compare=False, repr=False)
    impacts: Impacts | None = None

    def __repr__(self) -> str:
        each = zip(self.parameters, self.value, self.u_total, self.units, strict=True)
        numbers = ", ".join(f"{name} = {value:.4g} ± {u:.2g} {unit}" for name, value, u, unit in each)
        agrees = "agrees" if self.evidence.agrees else "does not agree"
        return f"{self.model}: {numbers}; ε_θ = {100 * self.epsilon_theta:.2g} %, {agrees} with the noise"

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the numbers."""
        return tuple(self.values)

    @property
    def value(self) -> Floats:
        """The numbers, shape (n_parameters,) [SI]."""
        return np.array(list(self.values.values()))

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each number."""
        return tuple(PARAMETERS[name].unit for name in self.values)

    @property
    def u_total(self) -> Floats:
        """Standard uncertainty of each number by all that is known [SI]."""
        return self.uncertainty.u_total

    @property
    def epsilon_theta(self) -> float:
        """ε_θ as a fraction."""
        return self.evidence.epsilon_theta

    @property
    def params(self) -> lmfit.Parameters:
        """The numbers as lmfit has them, with `u_total` as standard error; inputs and impacts beside."""
        return self.result.params

    def fit_report(self, **options: Any) -> str:
        """The report of lmfit; options as of `lmfit.fit_report`."""
        return str(lmfit.fit_report(self.result, **options))

    def conf_interval(self, *names: str, sigmas: Sequence[float] = (1, 2)) -> dict[str, list[Any]]:
        """Intervals of numbers, by default the law's, by `lmfit.conf_interval`: it fits all else again.

        The mass, which fits hold, is not in it.

        Raises
        ------
        FreerockError
            The law does not agree with the noise: intervals would leave out its error, which `u_total` holds.
        """
        if not self.evidence.agrees:
            what = f"{self.model} does not agree with the noise: an interval would leave out its error"
            raise FreerockError("conf_interval", what, "use u_total")
        own = [legal(name) for name in names or law_of(self.model).parameters]
        if unknown := {*own} - {*self.result.var_names}:
            what = f"{min(unknown)!r} did not vary"
            raise FreerockError("conf_interval", what, f"use {', '.join(self.parameters)}")
        return dict(lmfit.conf_interval(self.minimizer, self.result, own, sigmas=sigmas))

    def plot(self) -> "Figure":
        """A figure of the measured and the modelled rotation, and of their difference."""
        import matplotlib.pyplot as plt

        figure, (above, below) = plt.subplots(2, 1, sharex=True, height_ratios=(3, 1), layout="constrained")
        label = f"{MODEL_LABELS[self.model]}, $ε_θ$ = {100 * self.epsilon_theta:.2g} %"
        above.plot(self.curve.time, self.curve.theta, ".", markersize=2, label="recorded")
        above.plot(self.curve.time, self.curve.theta_model, linewidth=1, label=label)
        below.plot(self.curve.time, self.curve.residual, linewidth=0.5)
        above.set_ylabel("θ / rad")
        above.legend()
        below.set(xlabel="time since release / s", ylabel="residual / rad")
        return figure
