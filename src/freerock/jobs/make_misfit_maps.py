"""Misfit maps of a campaign: one for each block and foundation."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from freerock.models.block import Block
from freerock.populations.estimate import Estimate
from freerock.populations.misfit import misfit_map
from freerock.products.choices import named_in
from freerock.products.estimates import ESTIMATED, estimates_in
from freerock.products.groups import one_of_each, runs_of
from freerock.products.misfit_maps import mapped, record_map, write_misfit_maps
from freerock.products.netcdf import open_fits
from freerock.products.runs import sensors_view


def make_misfit_maps(
    settings: Mapping[str, Any], fit_files: Sequence[str | Path], scenes: Iterable[str], output: str | Path
) -> None:
    """Write the misfit maps of a campaign.

    Parameters
    ----------
    settings : mapping
        blocks and debonding: sections of the configuration as plain values.
    fit_files : sequence of path
        Datasets of the fits of all records.
    scenes : iterable of str
        What each record shows, such as block and foundation: one record of each is mapped.
    output : path
        netCDF file to write.
    """
    opened = partial(open_fits, only=(*ESTIMATED, "time", "theta"))
    fits = one_of_each(fit_files, scenes, opened, _estimates)
    blocks = {name: Block(**block) for name, block in settings["blocks"].items()}
    known = [(tree, found) for tree in fits if (found := _estimates(tree))]
    maps = [
        record_map(map_of_run(tree, found[0], blocks[found[0].block], settings["debonding"]), found)
        for tree, found in known
    ]
    attrs = fits[0].attrs
    write_misfit_maps(output, maps, attrs["campaign"], attrs["origin"])


def _estimates(tree: xr.DataTree) -> list[Estimate]:
    """The fits of the law that is named for the first run with one that can be mapped."""
    usable = list(estimates_in(tree))
    for number, run in runs_of(tree).items():
        if model := mapped(named_in(run), [each.model for each in usable if each.run == number]):
            return [each for each in usable if each.model == model and each.run >= number]
    return []


def map_of_run(tree: xr.DataTree, estimate: Estimate, block: Block, debonding: str) -> xr.Dataset:
    """The misfit map of a run, around what a law with two parameters found there.

    Parameters
    ----------
    tree : xarray.DataTree
        Fits of the record.
    estimate : Estimate
        Of the run.
    block : Block
    debonding : str
    """
    run = tree.children[f"run_{estimate.run}"].dataset
    time_s, theta = run["time"].values, run["theta"].values
    view = sensors_view(tree.attrs)
    block, view = estimate.block_of(block), estimate.view_of(view, block)
    return misfit_map(estimate.model, block, estimate.values, time_s, theta, debonding, view)
