"""Misfit maps of a campaign in one dataset: ε_θ around the identified parameters of its scenes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from freerock.models.laws import MODELS, PAPER_MODELS, law_of
from freerock.populations.estimate import Estimate, MisfitMap
from freerock.products.names import root_attributes
from freerock.products.storage import open_product, write_groups


@dataclass(frozen=True)
class MapCentre:
    """What was identified on a run: the two parameters [SI], and their correlation."""

    run: int
    first: float
    second: float
    correlation: float


@dataclass(frozen=True)
class RecordMap:
    """What was identified on the runs of a record with a law, and the misfit map around the first of them."""

    test: str
    block: str
    foundation: str
    model: str
    map: MisfitMap
    identified: Sequence[MapCentre]


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


def record_map(found: MisfitMap, estimates: Sequence[Estimate]) -> RecordMap:
    """The map of a record around the first of its estimates."""
    first, (x, y) = estimates[0], found.names
    identified = [
        MapCentre(each.run, float(each.values[x]), float(each.values[y]), each.correlation)
        for each in estimates
    ]
    return RecordMap(first.test, first.block, first.foundation, first.model, found, identified)


def write_misfit_maps(path: str | Path, maps: Sequence[RecordMap], campaign: str, origin: str) -> None:
    """Write the misfit maps of a campaign, a group per record.

    Parameters
    ----------
    path : path
        File to write.
    maps : sequence of RecordMap
    campaign, origin : str
        Name of the campaign; "measured" or "simulated".

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    attrs = {"campaign": campaign, "origin": origin}
    groups = {"/": xr.Dataset(attrs=root_attributes("misfit_map", "misfit around the parameters", attrs))}
    groups |= {each.test: _group(each) for each in maps}
    write_groups(path, groups)


def open_misfit_maps(path: str | Path) -> list[RecordMap]:
    """The misfit maps of a campaign.

    Raises
    ------
    FreerockError
        No such file, damaged, or another dataset.
    """
    tree = open_product(path, "misfit_map", of="a campaign")
    return [_record_map(node.to_dataset()) for node in tree.children.values()]


def _group(each: RecordMap) -> xr.Dataset:
    found, (first, second) = each.map, each.map.names
    return xr.Dataset(
        {
            "epsilon_theta": ((second, first), found.epsilon_theta),
            "epsilon_finer": ((f"{second}_finer", f"{first}_finer"), found.epsilon_finer),
            "identified_run": ("identified", [one.run for one in each.identified]),
            f"identified_{first}": ("identified", [one.first for one in each.identified]),
            f"identified_{second}": ("identified", [one.second for one in each.identified]),
            "correlation": ("identified", [one.correlation for one in each.identified]),
        },
        {
            first: found.first,
            second: found.second,
            f"{first}_finer": found.first_finer,
            f"{second}_finer": found.second_finer,
        },
        {"test": each.test, "block": each.block, "foundation": each.foundation, "model": each.model},
    )


def _record_map(group: xr.Dataset) -> RecordMap:
    arrays = {str(name): np.asarray(variable.values) for name, variable in group.variables.items()}
    second, first = map(str, group["epsilon_theta"].dims)
    names = ("identified_run", f"identified_{first}", f"identified_{second}", "correlation")
    identified = zip(*(arrays[name].tolist() for name in names), strict=True)
    return RecordMap(
        **{key: group.attrs[key] for key in ("test", "block", "foundation", "model")},
        map=MisfitMap(
            names=(first, second),
            first=arrays[first],
            second=arrays[second],
            epsilon_theta=arrays["epsilon_theta"],
            first_finer=arrays[f"{first}_finer"],
            second_finer=arrays[f"{second}_finer"],
            epsilon_finer=arrays["epsilon_finer"],
        ),
        identified=[MapCentre(*one) for one in identified],
    )
