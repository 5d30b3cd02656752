"""Restitution against impact speed: a straight line, where the impacts show that it is not a constant."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from freerock.arrays import Floats
from freerock.populations.random_effects import LEVEL, population
from freerock.tables.columns import RESTITUTION_LAW_COLUMNS, SCENE_COLUMNS
from freerock.tables.swings import named_models

LEAST = 4  # impacts of a run through which a line is laid
PEAKS, ENERGY = "peaks", "energy"


class Line(NamedTuple):
    """r = r at a speed + slope (speed - that speed), with standard errors and the slope's 95 % interval."""

    r: float
    r_stderr: float
    slope: float
    slope_stderr: float
    low: float
    high: float


def restitution_law(swings: pd.DataFrame, epsilon: pd.DataFrame) -> pd.DataFrame:
    """How restitution depends on the speed of impact, for each block on each foundation.

    Parameters
    ----------
    swings : pandas.DataFrame
        From `freerock.tables.swings.swings`.
    epsilon : pandas.DataFrame
        Tidy table; it names the law of each run whose energies count.

    Returns
    -------
    pandas.DataFrame
        Columns `RESTITUTION_LAW_COLUMNS`. quantity is "peaks", √(energy ratio) of a rigid block from the
        measured peaks against the speed of a rigid block that falls from them, or "energy", of mechanical
        energies under the law selected for the run, else that of least ε_θ, against its speed of impact.
        speed_m_s is the median speed, r that of the line there; slope_s_m = dr/dv. trend: the interval of the
        slope does not hold zero, so that r is not a constant within speed_low_m_s to speed_high_m_s.

    Notes
    -----
    Impacts at which a Hunt-Crossley contact loses little have r = 1 - α v (doi:10.1115/1.3423596), whose line
    this is; of large losses it is a tangent. Each run has a line of its own; the runs are a sample (random
    effects).
    """
    named = named_models(epsilon)
    own = [named.get((row.test, str(row.run))) == row.source for row in swings.itertuples()]
    seen = swings[swings["source"] == "experiment"]
    kinds = {
        PEAKS: (seen, ["rigid_speed_m_s", "r"]),
        ENERGY: (swings[own], ["impact_speed_m_s", "r_energy"]),
    }
    rows = []
    for scene, _ in seen.groupby(SCENE_COLUMNS, sort=False):
        for quantity, (frame, numbers) in kinds.items():
            known = frame[(frame[SCENE_COLUMNS] == list(scene)).all(axis=1)].dropna(subset=numbers)
            runs = [run[numbers].to_numpy(float).T for _, run in known.groupby(["test", "run"])]
            runs = [run for run in runs if run.shape[1] >= LEAST and np.ptp(run[0]) > 0]
            if not runs:
                continue
            speed = np.concatenate([run[0] for run in runs])
            at = float(np.median(speed))
            line = line_of(runs, at)
            span, trend = (float(speed.min()), float(speed.max())), not line.low <= 0 <= line.high
            rows.append((*scene, quantity, len(runs), len(speed), *span, at, *line, trend))
    return pd.DataFrame(rows, columns=RESTITUTION_LAW_COLUMNS)


def line_of(runs: Sequence[Floats], at: float) -> Line:
    """The mean of the lines of several runs, or the line of one.

    Parameters
    ----------
    runs : sequence of ndarray, shape (2, n_impacts)
        Speeds [m/s] and restitutions of each.
    at : float
        Speed at which r is stated [m/s].
    """
    found = [_least_squares(speed - at, value) for speed, value in runs]
    r, slope = (population([each[i][0] for each in found], [each[i][1] for each in found]) for i in (0, 1))
    if len(runs) > 1:
        return Line(r.mean, r.stderr, slope.mean, slope.stderr, slope.low, slope.high)
    half = float(stdtrit(runs[0].shape[1] - 2, (1 + LEVEL) / 2)) * slope.stderr
    return Line(r.mean, r.stderr, slope.mean, slope.stderr, slope.mean - half, slope.mean + half)


def _least_squares(x: Floats, y: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Intercept and slope, each with its standard error from the scatter about the line."""
    columns = np.column_stack([np.ones_like(x), x])
    inverse = np.linalg.pinv(columns)
    fitted = inverse @ y
    left = y - columns @ fitted
    scatter = max(left @ left / (len(x) - 2), 1e-24)  # rounding, of a law without noise
    errors = np.sqrt(scatter * np.sum(inverse**2, axis=1))
    return (float(fitted[0]), float(errors[0])), (float(fitted[1]), float(errors[1]))
