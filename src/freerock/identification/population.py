"""What the runs of a campaign have in common: do the blocks on one foundation share its parameters?"""

import math
from collections.abc import Collection, Iterable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.special import chdtrc, fdtrc, fdtri

from freerock.arrays import Floats
from freerock.identification.estimate import Estimate, transferable
from freerock.models.laws import MODELS, law_of

FOUNDATIONS = ["campaign", "foundation", "model", "parameter", "n_blocks", "n_runs", "n_runs_rejected"]
FOUNDATIONS += ["between_blocks_percent", "between_runs_percent", "by_inputs_percent", "visible_percent"]
FOUNDATIONS += ["f_ratio", "f_p", "inputs_p", "shared"]
SIGNIFICANT = 0.05
POWER = 0.8  # of the difference that is called visible

Fitted = tuple[str, int | str, str]  # record, run, model


def shared_foundation(
    estimates: Iterable[Estimate], rejected: Collection[Fitted] = frozenset()
) -> pd.DataFrame:
    """Do the blocks on one foundation have the same k and damping?

    The logarithms of all parameters of a law together: the scatter between the blocks' means against that
    between the runs of a block, by Wilks' Λ (`between_blocks`). Blocks that differ may do so because their
    widths and heights are not exact: a second test allows for what the laboratory's inputs may shift them.

    Parameters
    ----------
    estimates : iterable of Estimate
        Those of a campaign; Housner's are left out, whose r belongs to the block.
    rejected : collection of (str, int, str), optional
        Record, run and model of the fits that the choice of a model rejects.

    Returns
    -------
    pandas.DataFrame
        Columns `FOUNDATIONS`, one row per foundation with two blocks or more, model and parameter: standard
        deviations between the blocks' means, between the runs of a block, and of the means by the inputs
        alone; the smallest difference of this parameter alone, between two blocks, that the test sees with
        80 % probability; F of the joint test, its p-value, and that of the test that allows for the inputs.
        shared is False where both are below 5 %, else True: no difference was seen, of which visible_percent
        says how large one may be; NA where too few blocks have several runs, so that it can't be known, and
        for a law that most of the runs reject (n_runs_rejected), as its parameters are no property of the
        foundation.
    """
    scenes: dict[tuple[str, str, str], list[Estimate]] = {}
    for each in transferable(estimates):
        if law_of(each.model).is_foundation:
            scenes.setdefault((each.campaign, each.foundation, each.model), []).append(each)
    rows = [
        dict(zip(("campaign", "foundation", "model"), scene, strict=True)) | answer
        for scene, found in scenes.items()
        for answer in _answers(found, sum((e.test, e.run, e.model) in rejected for e in found))
    ]
    return pd.DataFrame(rows, columns=FOUNDATIONS).astype({"shared": "boolean"})


class Between(NamedTuple):
    """Blocks against runs: F, its p-value, its degrees of freedom, and the s of Rao's approximation."""

    f_ratio: float
    p: float
    dof: tuple[float, float] = (math.nan, math.nan)
    s: float = math.nan


def between_blocks(blocks: Collection[Floats]) -> Between:
    """Whether blocks differ by more than their runs do, all parameters together.

    Wilks' Λ = |E|/|E + H| of the sums of squares within and between blocks, as F by Rao (1951); exact for
    one or two parameters, and for two blocks (Hotelling's T²).

    Parameters
    ----------
    blocks : collection of ndarray, shapes (n_runs, n_parameters)
        Logarithms of the parameters of each block.

    Returns
    -------
    Between
        NaN where there are not enough runs beside the blocks.
    """
    every, g = np.concatenate(list(blocks)), len(blocks)
    n, p = every.shape
    if n - g < p:
        return Between(math.nan, math.nan)
    moved = every - every.mean(axis=0)
    logarithms = np.linalg.slogdet([_within(blocks), moved.T @ moved])[1]
    if not np.isfinite(logarithms).all():  # runs that are alike to the last digit
        return Between(math.nan, math.nan)
    s = math.sqrt((p**2 * (g - 1) ** 2 - 4) / (p**2 + (g - 1) ** 2 - 5)) if p**2 + (g - 1) ** 2 > 5 else 1.0
    dof = p * (g - 1), s * (n - 1 - (p + g) / 2) - (p * (g - 1) - 2) / 2
    f_ratio = math.expm1(max(logarithms[1] - logarithms[0], 0.0) / s) * dof[1] / dof[0]
    return Between(f_ratio, float(fdtrc(*dof, f_ratio)), dof, s)


