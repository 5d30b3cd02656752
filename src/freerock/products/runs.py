"""Runs, impacts and motions of a record dataset, as the objects the analysis works with."""

import json
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr

from freerock.models.block import Block
from freerock.noise.spectrum import Noise
from freerock.products.netcdf_groups import RUN_VARIABLES, reasons_in
from freerock.rotation.sensor import Laser
from freerock.rotation.view import KEYS, View
from freerock.runs.motion import Motion, motions_of
from freerock.runs.runs import Run
from freerock.runs.verdict import Verdict


def runs_in(record: xr.DataTree) -> list[Run]:
    """The runs of a record, as they were written."""
    return [
        Run(
            **{field: group.dataset[name].item() for field, name in RUN_VARIABLES.items()},
            number=int(group.attrs["run"]),
            verdict=Verdict(reasons_in(group.attrs)),
        )
        for group in record.children.values()
    ]


OVER_TIME = ("time", "theta", "sigma_theta")  # of which fits take something


def motions_in(record: xr.DataTree, samples: xr.Dataset) -> dict[int, Motion]:
    """The motion of each run of a record, by run number; none of a record that could not be processed.

    `samples` are those that `OVER_TIME` names; without sigma_theta the noise is white.
    """
    runs = runs_in(record)
    if not runs:
        return {}
    noise = None
    if "sigma_theta" in samples and "noise" in record.attrs:
        told: dict[str, Any] = json.loads(record.attrs["noise"])
        arrays: dict[str, Any] = {key: np.array(each) for key, each in told.items() if isinstance(each, list)}
        noise = Noise(**told | arrays)
    view, attrs = None, record.attrs
    seen_by = {key: attrs[f"sensor_{key}"] for key in KEYS if f"sensor_{key}" in attrs}
    if seen_by:
        known = (each.name for each in fields(Block) if f"block_{each.name}" in attrs)
        block = Block(**{name: attrs[f"block_{name}"] for name in known})
        view = View(block, Laser(**seen_by, units="" if "beam" in seen_by else "rad"))
    over_time = {name: samples[name].values for name in OVER_TIME if name in samples}
    return motions_of(runs, over_time, view, noise)
