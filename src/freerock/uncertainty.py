"""How well least-squares parameters are known, where the noise is white and where it is not."""

import numpy as np
from scipy.signal import fftconvolve

NORMAL_95 = 1.959963984540054
SINGULAR = 1e13  # condition of the scaled normal matrix beyond which the data do not tell parameters apart


def covariance(residual, jacobian, lengths) -> tuple:
    """Covariance of the least-squares estimate, and whether the residual is coloured.

    White residual: s²(JᵀJ)⁻¹. Coloured residual (lag-one correlation beyond four standard errors):
    sandwich (JᵀJ)⁻¹ S (JᵀJ)⁻¹ with the Bartlett-weighted long-run covariance S of the scores
    J_i e_i, bandwidth by Andrews (1991), doi:10.2307/2938229; the larger of the two variances counts.
    """
    n, n_parameters = jacobian.shape
    scale = np.sqrt(np.mean(jacobian**2, axis=0))
    if not (n_parameters and np.all(scale > 0)):
        return np.full((n_parameters, n_parameters), np.nan), False
    jacobian = jacobian / scale
    normal = jacobian.T @ jacobian
    if not np.linalg.cond(normal) < SINGULAR:
        return np.full((n_parameters, n_parameters), np.nan), False
    inverse = np.linalg.inv(normal)
    variance = residual @ residual / (n - n_parameters)
    white = variance * inverse
    centred = residual - residual.mean()
    correlation = centred[1:] @ centred[:-1] / (centred @ centred)
    coloured = abs(correlation) > 4 / np.sqrt(n)
    covariance = white
    if coloured:
        inner = _long_run(jacobian * residual[:, None], lengths)
        sandwich = inverse @ inner @ inverse
        widen = np.sqrt(np.maximum(np.diag(white) / np.diag(sandwich), 1.0))
        covariance = sandwich * np.outer(widen, widen)
    return covariance / np.outer(scale, scale), coloured


def _long_run(scores, lengths) -> np.ndarray:
    """Bartlett-weighted long-run covariance of the scores, shape (n_parameters, n_parameters)."""
    bandwidth = _andrews_bandwidth(scores)
    inner = np.zeros((scores.shape[1],) * 2)
    for run in np.split(scores, np.cumsum(lengths)[:-1]):
        lags = np.arange(-min(bandwidth, len(run) // 3), min(bandwidth, len(run) // 3) + 1)
        weights = 1 - np.abs(lags) / (lags[-1] + 1)
        inner += run.T @ fftconvolve(run, weights[:, None], mode="same", axes=0)
    return inner


def _andrews_bandwidth(scores) -> int:
    rho = np.array([s[1:] @ s[:-1] / (s @ s) for s in scores.T]).clip(-0.999, 0.999)
    power = scores.var(axis=0) ** 2
    alpha = np.sum(power * 4 * rho**2 / ((1 - rho) ** 6 * (1 + rho) ** 2)) / np.sum(power / (1 - rho) ** 4)
    return int(np.ceil(1.1447 * (alpha * len(scores)) ** (1 / 3)))