def visible_difference(blocks: Collection[Floats]) -> Floats:
    """Difference of each parameter alone between two blocks that `between_blocks` sees in 80 %, at 5 %.

    Any other blocks are half way. Its noncentrality is ω = m δ² (Σ⁻¹)_ii/2, with m the harmonic mean of the
    runs of a block, and that of F as by O'Brien and Shieh N s ((1 + ω/N)^(1/s) - 1), exact for two blocks.
    Arguments as for `between_blocks`; NaN where that is.
    """
    n, g, p = sum(map(len, blocks)), len(blocks), next(iter(blocks)).shape[1]
    test = between_blocks(blocks)
    if math.isnan(test.p):
        return np.full(p, math.nan)
    precision = np.diag(np.linalg.inv(_within(blocks) / (n - g)))
    runs = g / sum(1 / len(own) for own in blocks)
    omega = n * ((1 + _noncentrality(*test.dof) / (n * test.s)) ** test.s - 1)
    return np.asarray(np.sqrt(2 * omega / (runs * precision)))


def _within(blocks: Collection[Floats]) -> Floats:
    """Sums of squares and products of the runs around the means of their blocks."""
    sums: Floats = np.sum([(own - own.mean(axis=0)).T @ (own - own.mean(axis=0)) for own in blocks], axis=0)
    return sums


def _noncentrality(first: float, second: float) -> float:
    """That of an F test which sees it with the probability `POWER`."""
    from scipy.stats import ncf  # half a second; its namesake in scipy.special fails from λ = 3000 on

    critical = fdtri(first, second, 1 - SIGNIFICANT)
    return float(brentq(lambda lam: ncf.sf(critical, first, second, lam) - POWER, 1e-6, 1e6))


def _answers(estimates: list[Estimate], n_rejected: int) -> list[dict[str, Any]]:
    """The answer for each parameter of a law on one foundation; none where there is one block only."""
    blocks: dict[str, list[Estimate]] = {}
    for each in estimates:
        blocks.setdefault(each.block, []).append(each)
    if len(blocks) < 2:
        return []
    logs = [_logarithms(own) for own in blocks.values()]
    n_runs, n_blocks = sum(map(len, logs)), len(logs)
    found, visible = between_blocks(logs), visible_difference(logs)
    inputs_p, by_inputs = _with_inputs(list(blocks.values()))
    within = np.diag(_within(logs))
    unknown = math.isnan(found.p) or n_rejected > n_runs / 2
    differ = found.p < SIGNIFICANT and not inputs_p >= SIGNIFICANT
    return [
        {
            "parameter": name,
            "n_blocks": n_blocks,
            "n_runs": n_runs,
            "n_runs_rejected": n_rejected,
            "between_blocks_percent": 100 * np.std([own.mean(axis=0)[i] for own in logs], ddof=1),
            "between_runs_percent": 100 * math.sqrt(within[i] / (n_runs - n_blocks))
            if n_runs > n_blocks
            else math.nan,
            "by_inputs_percent": 100 * by_inputs[i],
            "visible_percent": 100 * visible[i],
            "f_ratio": found.f_ratio,
            "f_p": found.p,
            "inputs_p": inputs_p,
            "shared": pd.NA if unknown else not differ,
        }
        for i, name in enumerate(MODELS[estimates[0].model])
    ]


def _with_inputs(blocks: list[list[Estimate]]) -> tuple[float, Floats]:
    """Chance of such differences by the inputs and the scatter of the runs together; what the inputs alone
    shift the means of the blocks against each other.

    χ² of the blocks' means around their common mean by generalised least squares, with the covariance of
    the means: that of the runs, common to all blocks, over their number, and that of the inputs.
    """
    logs = [_logarithms(own) for own in blocks]
    n, g, p = sum(map(len, logs)), len(logs), logs[0].shape[1]
    keys = dict.fromkeys(key for own in blocks for each in own for key in each.shifts)
    zero = np.zeros(p)
    stacked = np.array(
        [[np.mean([e.shifts.get(key, zero) for e in own], axis=0) for own in blocks] for key in keys]
    ).reshape(-1, g, p)
    by_inputs = np.sqrt(np.sum(np.var(stacked, axis=1, ddof=1), axis=0))
    if n - g < p or not keys or not np.isfinite(stacked).all():
        return math.nan, by_inputs
    within = _within(logs) / (n - g)
    flat = stacked.reshape(len(keys), -1)
    weight = np.linalg.pinv(np.kron(np.diag([1 / len(own) for own in logs]), within) + flat.T @ flat)
    means, common = np.concatenate([own.mean(axis=0) for own in logs]), np.tile(np.eye(p), (g, 1))
    apart = means - common @ np.linalg.solve(common.T @ weight @ common, common.T @ weight @ means)
    return float(chdtrc(p * (g - 1), apart @ weight @ apart)), by_inputs


def _logarithms(estimates: list[Estimate]) -> Floats:
    """Logarithms of the parameters, shape (n_estimates, n_parameters)."""
    return np.log([list(each.parameters.values()) for each in estimates])
