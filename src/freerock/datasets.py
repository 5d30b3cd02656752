"""Datasets: netCDF in and out, with CF-1.11 and ACDD-1.3 attributes, and the provenance of products.

Same inputs, same bytes: no time stamp is written.
"""

import json
import os
import platform
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from freerock.errors import FreerockError
from freerock.laser import FLAGS
from freerock.manifest import sha256

if TYPE_CHECKING:
    from freerock.identify import Fit
    from freerock.impacts import Impacts
    from freerock.runs import Run

SOFTWARE = ["freerock", "numpy", "scipy", "numba", "lmfit", "xarray", "netCDF4", "snakemake"]

ORIGINS = {
    "simulated": "simulated laser record of a free-rocking test",
    "measured": "laser record of a free-rocking test",
}

# Field of Run and of Impacts -> variable of the dataset.
RUN = {
    "hold_start_s": "hold_start",
    "release_s": "release",
    "release_stderr_s": "release_stderr",
    "start_s": "start",
    "end_s": "end",
    "theta0": "theta0",
    "theta0_stderr": "theta0_stderr",
    "sigma_theta": "sigma_theta",
}
IMPACTS = {
    "time_s": "impact_time",
    "time_stderr_s": "impact_time_stderr",
    "peak_before_rad": "peak_before",
    "peak_before_stderr_rad": "peak_before_stderr",
    "peak_after_rad": "peak_after",
    "peak_after_stderr_rad": "peak_after_stderr",
    "restitution": "restitution",
    "restitution_stderr": "restitution_stderr",
    "restitution_rate": "restitution_rate",
    "restitution_rate_stderr": "restitution_rate_stderr",
    "theta_uplift": "theta_uplift",
}

