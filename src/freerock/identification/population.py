"""What the runs of a campaign have in common: do the blocks on one foundation share its parameters?"""

import math
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import chdtrc, fdtrc

from freerock.arrays import Floats
from freerock.identification.estimate import Estimate, transferable
from freerock.models.laws import MODELS, law_of

FOUNDATIONS = ["campaign", "foundation", "model", "parameter", "n_blocks", "n_runs", "n_runs_rejected"]
FOUNDATIONS += ["between_blocks_percent", "between_runs_percent"]
FOUNDATIONS += ["likelihood_ratio", "likelihood_ratio_p", "f_ratio", "f_p", "shared"]
SIGNIFICANT = 0.01

Fitted = tuple[str, int | str, str]  # record, run, model


def shared_foundation(
    estimates: Iterable[Estimate], rejected: Collection[Fitted] = frozenset()
) -> pd.DataFrame:
    """Do the blocks on one foundation have the same k and damping?

    There are two answers. The likelihood ratio of one set of parameters per block against one for all, in the
    quadratic approximation of the likelihood around each run's estimate, relies on the standard errors. The F
    ratio of the scatter between the blocks' means to that between the runs of a block allows for what differs
    from one release to the next. Parameters are compared as logarithms.

    Parameters
    ----------
    estimates : iterable of Estimate
        Those of a campaign; Housner's are left out, whose r belongs to the block.
    rejected : collection of (str, int, str), optional
        Record, run and model of the fits that the choice of a model rejects.

    Returns
    -------
    pandas.DataFrame
        Columns `FOUNDATIONS`, one row per foundation with two blocks or more, model and parameter; the
        likelihood ratio is that of all parameters of the model together. shared is the answer of the F test
        (p ≥ 0.01), of the likelihood ratio where no block has two runs; NA for a law that most of the runs
        reject (n_runs_rejected), as its parameters are no property of the foundation.
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


def _answers(estimates: list[Estimate], n_rejected: int) -> list[dict[str, Any]]:
    """The answer for each parameter of a law on one foundation; none where there is one block only."""
    blocks: dict[str, list[Estimate]] = {}
    for each in estimates:
        blocks.setdefault(each.block, []).append(each)
    if len(blocks) < 2:
        return []
    ratio, ratio_p = _likelihood_ratio(estimates, blocks.values())
    logs = [_logarithms(own) for own in blocks.values()]
    every = np.concatenate(logs)
    n_runs, n_blocks = len(every), len(blocks)
    within = sum(((own - own.mean(axis=0)) ** 2).sum(axis=0) for own in logs)
    between = sum(len(own) * (own.mean(axis=0) - every.mean(axis=0)) ** 2 for own in logs)
    answers = []
    for i, name in enumerate(MODELS[estimates[0].model]):
        f_ratio = f_p = scatter = math.nan
        if n_runs > n_blocks:
            scatter = math.sqrt(within[i] / (n_runs - n_blocks))
            f_ratio = between[i] / (n_blocks - 1) / scatter**2
            f_p = float(fdtrc(n_blocks - 1, n_runs - n_blocks, f_ratio))
        alike = (f_p if math.isfinite(f_p) else ratio_p) >= SIGNIFICANT
        answers.append(
            {
                "parameter": name,
                "n_blocks": n_blocks,
                "n_runs": n_runs,
                "n_runs_rejected": n_rejected,
                "between_blocks_percent": 100 * np.std([own.mean(axis=0)[i] for own in logs], ddof=1),
                "between_runs_percent": 100 * scatter,
                "likelihood_ratio": ratio,
                "likelihood_ratio_p": ratio_p,
                "f_ratio": f_ratio,
                "f_p": f_p,
                "shared": pd.NA if n_rejected > n_runs / 2 else bool(alike),
            }
        )
    return answers


def _likelihood_ratio(estimates: list[Estimate], blocks: Collection[list[Estimate]]) -> tuple[float, float]:
    """-2 ln of the ratio of one mean for all blocks to one per block, and its p-value."""
    ratio = _misfit(estimates) - sum(_misfit(own) for own in blocks)
    n_parameters = len(estimates[0].parameters)
    return ratio, float(chdtrc(n_parameters * (len(blocks) - 1), ratio))


def _misfit(estimates: list[Estimate]) -> float:
    """Weighted sum of squares of the logarithms around their weighted mean."""
    logs = _logarithms(estimates)
    weights = np.array(
        [
            np.linalg.inv(each.covariance / np.outer(value, value))
            for each, value in zip(estimates, np.exp(logs), strict=True)
        ]
    )
    mean = np.linalg.solve(weights.sum(axis=0), np.einsum("nij,nj->i", weights, logs))
    return float(np.einsum("ni,nij,nj->", logs - mean, weights, logs - mean))


def _logarithms(estimates: list[Estimate]) -> Floats:
    """Logarithms of the parameters, shape (n_estimates, n_parameters)."""
    return np.log([list(each.parameters.values()) for each in estimates])
