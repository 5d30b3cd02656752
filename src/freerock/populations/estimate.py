"""What a fit found, in the few plain values that later steps take of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.free_parameters import COMMON_NUISANCES
from freerock.models.laws import MODELS
from freerock.rotation.laboratory import OF_BLOCK
from freerock.rotation.view import View


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
    moved : mapping of str to float
        By name, how far a fit moved the inputs of block and beam [m, kg].
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
    moved: Mapping[str, float] = field(default_factory=dict)
    sigma_r: float = 0.0

    def block_of(self, block: Block) -> Block:
        """The block with the dimensions that belong to these parameters."""
        for name, by in self.moved.items():
            block = block.moved(name, by) if name in OF_BLOCK and by else block
        return block

    def view_of(self, view: View | None, block: Block) -> View | None:
        """The view of a block with the place of the beam that belongs to these parameters."""
        by = self.moved.get("position_m", 0.0)
        if view is None or view.laser.beam is None or not (self.moved.keys() & {*OF_BLOCK, "position_m"}):
            return view
        return View(self.block_of(block), replace(view.laser, position_m=view.laser.position + by))

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
