"""Which differences between blocks on one foundation are seen, and how often there is none that is seen?"""

import numpy as np

from freerock.arrays import Floats
from freerock.populations.between_blocks import TEST, Matched, between_blocks, by_rao
from freerock_bench.harness import Study
from freerock_bench.virtual_run import SEED, Row

DRAWS = {"full": 4000, "small": 20}  # of each case
SIZES = ((3, 3), (5, 5), (3, 10), (3, 3, 3), (5, 5, 5), (10, 10, 10))  # runs of each block
MORE_SIZES = ((2, 3), (4, 4), (4, 10), (10, 10), (2, 2, 2), (3, 4, 10), (3, 3, 3, 3), (2, 3, 4, 10))
DIFFERENCES = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0)  # of ln k and ln λ, in spreads between runs
CORRELATION = 0.8  # of ln k and ln λ from run to run
COLUMNS = ["n_blocks", "runs", "spread_ratio", "unlike", "correlation", "difference", "n_draws"]
COLUMNS += ["seen", "seen_pooled"]


Case = tuple[tuple[int, ...], float, str, float, float, int]


def cases(size: str) -> list[Case]:
    """All differences of blocks alike, then blocks with another spread or correlation: see `rows_of`."""
    n, found = DRAWS[size], list[Case]()
    found += [(sizes, 1.0, "none", CORRELATION, by, n) for sizes in SIZES for by in DIFFERENCES]
    for sizes in (*SIZES, *MORE_SIZES):
        if sizes in MORE_SIZES:
            found.append((sizes, 1.0, "none", CORRELATION, 0.0, n))
        for spread, unlike in ((2.0, "first"), (4.0, "first"), (2.0, "last"), (4.0, "last")):
            found.append((sizes, spread, unlike, CORRELATION, 0.0, n))
        found.append((sizes, 1.0, "none", -CORRELATION, 0.0, n))
    return found


def rows_of(case: Case) -> list[Row]:
    """The row of blocks whose k and λ scatter from run to run, the last of which has another k and λ.

    n_blocks, runs (of each block, joined by "+"), spread_ratio (spread of one block over that of the others),
    unlike (which block that is: "none", "first", which has the fewest runs, or "last"), correlation (of the
    last block; the others' is 0.8), difference (of ln k and ln λ of the last block, in the others' spreads
    between runs), n_draws, seen (share of draws in which p is below 5 %), seen_pooled (the same by Wilks' Λ,
    which takes the spreads of all blocks for one).
    """
    sizes, spread, unlike, correlation, difference, n_draws = case
    key = [SEED, *sizes, int(10 * spread), len(unlike), int(10 * difference), int(10 + 10 * correlation)]
    generator = np.random.default_rng(key)
    correlations = [CORRELATION] * (len(sizes) - 1) + [correlation]
    halves = [np.linalg.cholesky([[1.0, each], [each, 1.0]]).T for each in correlations]
    if unlike != "none":
        halves[0 if unlike == "first" else -1] *= spread
    seen = np.zeros(2)
    for _ in range(n_draws):
        blocks = [generator.standard_normal((n, 2)) @ half for n, half in zip(sizes, halves, strict=True)]
        blocks[-1] = blocks[-1] + difference
        seen += between_blocks(blocks).p < TEST.significant, pooled(blocks) < TEST.significant
    stated = (len(sizes), "+".join(map(str, sizes)), spread, unlike, correlation, difference, n_draws)
    return [dict(zip(COLUMNS, (*stated, *seen / n_draws), strict=True))]


def pooled(blocks: list[Floats]) -> float:
    """Wilks' Λ of the plain analysis of variance: its p-value."""
    n, g = sum(map(len, blocks)), len(blocks)
    every = np.concatenate(blocks)
    around = np.concatenate([own - own.mean(axis=0) for own in blocks])
    moved = every - every.mean(axis=0)
    within, total = around.T @ around, moved.T @ moved
    return by_rao(Matched(within / (n - g), (total - within) / (g - 1), n - g, g - 1)).p


STUDY = Study(cases, rows_of, COLUMNS)
run = STUDY.run
