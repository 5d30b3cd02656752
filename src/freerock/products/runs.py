"""Runs, impacts and motions of a record dataset, as the objects the analysis works with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import xarray as xr

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.noise.at_rest import Rests, noise_of_rests, quiet_stretches, rests_of, usual_of
from freerock.noise.converter import converter_step
from freerock.noise.spectrum import Noise
from freerock.products.groups import reasons_in
from freerock.products.names import IMPACT_VARIABLES, RUN_VARIABLES
from freerock.rotation.view import View, view_in
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, heard, loud, motion_of
from freerock.runs.segment import Run
from freerock.runs.verdict import Verdict
from freerock.units import BASE


def runs_in(record: xr.DataTree) -> list[Run]:
    """The runs of a record, as they were written."""
    return [
        Run(
            **{field: group.dataset[name].item() for field, name in RUN_VARIABLES.items()},
            number=int(group.attrs["run"]),
            verdict=Verdict(reasons_in(group.attrs)),
            excluded=bool(group.attrs["excluded"]),
            overridden=bool(group.attrs["overridden"]),
        )
        for group in record.children.values()
    ]


OVER_TIME = ("time", "theta", "sigma_theta", *BASE)  # of which fits take something


class Measured(NamedTuple):
    """What fits take of a record, without its samples.

    Parameters
    ----------
    motions : dict of int to Motion
        By run number; without noise.
    loud : dict of int to float
        How many times as loud as usual the noise is during each run.
    rests : Rests
        What the noise is known from.
    step : float
        Of the converter [rad].
    """

    motions: dict[int, Motion]
    loud: dict[int, float]
    rests: Rests
    step: float

    def with_noise(
        self, known_from: Callable[[Rests, float], Noise | None] = noise_of_rests
    ) -> dict[int, Motion]:
        """The motions with the noise of the sensor, from all rests and holds and from the motion.

        `known_from` does what `noise_of_rests` does: one that remembers spares the work.
        """
        noise = known_from(self.rests, self.step)
        if noise is None:
            return self.motions
        levels = {number: noise.scaled(loud) for number, loud in self.loud.items()}
        return {number: heard(motion, levels[number]) for number, motion in self.motions.items()}


def motions_in(record: xr.DataTree, samples: Mapping[str, Floats] | None = None) -> dict[int, Motion]:
    """The motion of each run of a record, by run number; none of a record that could not be processed.

    `samples` are its time [s] and theta [rad], where it was opened without.
    """
    runs = runs_in(record)
    if samples is None:
        samples = {name: record.dataset[name].values for name in ("time", "theta") if runs}
    return _motions(runs, samples, record.attrs)


def measured_in(record: xr.DataTree, samples: Mapping[str, Floats]) -> Measured:
    """What fits take of a record; the noise is computed when its samples may be let go.

    `samples` are those that `OVER_TIME` names.
    """
    runs = runs_in(record)
    if not runs:
        return Measured({}, {}, Rests(0.0, [], 1.0), 0.0)
    time_s, theta, sigma = (samples[name] for name in ("time", "theta", "sigma_theta"))
    rate_hz, usual = (len(time_s) - 1) / float(time_s[-1] - time_s[0]), usual_of(sigma)
    return Measured(
        _motions(runs, samples, record.attrs),
        {run.number: loud(run, time_s, sigma, usual) for run in runs},
        rests_of(quiet_stretches(time_s, theta, sigma), rate_hz),
        converter_step(next(samples[name] for name in BASE if name in samples), theta),
    )


def _motions(
    runs: Sequence[Run], samples: Mapping[str, Floats], attrs: Mapping[Any, Any]
) -> dict[int, Motion]:
    view = sensors_view(attrs) if runs else None
    return {run.number: motion_of(run, samples["time"], samples["theta"], view=view) for run in runs}


def sensors_view(attrs: Mapping[Any, Any]) -> View | None:
    """What the sensor made of the motion in a dataset of a record or of its fits."""
    if not any(str(key).startswith("sensor_") for key in attrs):
        return None
    names = [each.name for each in fields(Block) if f"block_{each.name}" in attrs]
    return view_in(attrs, Block(**{name: attrs[f"block_{name}"] for name in names}))


def impacts_in(group: xr.DataTree) -> Impacts:
    """The impacts of a run of a record, or of a model of a run."""
    arrays = {field: group.dataset[name].values for field, name in IMPACT_VARIABLES.items()}
    return Impacts(**arrays | {"theta_uplift": arrays["theta_uplift"].item()})
