"""u_total: standard uncertainty of a number by noise, law and every input of the laboratory.

A fit has `Fit.u_total` (`identification.fitted`), by `Contributions.total` of this module; r and θ₀ of a run
`runs.measured_total`; r by energy `populations.impact_energy`; means `populations.random_effects`; plans
`planning.bound`.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.special import ndtr

from freerock.arrays import Floats
from freerock.rotation.laboratory import Input

OF_LAW = "law"  # label of the model discrepancy in the budget: all fits of one law share it


@dataclass(frozen=True)
class Contributions:
    """What the inputs of a laboratory contribute to the uncertainty of some numbers.

    Parameters
    ----------
    inputs : tuple of Input
    values : ndarray, shape (n_numbers, n_inputs)
        Shift of each number for one standard uncertainty of the stated value of each input, in the unit of
        the number; NaN where it is not known.
    moved : ndarray, shape (n_inputs,)
        By how many of its standard uncertainties a fit moves each input; 0 of a fit that holds them.
    remaining : ndarray, shape (n_inputs,)
        Standard uncertainty of each input after the fit over that before it; 1 of a fit that holds them.
    pulls : ndarray, shape (n_inputs,)
        (ν̂ - ν⁰) over its standard deviation, √(u² - û²) where the noise is white: standard normal where law
        and uncertainties are right (Demortier and Lyons 2002, CDF note 5776). NaN where the run does not see
        the input.
    impacts : ndarray, shape (n_numbers, n_inputs)
        Shift of each number where an input is held one remaining standard uncertainty above where the fit
        has it, and all else is fitted again (Conway 2011, arXiv:1103.0354), in the unit of the number.
    """

    inputs: tuple[Input, ...]
    values: Floats
    moved: Floats
    remaining: Floats
    pulls: Floats
    impacts: Floats

    @classmethod
    def held(cls, inputs: tuple[Input, ...], values: Floats) -> Self:
        """Of a fit that holds the inputs at their stated values."""
        n = len(inputs)
        return cls(inputs, values, np.zeros(n), np.ones(n), np.full(n, np.nan), np.array(values))

    @property
    def p_of_pulls(self) -> float:
        """Chance of so large a pull of any input, were all uncertainties right (Bonferroni); at most 1."""
        seen = np.abs(self.pulls[~np.isnan(self.pulls)])
        return min(1.0, 2 * len(seen) * float(ndtr(-seen.max(initial=0.0)))) if len(seen) else 1.0

    def total(self, *others: Floats) -> Floats:
        """Combined standard uncertainty with those of noise and law, each of shape (n_numbers,)."""
        squares = [each**2 for each in others]
        return np.asarray(np.sqrt(np.sum(squares, axis=0) + np.sum(self.values**2, axis=1)))
