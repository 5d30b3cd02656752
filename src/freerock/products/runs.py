"""Runs, impacts and motions of a record dataset, as the objects the analysis works with."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from freerock.models.block import Block
from freerock.products.groups import reasons_in
from freerock.products.names import IMPACTS, RUN
from freerock.rotation.view import View, view_in
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, motion_of
from freerock.runs.noise import noise_at_rest
from freerock.runs.quiet import converter_step, quiet_stretches, relative_noise
from freerock.runs.segment import Run
from freerock.runs.verdict import Verdict
from freerock.units import BASE


def runs_in(record: xr.DataTree) -> list[Run]:
    """The runs of a record, as they were written."""
    return [
        Run(
            **{field: group.dataset[name].item() for field, name in RUN.items()},
            number=int(group.attrs["run"]),
            verdict=Verdict(reasons_in(group.attrs)),
            excluded=bool(group.attrs["excluded"]),
            overridden=bool(group.attrs["overridden"]),
        )
        for group in record.children.values()
    ]


def motions_in(record: xr.DataTree, with_noise: bool = False) -> dict[int, Motion]:
    """The motion of each run of a record, by run number; none of a record that could not be processed.

    With the noise of the sensor, where asked for, from all rests and holds of the record.
    """
    runs = runs_in(record)
    if not runs:
        return {}
    samples = record.dataset
    time_s, theta, sigma = (samples[name].values for name in ("time", "theta", "sigma_theta"))
    noise = louder = None
    if with_noise:
        step = converter_step(next(samples[name].values for name in BASE if name in samples), theta)
        rate_hz = (len(time_s) - 1) / float(time_s[-1] - time_s[0])
        noise = noise_at_rest(quiet_stretches(time_s, theta, sigma), rate_hz, step)
        louder = relative_noise(sigma)
    view = sensors_view(record.attrs)
    return {run.number: motion_of(run, time_s, theta, noise, louder, view) for run in runs}


def sensors_view(attrs: Mapping[Any, Any]) -> View | None:
    """What the sensor made of the motion in a dataset of a record or of its fits."""
    if not any(str(key).startswith("sensor_") for key in attrs):
        return None
    names = ("height_m", "width_m", "mass_kg", "contact_width_m")
    return view_in(
        attrs, Block(**{name: attrs[f"block_{name}"] for name in names if f"block_{name}" in attrs})
    )


def impacts_in(group: xr.DataTree) -> Impacts:
    """The impacts of a run of a record, or of a model of a run."""
    arrays = {field: group.dataset[name].values for field, name in IMPACTS.items()}
    return Impacts(**arrays | {"theta_uplift": arrays["theta_uplift"].item()})
