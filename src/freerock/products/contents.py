"""What a dataset holds: its runs, their fits, choice and verdict, and which of them may be used."""

import json
import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from freerock.models.laws import MODELS, PAPER_MODELS
from freerock.products.netcdf_groups import reasons_in
from freerock.runs.verdict import Level, Reason, Verdict

Attrs = Mapping[Any, Any]  # names of attributes are texts; xarray says hashable

# Groups within that of a run, where no candidate has this name, and within that of a fit.
CHOICE_GROUP, INPUTS_GROUP = "choice", "inputs"
NO_INPUTS = xr.DataTree()
EXPLAINED = ("noise", "repeatability")  # levels at which the selected law explains the runs


class NotFitted(NamedTuple):
    """A model that could not be fitted: to a run, or the whole record (None)."""

    run: int | None
    text: str


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
    """Release angle of a run [°] and its total standard uncertainty."""
    return math.degrees(run["theta0"].item()), math.degrees(run["theta0_u"].item())


def impacts_of(run: xr.DataTree) -> str:
    """How often θ of a run of a record crosses zero, and how many impacts have a restitution, in words."""
    seen, measured = run["n_impacts"].item(), n_restitutions(run)
    return f"{seen} zero crossing{'' if seen == 1 else 's'}, {measured} with r"


def fits_of(tree: xr.DataTree) -> Iterator[tuple[int, str, xr.Dataset, xr.Dataset]]:
    """Fits of a dataset: those of each run in order.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`.

    Yields
    ------
    run : int
    model : str
    fit, inputs : xarray.Dataset
        Its group, and that of the laboratory's inputs in it; empty where there is none.
    """
    for run, group in runs_of(tree).items():
        for model in MODELS:
            if (fit := group.children.get(model)) is not None:
                yield run, model, fit.dataset, fit.children.get(INPUTS_GROUP, NO_INPUTS).dataset


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


def choices_of(tree: xr.DataTree) -> Iterator[tuple[int, xr.Dataset]]:
    """The choices of a fit dataset: of each run in order.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`; samples are not needed.

    Yields
    ------
    run : int
    choice : xarray.Dataset
        Along candidate, as `write_fits` writes it.
    """
    for run, group in runs_of(tree).items():
        if CHOICE_GROUP in group.children:
            yield run, group.children[CHOICE_GROUP].dataset


def named_in(run: xr.DataTree) -> str:
    """The candidate that the choice names for a run of a fit dataset; "" where it names none."""
    return str(run.children[CHOICE_GROUP].attrs["selected"]) if CHOICE_GROUP in run.children else ""


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


def verdict_of_run(number: int, run: xr.DataTree, fits: xr.DataTree | None) -> Verdict:
    """Verdict of a run: as measured, then with the reasons of its fits.

    Where a model could not be fitted to a usable run, its reasons say why; where none could, it is failed.
    What fits say against a run is found by `selection.reasons`.

    Parameters
    ----------
    number : int
    run : xarray.DataTree
        Its group in the dataset of the record.
    fits : xarray.DataTree or None
        Dataset of the record's fits.
    """
    verdict = Verdict(reasons_in(run.attrs))
    if fits is None:
        return verdict
    reasons = [*verdict.reasons]
    group = fits.children.get(f"run_{number}")
    missed = [NotFitted(*each) for each in json.loads(fits.attrs.get("not_fitted", "[]"))]
    if missed and verdict.level != "fail" and not run.attrs["excluded"]:
        lost: Level = "warn" if group is not None else "fail"
        of = {number: "", None: "not fitted: "}
        texts = (of[each.run] + each.text for each in missed if each.run in of)
        reasons += [Reason.of("not_fitted", text, lost) for text in texts]
    if group is not None and "reasons" in group.attrs:
        reasons += reasons_in(group.attrs)
    return Verdict(tuple(reasons))
