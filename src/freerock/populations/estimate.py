"""What a fit found, in the few plain values that later steps take of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.free_parameters import COMMON_NUISANCES
from freerock.models.laws import MODELS
from freerock.rotation.laboratory import OF_BLOCK, Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.rotation.view import View

OF_ALL = {*OF_BLOCK, "levelled_deg", "sampling_rate_fraction"}  # inputs that no single laser has


@dataclass(frozen=True)
class Estimate:
    """Parameters of one model identified on one run of a record.

    Parameters
    ----------
    campaign, test, block, foundation : str
        Names of what was tested.
    run : int
        Number of the run.
    model : str
        Name of the law.
    values : mapping of str to float
        The model's parameters, then what else was freed (theta0, t0, width), in SI units.
    covariance : ndarray, shape (n, n)
        Of the model's n parameters, in the product of their units.
    shifts : mapping of (str, str) to ndarray, shape (n,)
        By owner and name of an input, the relative shift of each of these parameters for one standard
        uncertainty of that input.
    moved : mapping of Input to float
        By how many of their standard uncertainties a fit moved the inputs of the laboratory.
    sigma_r : float
        Scatter of the rate from impact to impact, as a share.
    """

    campaign: str
    test: str
    run: int
    block: str
    foundation: str
    model: str
    values: Mapping[str, float]
    covariance: Floats
    shifts: Mapping[tuple[str, str], Floats] = field(default_factory=dict)
    moved: Mapping[Input, float] = field(default_factory=dict)
    sigma_r: float = 0.0

    def laboratory(self, block: Block, view: View | None) -> Laboratory:
        """The laboratory as stated, with the inputs that the fit moved; of two lasers without their own."""
        laser = view.laser if view is not None else Laser(units="rad")
        owners = {source.owner for source in self.moved if source.name not in OF_ALL}
        inputs = tuple(source for source in self.moved if source.name in OF_ALL or len(owners) == 1)
        return Laboratory(block, {owners.pop() if len(owners) == 1 else "laser": laser}, inputs)

    @property
    def parameters(self) -> dict[str, float]:
        """The model's parameters alone [SI]."""
        return {name: self.values[name] for name in MODELS[self.model]}

    @property
    def release(self) -> dict[str, float]:
        """What was freed besides, of the release, of the width the block rocks about and of the base [SI]."""
        return {name: self.values[name] for name in COMMON_NUISANCES if name in self.values}

    @property
    def correlation(self) -> float:
        """Correlation of the model's first two parameters."""
        first, both, _, second = self.covariance[:2, :2].ravel()
        return float(both / np.sqrt(first * second))
