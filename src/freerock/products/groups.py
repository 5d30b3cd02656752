"""The groups of a dataset: its runs, the fits in it, and which of them may be used."""

import json
import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from freerock.models.laws import MODELS
from freerock.runs.verdict import Reason

Attrs = Mapping[Any, Any]  # names of attributes are texts; xarray says hashable


class NotFitted(NamedTuple):
    """A model that could not be fitted: to a run, or the whole record (None)."""

    run: int | None
    text: str


def reasons_in(attrs: Attrs) -> tuple[Reason, ...]:
    """The reasons of a verdict among the attributes of a record, of its fits or of a run."""
    return tuple(Reason(*each) for each in json.loads(attrs["reasons"]))


def not_fitted_in(attrs: Attrs) -> tuple[NotFitted, ...]:
    """What could not be fitted, among the attributes of a record's fits."""
    return tuple(NotFitted(*each) for each in json.loads(attrs.get("not_fitted", "[]")))


def runs_of(tree: xr.DataTree) -> dict[int, xr.DataTree]:
    """Runs of a record or fit dataset, in order.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `records/<test>.nc` or `fits/<test>.nc`.

    Returns
    -------
    dict of int to xarray.DataTree
        By run number.
    """
    numbered = ((name.removeprefix("run_"), node) for name, node in tree.children.items())
    return dict(sorted((int(number), node) for number, node in numbered if number.isdigit()))


def n_restitutions(run: xr.DataTree) -> int:
    """How many impacts of a run of a record have a restitution."""
    return int(np.isfinite(run.dataset["restitution"].values).sum())


def release_angle_of(run: xr.DataTree) -> tuple[float, float]:
    """Release angle of a run [°] and its total standard uncertainty; that by noise if no input is known."""
    u = "theta0_u" if "theta0_u" in run.dataset else "theta0_stderr"
    return math.degrees(run["theta0"].item()), math.degrees(run[u].item())


def impacts_of(run: xr.DataTree) -> str:
    """How often θ of a run of a record crosses zero, and how many impacts have a restitution, in words."""
    seen, measured = run["n_impacts"].item(), n_restitutions(run)
    return f"{seen} zero crossing{'' if seen == 1 else 's'}, {measured} with r"


def fits_of(tree: xr.DataTree) -> Iterator[tuple[int, str, xr.Dataset]]:
    """Fits of a dataset: those of each run in order.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`.

    Yields
    ------
    run : int
    model : str
    fit : xarray.Dataset
        Its group, with what stands in the groups within it.
    """
    for run, group in runs_of(tree).items():
        for model in MODELS:
            if model in group.children:
                parts = [each.dataset for each in group.children[model].subtree]
                yield run, model, xr.merge(parts, combine_attrs="override")


def usable_runs(tree: xr.DataTree) -> dict[int, xr.DataTree]:
    """Runs of a record that are neither failed nor excluded, by number.

    Parameters
    ----------
    tree : xarray.DataTree
        Record dataset.

    Returns
    -------
    dict of int to xarray.DataTree
    """
    return {
        number: run
        for number, run in runs_of(tree).items()
        if run.attrs["verdict"] != "fail" and not run.attrs["excluded"]
    }


def one_of_each(
    paths: Iterable[str | Path],
    scenes: Iterable[Hashable],
    opened: Callable[[str | Path], xr.DataTree],
    usable: Callable[[xr.DataTree], object],
) -> list[xr.DataTree]:
    """One product of each scene: its first that is usable, or its first where none is.

    Parameters
    ----------
    paths : iterable of path
        Products of one kind.
    scenes : iterable of hashable
        What each shows, such as block and foundation.
    opened : callable
        `open_record` or `open_fits`; called until every scene has been found.
    usable : callable
        Says whether a product has something to show.
    """
    found: dict[Hashable, xr.DataTree] = {}
    good = set()
    for path, scene in zip(paths, scenes, strict=True):
        if scene in good:
            continue
        tree = opened(path)
        if usable(tree):
            good.add(scene)
            found[scene] = tree
        found.setdefault(scene, tree)
    return list(found.values())
