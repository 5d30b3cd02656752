"""The confusion atlas: which candidate is named for which truth, and how wrong its parameters are then."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from freerock.models.laws import LAWS, Candidate
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import identify_run
from freerock_bench.harness import rows_of_all
from freerock_bench.naming import answer
from freerock_bench.truths import place, published, record
from freerock_bench.virtual_run import CORRELATED_S, SEED, Row, Truth

WIDTHS = (1.0, 0.95, 0.85)  # contact width over nominal width
NOISES = ("white", *CORRELATED_S, "mains")
SCENES = 3  # of each truth and noise: every block, on either foundation in turn
SMALL = 105  # every so many cells make the small atlas


@dataclass(frozen=True)
class Cell:
    """A truth of the atlas, its noise and its scene.

    Parameters
    ----------
    law, kinematics : str
    width_fraction : float
        Contact width over the nominal one.
    noise : str
        As in `freerock_bench.virtual_run.Truth`.
    scene : int
        Number of the scene, which is its block and foundation.
    """

    law: str
    kinematics: str
    width_fraction: float
    noise: str
    scene: int

    @property
    def candidate(self) -> str:
        """The smallest candidate that holds the truth."""
        return Candidate(self.law, self.kinematics, self.width_fraction != 1).name

    def truth(self, generator: np.random.Generator) -> Truth:
        """Drawn anew: release angle and size of the noise."""
        drawn = published(
            self.law, self.kinematics, self.scene, generator, width_fraction=self.width_fraction
        )
        return replace(drawn, noise=self.noise)


def cells() -> Iterator[Cell]:
    """All cells of the atlas."""
    usual = {law: row for law, row in LAWS.items() if row.by_default}
    truths = [(law, kinematics) for law, row in usual.items() for kinematics in row.kinematics]
    for i, ((law, kinematics), width, noise) in enumerate(product(truths, WIDTHS, NOISES)):
        for block in range(SCENES):
            yield Cell(law, kinematics, width, noise, block + SCENES * ((i + block) % 2))


def run(size: str = "full") -> pd.DataFrame:
    """Which candidate is named for which truth.

    Returns
    -------
    pandas.DataFrame
        One row per run: law, kinematics, width_fraction, noise, scene, block, foundation, theta0_deg,
        sigma_theta_deg, then the columns of `freerock_bench.naming.answer`.
    """
    chosen = enumerate(cells())
    return pd.DataFrame(
        rows_of_all(_rows, [(i, cell) for i, cell in chosen if size == "full" or i % SMALL == 0])
    )


def _rows(case: Any) -> list[Row]:
    i, cell = case
    truth, motion = record(cell.truth, np.random.default_rng([SEED, 5, i]))
    block, foundation = place(cell.scene)
    row = asdict(cell) | {"block": block, "foundation": foundation, "theta0_deg": math.degrees(truth.theta0)}
    row["sigma_theta_deg"] = math.degrees(truth.sigma_theta)
    return [row | answer(cell.candidate, truth, identify_run(truth.nominal, motion, BY_DEFAULT))]
