"""Runs, impacts and motions of a record dataset, as the objects the analysis works with."""

import xarray as xr

from freerock.products.groups import reasons_in
from freerock.products.names import IMPACTS, RUN
from freerock.runs.impacts import Impacts
from freerock.runs.motion import Motion, motion_of
from freerock.runs.segment import Run
from freerock.runs.verdict import Verdict


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


def motions_in(record: xr.DataTree) -> dict[int, Motion]:
    """The motion of each run of a record, by run number; none of a record that could not be processed."""
    samples = record.dataset
    return {
        run.number: motion_of(run, samples["time"].values, samples["theta"].values) for run in runs_in(record)
    }


def impacts_in(group: xr.DataTree) -> Impacts:
    """The impacts of a run of a record, or of a model of a run."""
    arrays = {field: group.dataset[name].values for field, name in IMPACTS.items()}
    return Impacts(**arrays | {"theta_uplift": arrays["theta_uplift"].item()})
