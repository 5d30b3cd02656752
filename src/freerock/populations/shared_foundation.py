"""What the runs of a campaign have in common: do the blocks on one foundation share its parameters?"""

import math
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import chdtrc

from freerock.arrays import Floats
from freerock.columns import columns_of
from freerock.models.laws import MODELS, law_of
from freerock.populations.between_blocks import TEST, between_blocks, visible_difference
from freerock.populations.estimate import Estimate, transferable

FOUNDATIONS = columns_of("foundations")

Fitted = tuple[str, int | str, str]  # record, run, model


def shared_foundation(
    estimates: Iterable[Estimate], rejected: Collection[Fitted] = frozenset()
) -> pd.DataFrame:
    """Do the blocks on one foundation have the same k and damping?

    The logarithms of all parameters of a law together: the scatter between the blocks' means against that
    between the runs of each block (`between_blocks`). Blocks that differ may do so because their widths and
    heights are not exact: a second test allows for what the laboratory's inputs may shift them.

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
        says how large one may be; NA where it can't be known, as no difference would be seen or a block of a
        single run may differ from the others, and for a law that most of the runs reject (n_runs_rejected),
        as its parameters are no property of the foundation.
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


def _within(blocks: Collection[Floats]) -> Floats:
    """Sums of squares and products of the runs around the means of their blocks."""
    sums: Floats = np.sum([(own - own.mean(axis=0)).T @ (own - own.mean(axis=0)) for own in blocks], axis=0)
    return sums


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
    seen = found.p < TEST.significant
    differ = seen and not inputs_p >= TEST.significant
    doubtful = math.isnan(visible[0]) or min(map(len, logs)) == 1
    unknown = (doubtful and not differ) or n_rejected > n_runs / 2
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
