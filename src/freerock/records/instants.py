"""Time of a record as start and step: stored instants would take as much memory as a channel.

xarray makes the instants where they are looked at. A part of a record stores its own.
"""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.indexes import CoordinateTransform, CoordinateTransformIndex, PandasIndex

from freerock.records.timebase import Grid


def time_of(grid: Grid) -> xr.Coordinates:
    """Coordinate time [s] of a grid."""
    time = xr.Coordinates.from_xindex(EvenTime(Instants(grid)))
    time["time"].attrs["units"] = "s"
    return time


class Instants(CoordinateTransform):
    """The instants of a grid by their numbers."""

    def __init__(self, grid: Grid) -> None:
        super().__init__(["time"], {"time": grid.size})
        self.start_s, self.step_s = grid.start_s, grid.step_s

    def forward(self, dim_positions: dict[str, Any]) -> dict[Hashable, Any]:
        """Instants of some numbers."""
        return {self.coord_names[0]: dim_positions[self.dims[0]] * self.step_s + self.start_s}

    def generate_coords(self, dims: tuple[str, ...] | None = None) -> dict[Hashable, Any]:
        """All instants, without a second array."""
        instants = np.arange(self.dim_size[self.dims[0]], dtype=float)
        instants *= self.step_s
        instants += self.start_s
        return {self.coord_names[0]: instants}

    def equals(self, other: CoordinateTransform, **_: Any) -> bool:
        """Whether another has the same instants."""
        return isinstance(other, Instants) and vars(self) == vars(other)


class EvenTime(CoordinateTransformIndex):
    """Index of these instants: parts are chosen as by stored ones."""

    def to_pandas_index(self) -> pd.Index:
        """The instants, stored."""
        ((name, instants),) = self.transform.generate_coords().items()
        return pd.Index(instants, copy=False, name=name)

    @classmethod
    def concat(cls, indexes: Sequence[xr.Index], dim: Hashable, positions: Any = None) -> PandasIndex:  # type: ignore[override]
        """Several, one after the other."""
        return PandasIndex.concat([_stored(index, dim) for index in indexes], dim, positions)

    def isel(self, indexers: Mapping[Any, Any]) -> PandasIndex | None:
        """The part at some numbers."""
        return _stored(self, self.transform.dims[0]).isel(indexers)

    def sel(self, labels: dict[Any, Any], method: Any = None, tolerance: Any = None) -> xr.IndexSelResult:
        """The numbers of some instants."""
        return _stored(self, self.transform.dims[0]).sel(labels, method, tolerance)


def _stored(index: xr.Index, dim: Hashable) -> PandasIndex:
    return PandasIndex(index.to_pandas_index(), dim)
