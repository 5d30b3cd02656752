"""How far a model's θ(t) is from the measured one, and which model a run needs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from freerock.identification.arrays import Floats
from freerock.models.laws import LAWS, MODELS

TRACE = 3.0  # standard errors of a damping at which a law is said to lack it
LOUDER = 1.1  # times the noise before the release, above which a residual is more than noise
CLOSE = 1.1  # times the lowest held-out ε_θ, up to which the BIC decides


def epsilon_theta(time_s: Floats, theta_model: Floats, theta_measured: Floats) -> float:
    """Relative mean square discrepancy ε_θ = ∫(θ_th - θ_ex)² dt / ∫θ_ex² dt.

    Spanos et al. 2017, section 4.2, doi:10.1016/j.proeng.2017.09.024. Samples that are not
    finite in either series are left out; the integrals are trapezoidal. Where time falls back, a
    further run begins, and the integrals add up.

    Parameters
    ----------
    time_s : array_like, shape (n_time,)
        Time [s]; the last valid instant is the t_f of the measure.
    theta_model, theta_measured : array_like, shape (n_time,)
        Rotation [rad].

    Returns
    -------
    float
        ε_θ as a fraction; NaN when fewer than two samples are valid or the measured motion is zero.
    """
    time_s, theta_model, theta_measured = np.broadcast_arrays(time_s, theta_model, theta_measured)
    valid = np.isfinite(theta_model) & np.isfinite(theta_measured)
    if valid.sum() < 2:
        return float("nan")
    time_s, theta_model, theta_measured = time_s[valid], theta_model[valid], theta_measured[valid]
    step = np.maximum(np.diff(time_s), 0.0)
    difference, energy = (
        step @ (square[1:] + square[:-1])
        for square in ((theta_model - theta_measured) ** 2, theta_measured**2)
    )
    return float(difference / energy) if energy > 0 else float("nan")


def choose_model(evidence: Mapping[str, Mapping[str, Any]]) -> tuple[str, str]:
    """The smallest law whose residual is noise; where there is none, the best by held-out ε_θ and BIC.

    A residual is noise when it passes for white (`is_white`), is no larger than the noise before the release
    and holds no trace of a damping that the law lacks.

    Parameters
    ----------
    evidence : mapping of str to mapping
        Per model: success, bic, epsilon_holdout (NaN where there is none), white, residual_over_sigma and, of
        Winkler and Hunt-Crossley, added_damping, as in `freerock.identification.fit.Fit` and its diagnostics.

    Returns
    -------
    model : str
        Name of the model; "" when every fit failed.
    reason : str
        Why, in words.
    """
    usable = {model: found for model, found in evidence.items() if found["success"]}
    if not usable:
        return "", "every fit failed"
    quiet = [model for model, found in usable.items() if is_noise(found)]
    if quiet:
        model = min(quiet, key=lambda name: (len(MODELS[name]), usable[name]["bic"]))
        size = len(MODELS[model])
        return model, (
            f"the smallest law ({size} parameter{'s' if size > 1 else ''}) whose residual is noise: "
            f"white, and {usable[model]['residual_over_sigma']:.2f} times that before the release"
        )
    held_out = {m: found["epsilon_holdout"] for m, found in usable.items()}
    best = min((value for value in held_out.values() if np.isfinite(value)), default=float("nan"))
    close = [m for m, value in held_out.items() if value <= CLOSE * best] or list(usable)
    model = min(close, key=lambda name: usable[name]["bic"])
    if not np.isfinite(best):
        return model, "no residual is noise; the lowest BIC"
    rivals = (
        f", the lowest BIC of {len(close)} within a tenth of the best" if len(close) > 1 else ", the lowest"
    )
    return model, f"no residual is noise; held-out ε_θ = {100 * held_out[model]:.3g} %{rivals}"


def is_noise(found: Mapping[str, Any]) -> bool:
    """Whether the residual of one model's evidence, as for `choose_model`, is noise."""
    return (
        bool(found.get("white"))
        and found.get("residual_over_sigma", np.inf) < LOUDER
        and found.get("added_damping", 0.0) < TRACE
    )


def is_wanted(model: str, evidence: Mapping[str, Mapping[str, Any]]) -> bool:
    """Whether a law is to be fitted: always, unless it has cases. Then only where one of these was identified
    and leaves more than noise.

    `evidence` is that of `choose_model`.
    """
    usable = {model: found for model, found in evidence.items() if found["success"]}
    cases = LAWS[model].cases
    return not cases or (not usable.keys().isdisjoint(cases) and not any(map(is_noise, usable.values())))


def is_white(residual: Floats, level: float = 1.63) -> bool:
    """Whether a residual passes for white noise: Bartlett's test of the cumulative periodogram.

    The cumulated periodogram of white noise rises along the diagonal; its greatest distance from it
    follows Kolmogorov's law (Durbin 1969, doi:10.1093/biomet/56.1.1).

    Parameters
    ----------
    residual : array_like, shape (n_time,)
        In any unit, equally spaced.
    level : float
        Greatest distance times the root of the number of frequencies: 1.63 is exceeded by chance once in a
        hundred times, 1.36 once in twenty.
    """
    power = np.abs(np.fft.rfft(residual - np.mean(residual))[1:]) ** 2
    share = np.cumsum(power) / np.sum(power)
    n = len(share)
    return bool(np.max(np.abs(share - np.arange(1, n + 1) / n)) * np.sqrt(n) < level)


def information_criteria(residual: Floats, n_parameters: int) -> tuple[float, float]:
    """Akaike's and the Bayesian information criterion of a least-squares fit.

    Parameters
    ----------
    residual : ndarray, shape (n_time,)
        In any unit, alike for all models that are compared.
    n_parameters : int
        Number of freed parameters.
    """
    n = len(residual)
    likelihood = n * np.log(residual @ residual / n)
    return float(likelihood + 2 * n_parameters), float(likelihood + np.log(n) * n_parameters)
