"""Do the parameters of other runs predict a run?"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import groupby
from operator import attrgetter

import numpy as np
import pandas as pd

from freerock.columns import columns_of
from freerock.identification.epsilon_theta import epsilon_theta
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, law_of
from freerock.populations.estimate import Estimate, transferable
from freerock.rotation.as_measured import as_measured
from freerock.runs.motion import Motion

PREDICTIONS = columns_of("predictions")

Basis = tuple[dict[str, float], int]  # parameters, and the number of runs they come from


def predictions(
    estimates: Iterable[Estimate],
    motions: Callable[[str], Mapping[int, Motion]],
    blocks: Mapping[str, Block],
    debonding: str = "geometric",
) -> pd.DataFrame:
    """How well the parameters of other runs predict a run.

    The prediction takes the run's own angle and instant of release, and width where it was freed, and the
    geometric means of the others' parameters.

    Parameters
    ----------
    estimates : iterable of Estimate
        Those of a campaign, the runs of a test one after the other.
    motions : callable
        Takes a test and returns its runs' motions by run number; called once per test.
    blocks : mapping of str to Block
        The campaign's blocks by name.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    pandas.DataFrame
        Columns `PREDICTIONS`: basis is "other runs" (of the same record) or, of a law of the foundation, the
        name of another block on it, n_runs their number, epsilon_theta a fraction.
    """
    single, rows = transferable(estimates), []
    by_block = _means_by_block(single)
    for test, every in groupby(single, attrgetter("test")):
        measured, alike = motions(test), list(every)
        for own in alike:
            motion = measured[own.run]
            for basis, (parameters, n_runs) in _bases(own, alike, by_block):
                theta = as_measured(
                    CANDIDATES[own.model].law,
                    own.block_of(blocks[own.block]),
                    {"theta0": motion.theta0, **own.release, **parameters},
                    motion.time_s,
                    own.view_of(motion.view, blocks[own.block]),
                    rules=CANDIDATES[own.model].rules(debonding),
                )
                epsilon = epsilon_theta(motion.time_s, theta, motion.theta)
                rows.append([*(getattr(own, name) for name in PREDICTIONS[:6]), basis, n_runs, epsilon])
    return pd.DataFrame(rows, columns=PREDICTIONS)


def _means_by_block(estimates: Iterable[Estimate]) -> dict[tuple[str, str], dict[str, Basis]]:
    """Mean parameters of each block, by model and foundation."""
    groups: dict[tuple[str, str], dict[str, list[Estimate]]] = {}
    for each in estimates:
        groups.setdefault((each.model, each.foundation), {}).setdefault(each.block, []).append(each)
    return {
        scene: {block: (_geometric_means(own), len(own)) for block, own in blocks.items()}
        for scene, blocks in groups.items()
    }


def _bases(
    own: Estimate, of_test: Iterable[Estimate], by_block: Mapping[tuple[str, str], Mapping[str, Basis]]
) -> Iterator[tuple[str, Basis]]:
    """What may predict a run: the other runs of its record, and each other block on its foundation, whose
    law they share; r of a rigid block is its own."""
    others = [
        each
        for each in of_test
        if each.run != own.run and (each.model, each.foundation) == (own.model, own.foundation)
    ]
    if others:
        yield "other runs", (_geometric_means(others), len(others))
    if law_of(own.model).is_foundation:
        for block, mean in by_block[own.model, own.foundation].items():
            if block != own.block:
                yield block, mean


def _geometric_means(estimates: list[Estimate]) -> dict[str, float]:
    logs = [[math.log(value) for value in each.parameters.values()] for each in estimates]
    return dict(zip(estimates[0].parameters, np.exp(np.mean(logs, axis=0)).tolist(), strict=True))
