"""Which law a run needs: the smallest whose residual is noise, else the best by what it leaves."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from freerock.models.laws import MODELS, law_of

TRACE = 3.0  # standard errors of a damping at which a law is said to lack it
CLOSE = 1.1  # times the lowest held-out ε_θ, up to which the BIC decides


def choose_model(evidence: Mapping[str, Mapping[str, Any]]) -> tuple[str, str]:
    """The smallest law whose residual is noise; where there is none, the best by held-out ε_θ and BIC.

    A residual is noise when it passes for what the sensor does at rest (`noise.against_rest`) and holds no
    trace of a damping that the law lacks.

    Parameters
    ----------
    evidence : mapping of str to mapping
        Per model: success, bic, epsilon_holdout (NaN where there is none), noise, residual_over_sigma and, of
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
            f"as at rest, {usable[model]['residual_over_sigma']:.2f} σ"
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
    return bool(found.get("noise")) and found.get("added_damping", 0.0) < TRACE


def is_wanted(model: str, evidence: Mapping[str, Mapping[str, Any]]) -> bool:
    """Whether a law is to be fitted: always, unless it has cases. Then only where one of these was identified
    and leaves more than noise.

    `evidence` is that of `choose_model`.
    """
    usable = {model: found for model, found in evidence.items() if found["success"]}
    cases = law_of(model).cases
    return not cases or (not usable.keys().isdisjoint(cases) and not any(map(is_noise, usable.values())))
