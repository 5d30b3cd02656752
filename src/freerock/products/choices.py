"""The choice of a model in a fit dataset: all candidates in a group of each run, and of all runs jointly."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from freerock.products.groups import runs_of

if TYPE_CHECKING:
    from freerock.selection.choice import Choice

CHOICE_GROUP = "choice"  # in that of a run: no candidate has this name
EXPLAINED = ("noise", "repeatability")  # levels at which the selected law explains the runs
CHOICE_NUMBERS = ("minus_two_log", "n_parameters", "residual_over_noise", "p_prediction")


def choice_dataset(choice: "Choice") -> xr.Dataset:
    """The choice of a record as it is stored with each run.

    Parameters
    ----------
    choice : freerock.selection.choice.Choice

    Returns
    -------
    xarray.Dataset
        Along candidate: status and reason (texts), and `CHOICE_NUMBERS`, NaN where a candidate has no such
        number. Attributes: selected, level, criterion, reason.
    """
    texts = {name: [getattr(each, name) for each in choice.judged] for name in ("status", "reason")}
    arrays: dict[str, Any] = {name: ("candidate", np.array(values, str)) for name, values in texts.items()}
    arrays |= {
        name: ("candidate", np.array([getattr(each, name) for each in choice.judged], float))
        for name in CHOICE_NUMBERS
    }
    told = {name: getattr(choice, name) for name in ("selected", "level", "criterion", "reason")}
    return xr.Dataset(arrays, {"candidate": [each.model for each in choice.judged]}, told)


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
        As from `choice_dataset`.
    """
    for run, group in runs_of(tree).items():
        if CHOICE_GROUP in group.children:
            yield run, group.children[CHOICE_GROUP].dataset


def named_in(run: xr.DataTree) -> str:
    """The candidate that the choice names for a run of a fit dataset; "" where it names none."""
    return str(run.children[CHOICE_GROUP].attrs["selected"]) if CHOICE_GROUP in run.children else ""
