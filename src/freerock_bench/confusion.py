"""The confusion atlas: which candidate is named for which truth, and how wrong its parameters are then."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import CANDIDATES, LAWS, Candidate, law_of
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.hypotheses_tried import Identified, identify_run
from freerock_bench.harness import rows_of_all
from freerock_bench.truths import place, published, record
from freerock_bench.virtual_run import CORRELATED_S, SEED, Row, Truth

WIDTHS = (1.0, 0.95, 0.85)  # contact width over nominal width
NOISES = ("white", *CORRELATED_S, "mains")
SCENES = 3  # of each truth and noise: every block, on either foundation in turn
SMALL = 105  # every so many cells make the small atlas
NAMES = ("r", "k", "c", "lambda", "width")


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
    truths = [(law, kinematics) for law, row in LAWS.items() for kinematics in row.kinematics]
    for i, ((law, kinematics), width, noise) in enumerate(product(truths, WIDTHS, NOISES)):
        for block in range(SCENES):
            yield Cell(law, kinematics, width, noise, block + SCENES * ((i + block) % 2))


def run(size: str = "full") -> pd.DataFrame:
    """Which candidate is named for which truth.

    Returns
    -------
    pandas.DataFrame
        One row per run: law, kinematics, width_fraction, noise, scene, block, foundation, theta0_deg,
        sigma_theta_deg, then the columns of `answer`.
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


def answer(candidate: str, truth: Truth, found: Identified) -> Row:
    """What the choice says of a run.

    Parameters
    ----------
    candidate : str
        The smallest that holds the truth.
    truth : Truth
    found : Identified
        In the run.

    Returns
    -------
    dict
        named ("" where nothing may be), explained (it leaves only noise), also_possible (names joined by
        spaces), right (the truth's own candidate is named), held (it is named or also possible), wrong (in
        which way the name is wrong, see `what_is_wrong`), n_fits, reason; of each parameter and
        the width X_error_percent, X_error_stderrs and X_inside (its 95 % interval) under the named candidate;
        paper_error_percent and paper_error_stderrs of k under the true law as the paper has it.
    """
    choice = found.choice(BY_DEFAULT)
    named = choice.selected
    row: Row = {
        "named": named,
        "explained": choice.explained,
        "also_possible": " ".join(choice.also_possible),
        "right": named == candidate,
        "held": candidate in (named, *choice.also_possible),
        "wrong": what_is_wrong(candidate, named),
        "n_fits": len(found.fits),
        "reason": choice.reason,
    }
    true = {**truth.parameters, "width": 2 * truth.block.b}
    for name in NAMES:
        percent, stderrs = _error(name, true, found.fits.get(named))
        inside = abs(stderrs) < NORMAL_95 if math.isfinite(stderrs) else math.nan
        row |= {f"{name}_error_percent": percent, f"{name}_error_stderrs": stderrs, f"{name}_inside": inside}
    percent, stderrs = _error("k", true, found.fits.get(CANDIDATES[candidate].law))
    return row | {"paper_error_percent": percent, "paper_error_stderrs": stderrs}


def what_is_wrong(candidate: str, named: str) -> str:
    """In which way a named candidate is not that of the truth.

    Returns
    -------
    str
        "" where it is, or where none is named; "rigid" for a compliant foundation and "compliant" for a rigid
        one; "law"; "kinematics"; "width", which is not freed though it is worn; "larger" than needed.
    """
    if named in ("", candidate):
        return ""
    own, other = CANDIDATES[candidate], CANDIDATES[named]
    if law_of(candidate).is_foundation != law_of(named).is_foundation:
        return "rigid" if law_of(candidate).is_foundation else "compliant"
    if own.law not in (other.law, *LAWS[other.law].cases):
        return "law"
    if own.kinematics != other.kinematics:
        return "kinematics"
    return "width" if own.width and not other.width else "larger"


def _error(name: str, true: Mapping[str, float], fit: Fit | None) -> tuple[float, float]:
    """Error of a parameter in per cent of the truth, and in standard errors; NaN without either."""
    if fit is None or name not in true or name not in fit.parameters:
        return math.nan, math.nan
    at = fit.parameters.index(name)
    error, stderr = float(fit.value[at]) - true[name], float(fit.stderr[at])
    return 100 * error / true[name], error / stderr if stderr > 0 else math.nan
