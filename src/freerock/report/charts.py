"""The curves of a run as the report draws them: thinned, in degrees, packed into text."""

import base64
from typing import Any

import numpy as np
import xarray as xr

from freerock.arrays import Floats, extremes
from freerock.models.laws import MODELS
from freerock.runs.angular_rate import angular_rate

BINS = 1500  # of a run, with two samples drawn in each: more than a screen has columns
MISSING = -32768


def run_curves(record: xr.DataTree, number: int, fitted: xr.DataTree | None = None) -> dict[str, Any]:
    """Measured and modelled motion of a run.

    Parameters
    ----------
    record : xarray.DataTree
        Record dataset.
    number : int
        Of the run.
    fitted : xarray.DataTree, optional
        The run's group of the fit dataset; left out, the measured motion stands alone.

    Returns
    -------
    dict
        JSON: time since the release [s] and, by source ("measured" or a model), theta [degree] and rate
        [degree/s], packed by `packed`; impacts, a list of [s, restitution, standard error] by source. The
        samples are the lowest and highest measured θ of each of `BINS` bins, the same ones for the models.
    """
    run, samples = record.children[f"run_{number}"].dataset, record.dataset
    release = run["release"].item()
    impacts = {"measured": _impacts(run, release)}
    if fitted is None:
        clock = samples["time"].values
        during = (clock >= release) & (clock <= run["end"].item())
        time, theta = clock[during] - release, {"measured": samples["theta"].values[during]}
    else:
        time, theta = fitted.dataset["time"].values, {"measured": fitted.dataset["theta"].values}
        models = {model: fitted.children[model].dataset for model in MODELS if model in fitted.children}
        theta |= {model: fit["theta_model"].values for model, fit in models.items()}
        impacts |= {model: _impacts(fit, 0.0) for model, fit in models.items()}
    drawn = extremes(theta["measured"], BINS)
    rate = {source: angular_rate(time, values) for source, values in theta.items()}
    return {
        "time": base64.b64encode(time[drawn].astype("<f4").tobytes()).decode(),
        "theta": {source: packed(np.degrees(values[drawn])) for source, values in theta.items()},
        "rate": {source: packed(np.degrees(values[drawn])) for source, values in rate.items()},
        "impacts": impacts,
    }


def packed(values: Floats) -> dict[str, Any]:
    """Numbers as 16-bit integers of a scale, base64: five digits of the largest, in a third of the room.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Numbers; NaN where there is none.

    Returns
    -------
    dict
        scale, and data: values / scale, `MISSING` for NaN.
    """
    known = np.isfinite(values)
    scale = float(f"{np.abs(values[known]).max(initial=0.0) / 32760:.6g}") or 1.0
    whole = np.full(len(values), MISSING, "<i2")
    whole[known] = np.rint(values[known] / scale)
    return {"scale": scale, "data": base64.b64encode(whole.tobytes()).decode()}


def _impacts(group: xr.Dataset, release: float) -> list[list[float]]:
    if not group.sizes.get("impact", 0):
        return []
    time, r = group["impact_time"].values, group["restitution"].values
    stderr = group["restitution_stderr"].values if "restitution_stderr" in group else np.zeros(len(r))
    known = np.isfinite(time) & np.isfinite(r)
    rounded = zip(time[known] - release, r[known], np.nan_to_num(stderr[known]), strict=True)
    return [[round(float(t), 5), round(float(each), 5), float(f"{s:.2g}")] for t, each, s in rounded]
