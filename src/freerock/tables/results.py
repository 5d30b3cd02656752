"""The products of a campaign from a script: tables and datasets by name."""

from collections import UserDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from freerock.errors import FreerockError
from freerock.products.netcdf import open_fits, open_record
from freerock.tables.csvfile import read_csv


class Products(UserDict[str, Any]):
    """Files of one kind by name, as in a dict; each is read when it is asked for."""

    def __init__(self, folder: Path, suffix: str, read: Callable[[Path], Any]) -> None:
        self.data = {path.stem: path for path in sorted(folder.glob(f"*{suffix}"))}
        self._folder, self._read = folder, read

    def __getitem__(self, name: str) -> Any:
        if name not in self.data:
            raise FreerockError(self._folder, f"holds no {name!r}", f"it holds {', '.join(self.data)}")
        return self._read(self.data[name])

    def __repr__(self) -> str:
        return f"<{', '.join(self.data) or 'none'}>"


@dataclass(frozen=True)
class Results:
    """Products of a campaign.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame
        By name, such as "parameters".
    records, fits : mapping of str to xarray.DataTree
        By test, as `freerock.open_record` and `freerock.open_fits` give them.
    """

    tables: Products
    records: Products
    fits: Products


def open_results(folder: str | Path) -> Results:
    """The products in a folder of results; see docs/datasets.md.

    Parameters
    ----------
    folder : path
        Such as results/palermo_virtual.

    Raises
    ------
    FreerockError
        It holds no products.

    Examples
    --------
    >>> results = freerock.open_results("results/palermo_virtual")  # doctest: +SKIP
    >>> results.records  # doctest: +SKIP
    <config1_aerstop, config1_marble, config2_aerstop, config2_marble, config3_aerstop, config3_marble>
    >>> results.tables["parameters"].query("parameter == 'k'").run.nunique()  # doctest: +SKIP
    3
    >>> results.fits["config2_marble"]["run_1/hunt_crossley/theta_model"].plot()  # doctest: +SKIP
    [<matplotlib.lines.Line2D object at ...>]
    """
    base = Path(folder)
    found = Results(
        Products(base / "tables", ".csv", read_csv),
        Products(base / "records", ".nc", open_record),
        Products(base / "fits", ".nc", open_fits),
    )
    if not (found.tables or found.records):
        raise FreerockError(folder, "holds no tables and no records", "run snakemake, or correct the folder")
    return found
