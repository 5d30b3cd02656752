"""How many digits of the golden solutions somebody's trajectories have.

Rotations are measured in critical angles θ_cr and rates in p θ_cr, as the field draws them.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock_bench.golden.files import LAYOUT, Trajectory
from freerock_bench.golden.scenes import scenes

SAME_INSTANT_S = 1e-6
MOST_DIGITS = 15.0  # of double precision
COLUMNS = ["scene", "digits", "digits_of_rate", "largest_error_rad", "at_s"]
LAWS = {"housner": "Housner", "winkler": "Winkler", "hunt_crossley": "Hunt–Crossley"}
HEADS = ["solution", "scenes", *LAWS.values(), "least digits", "median"]


def score(
    solved: Mapping[str, Trajectory], golden: Mapping[str, Trajectory], where: str | Path
) -> pd.DataFrame:
    """Digits reached of each scene that was solved: -log₁₀ of max |Δθ|/θ_cr, from 0 to 15.

    Parameters
    ----------
    solved, golden : mapping of str to Trajectory
        By scene; all quoted instants of a scene must be there, others are not looked at.
    where : str or path
        The file, for messages.

    Returns
    -------
    pandas.DataFrame
        Rows in the order of the golden solutions: scene, digits (0 where a value is not finite) and
        digits_of_rate (of θ̇ in p θ_cr; NaN without one), largest_error_rad and the instant of it, at_s.

    Raises
    ------
    FreerockError
        A scene that is none, one given twice at an instant, or an instant that is missing.
    """
    if not solved:
        raise FreerockError(where, "holds no scene", LAYOUT)
    if unknown := [name for name in solved if name not in golden]:
        raise FreerockError(where, f"{unknown[0]!r} is no scene", "name the scenes as scenes.csv does")
    rows, blocks = [], scenes()
    for name, right in golden.items():
        if name not in solved:
            continue
        places = _places(solved[name], right, f"{where}, {name}")
        block = blocks[name].block
        error = np.abs(solved[name].theta_rad[places] - right.theta_rad)
        lost = ~np.isfinite(error)
        worst = int(np.argmax(np.where(lost, np.inf, error)))
        rate, true_rate = solved[name].theta_rate_rad_s, right.theta_rate_rad_s
        rows.append(
            {
                "scene": name,
                "digits": _digits(error / block.theta_cr),
                "digits_of_rate": math.nan
                if rate is None or true_rate is None
                else _digits(np.abs(rate[places] - true_rate) / (block.p * block.theta_cr)),
                "largest_error_rad": float(error[worst]),
                "at_s": float(right.time_s[worst]),
            }
        )
    return pd.DataFrame(rows, columns=COLUMNS)


def _places(given: Trajectory, right: Trajectory, where: str) -> NDArray[np.intp]:
    """Where the quoted instants are in a trajectory."""
    order = np.argsort(given.time_s, kind="stable")
    time = given.time_s[order]
    if np.any(np.diff(time) <= SAME_INSTANT_S):
        twice = float(time[1:][np.diff(time) <= SAME_INSTANT_S][0])
        raise FreerockError(where, f"{twice:g} s is there twice", "give every instant once")
    if not time.size or not np.all(np.isfinite(time)):
        raise FreerockError(where, "an instant is no number", "give every row its time_s")
    nearest = np.clip(np.searchsorted(time, right.time_s - SAME_INSTANT_S), 0, time.size - 1)
    missing = np.abs(time[nearest] - right.time_s) > SAME_INSTANT_S
    if missing.any():
        raise FreerockError(
            where,
            f"θ at {right.time_s[missing][0]:g} s is missing",
            f"give θ every 0.01 s from 0 to {right.time_s[-1]:g} s",
        )
    return order[nearest]


def _digits(errors: Floats) -> float:
    if not np.all(np.isfinite(errors)):
        return 0.0
    return min(MOST_DIGITS, max(0.0, -math.log10(max(float(np.max(errors)), 1e-300))))


def line(graded: pd.DataFrame, name: str, n_scenes: int) -> list[str]:
    """Cells of the table of scores, below `HEADS`: scenes solved, and digits.

    The digits of a law are those of its worst scene, — where none was solved; the last two are of all scenes.
    """
    digits = graded["digits"]
    least = []
    for law in LAWS:
        of_law = digits[graded["scene"].str.contains(f"_{law}_")]
        least.append(_shown(of_law.min()) if len(of_law) else "—")
    return [name, f"{len(graded)} of {n_scenes}", *least, _shown(digits.min()), _shown(digits.median())]


def _shown(digits: float) -> str:
    """With one decimal, never more than were reached."""
    return f"{math.floor(10 * digits) / 10:.1f}"


def listing(graded: pd.DataFrame) -> str:
    """A line for each scene, the worst first."""
    width = int(graded["scene"].str.len().max())
    lines = [f"{'scene':<{width}}  digits  of rate  largest error"]
    for row in graded.sort_values("digits", kind="stable").to_dict("records"):
        rate = "" if math.isnan(row["digits_of_rate"]) else _shown(row["digits_of_rate"])
        told = (
            f"{row['largest_error_rad']:.1e} rad at {row['at_s']:g} s"
            if math.isfinite(row["largest_error_rad"])
            else f"not finite at {row['at_s']:g} s"
        )
        lines.append(f"{row['scene']:<{width}}  {_shown(row['digits']):>6}  {rate:>7}  {told}")
    return "\n".join(lines)
