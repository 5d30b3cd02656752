"""Misfit maps of a campaign in one dataset: ε_θ around the identified parameters of its scenes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from freerock.populations.estimate import Estimate, MisfitMap
from freerock.products.names import root_attributes
from freerock.products.storage import open_product, write_groups

MODEL = "hunt_crossley"  # the law that is mapped


@dataclass(frozen=True)
class MapCentre:
    """What was identified on a run: k and λ [SI], and their correlation."""

    run: int
    k: float
    damping: float
    correlation: float


@dataclass(frozen=True)
class RecordMap:
    """What was identified on the runs of a record, and the misfit map around the first of these values."""

    test: str
    block: str
    foundation: str
    map: MisfitMap
    identified: Sequence[MapCentre]


def record_map(found: MisfitMap, estimates: Sequence[Estimate]) -> RecordMap:
    """The map of a record around the first of its estimates."""
    first = estimates[0]
    identified = [MapCentre(e.run, e.values["k"], e.values["lambda"], e.correlation) for e in estimates]
    return RecordMap(first.test, first.block, first.foundation, found, identified)


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
    found = each.map
    return xr.Dataset(
        {
            "epsilon_theta": (("lambda", "k"), found.epsilon_theta),
            "epsilon_finer": (("lambda_finer", "k_finer"), found.epsilon_finer),
            "identified_run": ("identified", [one.run for one in each.identified]),
            "identified_k": ("identified", [one.k for one in each.identified]),
            "identified_lambda": ("identified", [one.damping for one in each.identified]),
            "correlation": ("identified", [one.correlation for one in each.identified]),
        },
        {
            "k": found.first,
            "lambda": found.second,
            "k_finer": found.first_finer,
            "lambda_finer": found.second_finer,
        },
        {"test": each.test, "block": each.block, "foundation": each.foundation},
    )


def _record_map(group: xr.Dataset) -> RecordMap:
    arrays = {str(name): np.asarray(variable.values) for name, variable in group.variables.items()}
    columns = (arrays[name].tolist() for name in ("identified_run", "identified_k", "identified_lambda"))
    identified = zip(*columns, arrays["correlation"].tolist(), strict=True)
    return RecordMap(
        **{key: group.attrs[key] for key in ("test", "block", "foundation")},
        map=MisfitMap(
            names=("k", "lambda"),
            first=arrays["k"],
            second=arrays["lambda"],
            epsilon_theta=arrays["epsilon_theta"],
            first_finer=arrays["k_finer"],
            second_finer=arrays["lambda_finer"],
            epsilon_finer=arrays["epsilon_finer"],
        ),
        identified=[MapCentre(*one) for one in identified],
    )
