"""Misfit maps of a campaign in one dataset: ε_θ around the identified parameters of its scenes."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import xarray as xr

from freerock.models.laws import MODELS, PAPER_MODELS, law_of
from freerock.populations.estimate import Estimate
from freerock.products.names import root_attributes
from freerock.products.storage import open_product, write_groups


def mapped(named: str, usable: Iterable[str]) -> str:
    """The candidate that a misfit map is of: the one named, or the nearest of the paper's; of a foundation's
    law with two parameters.

    Parameters
    ----------
    named : str
        What the choice names for the run.
    usable : iterable of str
        Candidates with a fit that may be used.

    Returns
    -------
    str
        Empty where there is none.
    """
    known = {model for model in usable if len(MODELS[model]) == 2 and law_of(model).is_foundation}
    return next((model for model in (named, *reversed(PAPER_MODELS)) if model in known), "")


def record_map(found: xr.Dataset, estimates: Sequence[Estimate]) -> xr.Dataset:
    """The map of a record, around the first of its estimates, with what was identified on all of its runs.

    Parameters
    ----------
    found : xarray.Dataset
        As from `populations.misfit.misfit_map`.
    estimates : sequence of Estimate
        Of the runs of the record, by one law.

    Returns
    -------
    xarray.Dataset
        Along identified besides: identified_run, identified_NAME of the two parameters [SI] and their
        correlation. Attributes: test, block, foundation, model.
    """
    first = estimates[0]
    identified = {
        "identified_run": [each.run for each in estimates],
        **{f"identified_{name}": [each.values[name] for each in estimates] for name in MODELS[first.model]},
        "correlation": [each.correlation for each in estimates],
    }
    arrays = {str(name): array.variable for name, array in found.data_vars.items()}
    attrs = {name: getattr(first, name) for name in ("test", "block", "foundation", "model")}
    along = {name: xr.Variable("identified", values) for name, values in identified.items()}
    return xr.Dataset(arrays | along, found.coords, attrs)


def write_misfit_maps(path: str | Path, maps: Sequence[xr.Dataset], campaign: str, origin: str) -> None:
    """Write the misfit maps of a campaign, a group per record.

    Parameters
    ----------
    path : path
        File to write.
    maps : sequence of xarray.Dataset
        As from `record_map`.
    campaign, origin : str
        Name of the campaign; "measured" or "simulated".

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    attrs = {"campaign": campaign, "origin": origin}
    groups = {"/": xr.Dataset(attrs=root_attributes("misfit_map", "misfit around the parameters", attrs))}
    write_groups(path, groups | {each.attrs["test"]: each for each in maps})


def open_misfit_maps(path: str | Path) -> list[xr.Dataset]:
    """The misfit maps of a campaign, each as from `record_map`.

    Raises
    ------
    FreerockError
        No such file, damaged, or another dataset.
    """
    tree = open_product(path, "misfit_map", of="a campaign")
    return [node.to_dataset() for node in tree.children.values()]
