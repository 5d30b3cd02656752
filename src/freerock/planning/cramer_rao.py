"""Standard errors before any test: how well a run determines the parameters of a model (Cramér-Rao).

No unbiased estimate from samples θ_i with independent normal noise of standard deviation σ has a covariance
below (JᵀJ)⁻¹σ², J = ∂θ_i/∂(parameters), the nuisances θ₀ and t₀ among them as in
`freerock.identification.fit` (Rao 1945, doi:10.1007/978-1-4612-0919-5_16).
The least-squares fits reach it where the model is true and the noise white.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.identification.settings import freed
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS, PER_RUN
from freerock.models.laws import CANDIDATES, MODELS
from freerock.models.simulate import Solver, simulate_theta


def standard_errors(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time_s: Floats,
    theta0: float,
    sigma_theta: float,
    *,
    free: Sequence[str] = PER_RUN,
    debonding: str = "geometric",
) -> dict[str, float]:
    """Smallest standard errors with which a run can determine the parameters of a model.

    Parameters
    ----------
    model : str
        A key of `freerock.models.laws.CANDIDATES`.
    block : Block
    parameters : mapping
        The true parameters [SI].
    time_s : ndarray, shape (n_time,)
        Instants of the samples since the release [s].
    theta0 : float
        Release angle [rad].
    sigma_theta : float
        Standard deviation of the white noise of one sample [rad].
    free : sequence of str
        What is fitted besides the parameters, of "theta0", "t0", "width" (of the corners it rocks about),
        "tilt" (of the base), "edge_radius" (of 0.5 mm where the block's edges are sharp).
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    dict of str to float
        Standard error of each parameter and freed nuisance, in its unit; inf where the samples do not
        determine them.

    Raises
    ------
    FreerockError
        The block overturns, or the motion can't be integrated.
    """
    free = freed(model, free)
    names = (*MODELS[model], *free)
    if len(time_s) <= len(names):
        return dict.fromkeys(names, np.inf)
    width = block.contact_width_m or block.width_m
    base = {"width": width, "tilt": 0.0, "edge_radius": block.edge_radius or PARAMETERS["edge_radius"].trace}
    values = {**parameters, **base, "theta0": theta0, "t0": 0.0}

    def rotation(values: Mapping[str, float]) -> Floats:
        law = {name: values[name] for name in (*MODELS[model], *({"tilt"} & {*free}))}
        turning = block.as_found({name: values[name] for name in free})
        return released_theta(model, turning, law, time_s - values["t0"], values["theta0"], debonding, 1e-10)

    def derivative(name: str) -> Floats:
        row = PARAMETERS[name]
        step = abs(row.step) * (1.0 if row.fitted_as == "value" else values[name])
        above, below = (rotation(values | {name: values[name] + by}) for by in (step, -step))
        return (above - below) / (2 * step)

    deviations = _deviations(np.column_stack([derivative(name) for name in names]), sigma_theta)
    return dict(zip(names, deviations.tolist(), strict=True))


def released_theta(
    model: str,
    block: Block,
    parameters: Mapping[str, float],
    time_s: Floats,
    theta0: float,
    debonding: str,
    rtol: float,
) -> Floats:
    """Rotation of a candidate at some instants [rad], without noise.

    Raises
    ------
    FreerockError
        The block overturns, or the motion can't be integrated.
    """
    theta, outcome = simulate_theta(
        CANDIDATES[model].law,
        block,
        parameters,
        time_s,
        theta0=theta0,
        rules=CANDIDATES[model].rules(debonding),
        solver=Solver(rtol),
    )
    if outcome not in ("completed", "at_rest"):
        what = f"{model} released at {math.degrees(theta0):g}°: {outcome}"
        raise FreerockError("plan", what, "plan for a smaller angle or a stiffer foundation")
    return theta


def _deviations(jacobian: Floats, sigma: float, least: float = 1e-14) -> Floats:
    """Standard deviation of each parameter under white noise; inf where they are not determined.

    `least` is the smallest over the largest eigenvalue of the scaled information.
    """
    undetermined = np.full(jacobian.shape[1], np.inf)
    scale = np.linalg.norm(jacobian, axis=0)
    if not np.all(scale > 0):
        return undetermined
    eigenvalues, vectors = np.linalg.eigh((jacobian / scale).T @ (jacobian / scale))
    if eigenvalues[0] < least * eigenvalues[-1]:
        return undetermined
    variances = (vectors**2 / eigenvalues).sum(axis=1) * (sigma / scale) ** 2
    return np.asarray(np.sqrt(variances))
