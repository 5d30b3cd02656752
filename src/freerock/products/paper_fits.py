"""What tables and figures take of a run's fits: those by the paper's own procedure, and the selected one."""

from collections.abc import Iterator

import xarray as xr

from freerock.models.laws import PAPER_MODELS
from freerock.products.choices import named_in
from freerock.products.groups import runs_of


def paper_fits(run: xr.DataTree) -> dict[str, xr.Dataset]:
    """The fits of a run by the paper's own procedure: one motion over the whole run, no input or impact free.

    Parameters
    ----------
    run : xarray.DataTree
        A run's group of a fit dataset.

    Returns
    -------
    dict of str to xarray.Dataset
        By law, of those that the paper fitted.
    """
    known = {law: f"paper_{law}" for law in PAPER_MODELS}
    return {law: run.children[name].dataset for law, name in known.items() if name in run.children}


def paper_fits_of(tree: xr.DataTree) -> Iterator[tuple[int, str, xr.Dataset]]:
    """The fits of all runs of a dataset by the paper's own procedure: run, law and fit."""
    for number, run in runs_of(tree).items():
        for law, fit in paper_fits(run).items():
            yield number, law, fit


def selected_fit(run: xr.DataTree) -> tuple[str, xr.Dataset] | None:
    """The candidate selected for a run, and its fit with inputs and impacts free; None without one."""
    model = named_in(run)
    return (model, run.children[model].dataset) if model in run.children else None