# Variable -> unit ("" for texts and for quantities whose unit is that of a parameter), long name.
VARIABLES = {
    "time": ("s", "time"),
    "theta": ("rad", "rotation of the block, positive clockwise"),
    "sigma_theta": ("rad", "standard deviation of the noise of theta"),
    "flags": ("", "validity of the laser sample"),
    "voltage": ("V", "output voltage of the laser"),
    "hold_start": ("s", "start of the held phase before the release"),
    "release": ("s", "instant of release"),
    "start": ("s", "first instant used in a fit, after the support has left the block"),
    "end": ("s", "instant of rest"),
    "theta0": ("rad", "held rotation before the release"),
    "impact_time": ("s", "instant of impact"),
    "peak_before": ("rad", "signed peak rotation before the impact"),
    "peak_after": ("rad", "signed peak rotation after the impact"),
    "restitution": ("1", "coefficient of restitution from the peaks before and after the impact"),
    "restitution_rate": ("1", "coefficient of restitution from the angular rates at the impact"),
    "theta_uplift": ("rad", "amplitude below which the base stays in full contact"),
    "parameter": ("", "name of the parameter"),
    "parameter_b": ("", "name of the parameter"),
    "unit": ("", "unit of the parameter"),
    "value": ("", "identified value of the parameter"),
    "stderr": ("", "standard error of the parameter"),
    "ci95_low": ("", "lower end of the 95 % confidence interval of the parameter"),
    "ci95_high": ("", "upper end of the 95 % confidence interval of the parameter"),
    "covariance": ("", "covariance of the parameters"),
    "theta_model": ("rad", "rotation of the model with the identified parameters"),
    "residual": ("rad", "theta_model minus theta"),
    "epsilon_theta": ("1", "relative mean square discrepancy of theta_model"),
    "epsilon_holdout": ("1", "the same on the second half of the run, fitted on the first half"),
    "final_time": ("s", "end of the fitted interval, since release"),
    "aic": ("1", "Akaike information criterion"),
    "bic": ("1", "Bayesian information criterion"),
    "n_parameters": ("1", "number of fitted parameters"),
    "success": ("", "whether the fit may be used"),
}
IN_UNIT = {"comment": "in the unit that the variable unit gives for the parameter"}
EXTRA = {
    "flags": {
        "standard_name": "quality_flag",
        "flag_masks": np.array(list(FLAGS.values()), np.uint8),
        "flag_meanings": " ".join(FLAGS),
    },
    "success": {"flag_values": np.array([0, 1], np.int8), "flag_meanings": "not_usable usable"},
    "covariance": {
        "comment": "in the product of the units that the variable unit gives for the two parameters"
    },
    **dict.fromkeys(["value", "stderr", "ci95_low", "ci95_high"], IN_UNIT),
}
BESIDE = {"theta": ("sigma_theta", "flags"), "value": ("stderr", "ci95_low", "ci95_high", "unit")}
SINGLE_PRECISION = {"sigma_theta", "voltage"}


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` and rename it to `path` at the end; on an error leave nothing.

    Raises
    ------
    FreerockError
        The file or its folder can't be written.
    """
    path = Path(path)
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        os.replace(partial, path)
    except OSError as error:
        remedy = "free some space or allow writing to the folder"
        raise FreerockError(path, f"cannot be written ({error.strerror or error})", remedy) from error
    finally:
        partial.unlink(missing_ok=True)


def write_record(
    path: str | Path, record: xr.Dataset, runs: Sequence["Run"], impacts: Sequence["Impacts"], attrs: Mapping
) -> None:
    """Write what was measured: θ(t) of the whole record and a group per run with its impacts.

    Parameters
    ----------
    path : path
        File to write.
    record : Dataset
        theta [rad], sigma_theta [rad], flags and voltage [V] over time [s], as `laser.rotation` gives them.
    runs : sequence of Run
    impacts : sequence of Impacts
        One per run.
    attrs : mapping
        Root attributes: campaign, test, block, foundation, origin, title, ... and `provenance`.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    verdict, reasons = _record_verdict(runs)
    root = _dataset(
        {"time": ("time", record["time"].values)}
        | {str(name): ("time", variable.values) for name, variable in record.data_vars.items()},
        _root("record", "volts to rotation, runs and impacts", {**record.attrs, **attrs})
        | {"verdict": verdict, "reasons": reasons},
    )
    groups = {"/": root}
    for run, found in zip(runs, impacts, strict=True):
        groups[f"run_{run.number}"] = _dataset(
            {name: ((), getattr(run, field)) for field, name in RUN.items()} | _impacts(found),
            {
                "run": run.number,
                "verdict": run.verdict,
                "reasons": _joined(run.reasons),
                "excluded": run.excluded,
                "overridden": run.overridden,
            },
        )
    _write(path, groups)


def write_failure(path: str | Path, error: Exception, attrs: Mapping) -> None:
    """Write the dataset of a record that could not be processed: verdict "fail" and the error."""
    outcome = {"verdict": "fail", "reasons": str(error)}
    _write(path, {"/": xr.Dataset(attrs=_root("record", "not processed", attrs) | outcome)})


def write_fits(
    path: str | Path, fits: Mapping[int, Mapping[str, "Fit"]], pooled: Mapping[str, "Fit"], attrs: Mapping
) -> None:
    """Write identified models: a group per run and for all runs jointly, with a group per model in each.

    Parameters
    ----------
    path : path
        File to write.
    fits : mapping of int to mapping of str to Fit
        Fits of each run by run number and model; the fits of a run share their time axis.
    pooled : mapping of str to Fit
        Joint fits of all runs by model; empty when there is none.
    attrs : mapping
        Root attributes, as for `write_record`; verdict and reasons are those of the record.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    groups = {"/": xr.Dataset(attrs=_root("fits", "models identified", attrs))}
    for number, models in fits.items():
        groups |= _fits(f"run_{number}", "time", models, {"run": number})
    if pooled:
        groups |= _fits("pooled", "sample", pooled, {"comment": "all runs jointly, one after the other"})
    _write(path, groups)


def open_record(path: str | Path) -> xr.DataTree:
    """Read the dataset of a record into memory.

    Raises
    ------
    FreerockError
        No such file, damaged, or not the dataset of a record.
    """
    return _open(path, "record")


def open_fits(path: str | Path) -> xr.DataTree:
    """Read the dataset of a record's fits into memory; raises as `open_record`."""
    return _open(path, "fits")


def runs_in(record: xr.DataTree) -> list["Run"]:
    """The runs of a record, as they were written."""
    from freerock.runs import Run

    return [
        Run(
            **{field: group[name].item() for field, name in RUN.items()},
            number=int(group.attrs["run"]),
            verdict=group.attrs["verdict"],
            reasons=tuple(filter(None, group.attrs["reasons"].split("; "))),
            excluded=bool(group.attrs["excluded"]),
            overridden=bool(group.attrs["overridden"]),
        )
        for group in record.children.values()
    ]


def impacts_in(group: xr.DataTree) -> "Impacts":
    """The impacts of a run of a record, or of a model of a run."""
    from freerock.impacts import Impacts

    arrays = {field: group[name].values for field, name in IMPACTS.items()}
    return Impacts(**arrays | {"theta_uplift": arrays["theta_uplift"].item()})


def provenance(inputs: Iterable[str | Path], config: Mapping) -> dict:
    """What made a product.

    Parameters
    ----------
    inputs : iterable of path
        Files that were read.
    config : mapping
        The part of the configuration that was used.

    Returns
    -------
    dict
        inputs (path -> sha256), config, software (name -> version), git (state of the code's checkout,
        "unknown" outside of one).
    """
    return {
        "inputs": {Path(path).as_posix(): sha256(path) for path in inputs},
        "config": dict(config),
        "software": {"python": platform.python_version()} | {name: version(name) for name in SOFTWARE},
        "git": _git_state(),
    }


def write_json(path: str | Path, data: Mapping) -> None:
    """Write sorted, indented JSON."""
    with atomic(path) as partial:
        text = json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False)
        partial.write_text(text + "\n", encoding="utf-8")


def _git_state() -> str:
    here = Path(__file__).resolve()
    try:
        for command in (
            ["ls-files", "--error-unmatch", here.name],
            ["describe", "--always", "--dirty", "--tags"],
        ):
            done = subprocess.run(
                ["git", *command], cwd=here.parent, capture_output=True, text=True, check=True, timeout=30
            )
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip()


def _root(product: str, done: str, attrs: Mapping) -> dict:
    """Root attributes of a product; git is left to provenance.json: equal results are equal files."""
    made_by = attrs.get("provenance")
    if isinstance(made_by, Mapping):
        attrs = {**attrs, "provenance": {key: made_by[key] for key in made_by if key != "git"}}
    return attrs | {
        "Conventions": "CF-1.11, ACDD-1.3",
        "freerock_product": product,
        "keywords": "rocking, rigid block, free rocking test, restitution, Housner, Winkler, Hunt-Crossley",
        "source": ORIGINS[attrs["origin"]],
        "history": f"freerock {version('freerock')}: {done}",
    }


def _record_verdict(runs: Sequence["Run"]) -> tuple[str, str]:
    """ok when every run is, fail when none can be used, else warn; with the reasons of all runs."""
    kept = [run for run in runs if not run.excluded]
    usable = [run for run in kept if run.verdict != "fail"]
    reasons = _joined(f"run {run.number}: {reason}" for run in runs for reason in run.reasons)
    if kept and not usable:
        return "fail", reasons
    return ("ok" if all(run.verdict == "ok" for run in runs) else "warn"), reasons


def _joined(reasons: Iterable[str]) -> str:
    return "; ".join(reason.replace("; ", ", ") for reason in reasons)


def _impacts(impacts: "Impacts") -> dict:
    return {
        name: ((), impacts.theta_uplift) if field == "theta_uplift" else ("impact", getattr(impacts, field))
        for field, name in IMPACTS.items()
    }


def _fits(group: str, dimension: str, models: Mapping, attrs: Mapping) -> dict:
    """Datasets of a run and of its models."""
    first = next(iter(models.values()))
    groups = {group: _dataset({"time": (dimension, first.time), "theta": (dimension, first.theta)}, attrs)}
    for model, fit in models.items():
        if not np.array_equal(fit.time, first.time):
            raise ValueError(f"{group}: the fits must share their time axis")
        covariance = (("parameter", "parameter_b"), fit.covariance)
        arrays = {"parameter": ("parameter", fit.parameters), "parameter_b": ("parameter_b", fit.parameters)}
        arrays |= {"unit": ("parameter", fit.units), "covariance": covariance}
        for name in ("value", "stderr", "ci95_low", "ci95_high"):
            arrays[name] = ("parameter", getattr(fit, name))
        for name in ("theta_model", "residual"):
            arrays[name] = (dimension, getattr(fit, name))
        for name in ("epsilon_theta", "epsilon_holdout", "aic", "bic"):
            arrays[name] = ((), getattr(fit, name))
        arrays |= {
            "final_time": ((), fit.final_time_s),
            "n_parameters": ((), np.int32(fit.n_parameters)),
            "success": ((), np.int8(fit.success)),
        }
        if fit.impacts is not None:
            arrays |= _impacts(fit.impacts)
        groups[f"{group}/{model}"] = _dataset(
            arrays, {"model": model, "message": fit.message, **fit.diagnostics}
        )
    return groups


def _dataset(arrays: Mapping, attrs: Mapping) -> xr.Dataset:
    """Dataset of named (dimensions, values), described and encoded."""
    variables = {}
    for name, (dimensions, values) in arrays.items():
        values = np.asarray(values, np.float32 if name in SINGLE_PRECISION else None)
        encoding = {}
        if {"time", "sample"} & set(np.atleast_1d(dimensions)):
            encoding |= {"zlib": True, "complevel": 4, "shuffle": True}
        if name == dimensions:
            encoding["_FillValue"] = None
        variables[name] = xr.Variable(dimensions, values, _describe(name, arrays), encoding)
    coordinates = {
        name: variables.pop(name) for name in ("time", "parameter", "parameter_b") if name in arrays
    }
    return xr.Dataset(variables, coordinates, attrs)


def _describe(name: str, present: Iterable[str]) -> dict:
    """CF attributes of a variable among those present beside it."""
    unit, long_name = VARIABLES[name.removesuffix("_stderr")]
    attrs = {"long_name": f"standard error of the {long_name}" if name.endswith("_stderr") else long_name}
    if unit:
        attrs["units"] = unit
    beside = [other for other in (f"{name}_stderr", *BESIDE.get(name, ())) if other in present]
    if beside:
        attrs["ancillary_variables"] = " ".join(beside)
    return attrs | EXTRA.get(name, {})


def _write(path: str | Path, groups: Mapping[str, xr.Dataset]) -> None:
    for dataset in groups.values():
        dataset.attrs = _plain(dataset.attrs)
    with atomic(path) as partial:
        xr.DataTree.from_dict(groups).to_netcdf(partial, engine="netcdf4")


def _plain(attrs: Mapping) -> dict:
    """Attributes that netCDF can hold: nothing empty, 0 and 1 for booleans, JSON for groups."""
    plain = {}
    for key, value in attrs.items():
        if isinstance(value, bool | np.bool_):
            plain[key] = int(value)
        elif isinstance(value, Mapping | list | tuple):
            plain[key] = json.dumps(value, sort_keys=True, ensure_ascii=False)
        elif value is not None:
            plain[key] = value
    return plain


def _open(path: str | Path, product: str) -> xr.DataTree:
    remedy = "delete the file and run snakemake again"
    if not Path(path).is_file():
        raise FreerockError(path, "there is no such file", "run snakemake to make it")
    try:
        with xr.open_datatree(path, engine="netcdf4", decode_times=False) as tree:
            tree.load()
    except (OSError, ValueError, RuntimeError, KeyError, AttributeError) as error:
        raise FreerockError(path, f"is not a readable netCDF file ({error})", remedy) from error
    if tree.attrs.get("freerock_product") != product:
        raise FreerockError(path, f"is not the {product} dataset of a record", remedy)
    return tree
