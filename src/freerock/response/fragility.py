"""Probability of overturning against an intensity: lognormal by maximum likelihood, and as counted.

Baker 2015 (doi:10.1193/021113EQS025M), equations 1 and 11: P(x) = Φ(ln(x/m)/β), m and β from the likelihood
of the falls. Intervals are of a bootstrap over ground motions, whose draws and scales belong together.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import log_ndtr, ndtr, ndtri

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.populations.random_effects import LEVEL

RESAMPLES = 200
BETA = (0.02, 3.0)  # bounds of β: steeper or flatter is not seen in so few motions
GROUPS = 8  # of equal numbers of responses, in which falls are counted


class Lognormal(NamedTuple):
    """Median m of the intensity that overturns, in its unit, and dispersion β."""

    median: float
    beta: float

    def probability(self, intensity: Floats) -> Floats:
        """Of overturning at intensities above 0."""
        return np.asarray(ndtr(np.log(np.asarray(intensity) / self.median) / self.beta))


class Fragility(NamedTuple):
    """A fragility curve.

    Parameters
    ----------
    fitted : Lognormal
    low, high : Lognormal
        Ends of the 95 % intervals of median and β, each by itself.
    curve : DataFrame
        intensity, probability, low, high.
    counted : DataFrame
        intensity (geometric mean of a group), probability, low, high (Wilson's interval with the number of
        motions, not of responses), n.
    """

    fitted: Lognormal
    low: Lognormal
    high: Lognormal
    curve: pd.DataFrame
    counted: pd.DataFrame


def fragility(responses: pd.DataFrame, measure: str = "pga_g", seed: int = 0) -> Fragility:
    """Fragility of an ensemble, as `ensemble.respond` gives it, against a measure of `motions.INTENSITIES`.

    Raises
    ------
    FreerockError
        The block always or never overturned, so that no curve is determined.
    """
    used = responses[responses["overturned"].notna() & (responses[measure] > 0)]
    x, fell = used[measure].to_numpy(float), used["overturned"].to_numpy(float)
    if not x.size or fell.min() == fell.max():
        share = "never" if not x.size or fell.max() == 0 else "always"
        what = f"the block {share} overturns in {x.size} responses: no curve is determined"
        raise FreerockError("fragility", what, "give motions, or scales, of other intensities")
    fitted = fit_lognormal(x, fell)
    names = used["motion"].to_numpy()
    members = [np.flatnonzero(names == name) for name in pd.unique(names)]
    draw, again = np.random.default_rng(seed), list[Lognormal]()
    for _ in range(RESAMPLES):
        chosen = np.concatenate([members[i] for i in draw.integers(len(members), size=len(members))])
        if 0 < fell[chosen].mean() < 1:
            again.append(fit_lognormal(x[chosen], fell[chosen]))
    grid = np.geomspace(x.min(), x.max(), 60)
    curves = np.array([each.probability(grid) for each in again]) if again else np.full((1, 60), np.nan)
    ends = [50 * (1 - LEVEL), 50 * (1 + LEVEL)]
    low, high = np.percentile(curves, ends, axis=0)
    numbers = np.array(again) if again else np.full((1, 2), np.nan)
    lowest, highest = (Lognormal(*each) for each in np.percentile(numbers, ends, axis=0).tolist())
    curve = {"intensity": grid, "probability": fitted.probability(grid), "low": low, "high": high}
    return Fragility(fitted, lowest, highest, pd.DataFrame(curve), _counted(x, fell, names))


def fit_lognormal(intensity: Floats, fell: Floats) -> Lognormal:
    """Median and dispersion of greatest likelihood, shape (n,): intensities above 0, and 1 where it fell."""
    log_x = np.log(intensity)

    def loss(number: Floats) -> float:
        beta = np.exp(np.clip(number[1], *np.log(BETA)))
        z = (log_x - number[0]) / beta
        return -float(np.sum(fell * log_ndtr(z) + (1 - fell) * log_ndtr(-z)))

    middle = (log_x[fell > 0].mean() + log_x[fell == 0].mean()) / 2
    found = minimize(
        loss, [middle, np.log(0.4)], method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-9}
    )
    return Lognormal(float(np.exp(found.x[0])), float(np.exp(np.clip(found.x[1], *np.log(BETA)))))


def _counted(x: Floats, fell: Floats, names: Floats) -> pd.DataFrame:
    """Share that overturned in groups of equal numbers, with Wilson's interval (1927)."""
    rows, z = [], float(ndtri(0.5 + LEVEL / 2))
    for group in np.array_split(np.argsort(x, kind="stable"), GROUPS):
        if not group.size:
            continue
        p, n = float(fell[group].mean()), len({*names[group]})
        centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * float(np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2)))
        at = float(np.exp(np.log(x[group]).mean()))
        rows.append((at, p, max(centre - half, 0.0), min(centre + half, 1.0), group.size))
    return pd.DataFrame(rows, columns=["intensity", "probability", "low", "high", "n"])
