"""Datasets: netCDF in and out, with CF-1.11 and ACDD-1.3 attributes, and the provenance of products.

Same inputs, same bytes: no time stamp is written.
"""

import json
import platform
import subprocess
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from freerock.errors import DamagedProduct, FreerockError
from freerock.files import atomic, sha256
from freerock.models.laws import MODELS
from freerock.rotation.flags import FLAGS
from freerock.runs.motion import Motion, motion_of

if TYPE_CHECKING:
    from freerock.identification.fit import Fit
    from freerock.runs.impacts import Impacts
    from freerock.runs.segment import Run

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
    "n_impacts": "n_impacts",
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

# Variable -> unit ("" for texts, flags and what has the unit of a parameter), content, long name.
VARIABLES = {
    "time": ("s", "coordinate", "time"),
    "theta": ("rad", "measured", "rotation of the block, positive clockwise"),
    "sigma_theta": ("rad", "quality", "standard deviation of the noise of theta"),
    "flags": ("", "quality", "validity of the laser sample"),
    "voltage": ("V", "measured", "output voltage of the laser"),
    "current": ("mA", "measured", "output current of the laser"),
    "displacement": ("m", "measured", "displacement as recorded"),
    "rotation": ("rad", "measured", "rotation as recorded"),
    "translation": ("m", "measured", "translation of the block along the beams, away from the sensors"),
    "fault": ("", "quality", "what is wrong with the signal"),
    "fault_start": ("s", "quality", "start of the fault"),
    "fault_end": ("s", "quality", "end of the fault"),
    "fault_note": ("", "quality", "what was found"),
    "fault_angle": ("rad", "quality", "effect of the fault on theta"),
    "hold_start": ("s", "measured", "start of the held phase before the release"),
    "release": ("s", "measured", "instant of release"),
    "start": ("s", "measured", "first instant used in a fit, after the support has left the block"),
    "end": ("s", "measured", "instant of rest"),
    "theta0": ("rad", "measured", "held rotation before the release"),
    "n_impacts": ("1", "measured", "number of sign changes of theta that stand out of the noise"),
    "impact_time": ("s", "measured", "instant of impact"),
    "peak_before": ("rad", "measured", "signed peak rotation before the impact"),
    "peak_after": ("rad", "measured", "signed peak rotation after the impact"),
    "restitution": ("1", "measured", "coefficient of restitution from the peaks before and after the impact"),
    "restitution_rate": ("1", "measured", "coefficient of restitution from the angular rates at the impact"),
    "theta_uplift": ("rad", "measured", "amplitude below which the base stays in full contact"),
    "parameter": ("", "coordinate", "name of the parameter"),
    "parameter_b": ("", "coordinate", "name of the parameter"),
    "unit": ("", "auxiliary", "unit of the parameter"),
    "value": ("", "model", "identified value of the parameter"),
    "stderr": ("", "quality", "standard error of the parameter"),
    "ci95_low": ("", "quality", "lower end of the 95 % confidence interval of the parameter"),
    "ci95_high": ("", "quality", "upper end of the 95 % confidence interval of the parameter"),
    "covariance": ("", "quality", "covariance of the parameters"),
    "theta_model": ("rad", "model", "rotation of the model with the identified parameters"),
    "residual": ("rad", "model", "theta_model minus theta"),
    "epsilon_theta": ("1", "quality", "relative mean square discrepancy of theta_model from theta"),
    "epsilon_holdout": ("1", "quality", "the same on the second half of the run, fitted on the first half"),
    "final_time": ("s", "auxiliary", "end of the fitted interval since release"),
    "aic": ("1", "quality", "Akaike information criterion"),
    "bic": ("1", "quality", "Bayesian information criterion"),
    "n_parameters": ("1", "auxiliary", "number of fitted parameters"),
    "success": ("", "quality", "whether the fit may be used"),
}
CONTENT = {
    "coordinate": "coordinate",
    "quality": "qualityInformation",
    "model": "modelResult",
    "auxiliary": "auxiliaryInformation",
    "measured": "physicalMeasurement",
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
SAMPLES = {"time", "sample"}  # dimensions of what runs over time
SINGLE_PRECISION = {"sigma_theta", *(f"{name}{n}" for name in ("voltage", "current") for n in ("", "_2"))}


def write_record(
    path: str | Path, record: xr.Dataset, runs: Sequence["Run"], impacts: Sequence["Impacts"], attrs: Mapping
) -> None:
    """Write what was measured: θ(t) of the whole record and a group per run with its impacts.

    Parameters
    ----------
    path : path
        File to write.
    record : Dataset
        theta [rad], sigma_theta [rad], flags and what was recorded over time [s], with the faults, as
        `rotation.rotation` gives them.
    runs : sequence of Run
    impacts : sequence of Impacts
        One per run.
    attrs : mapping
        Root attributes: campaign, test, block, foundation, origin, title, ... and `provenance`; where it is
        known, start_time (ISO 8601).

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    verdict, reasons = _record_verdict(runs)
    attrs = {**record.attrs, **attrs}
    start_time = attrs.pop("start_time", None)
    root = xr.Dataset(
        {str(name): (_dims(variable), variable.values) for name, variable in record.data_vars.items()},
        {"time": ("time", record["time"].values, _clock(start_time))}
        | {name: (_dims(record[name]), record[name].values) for name in record.coords if name != "time"},
        _root("record", "volts to rotation, runs and impacts", attrs)
        | {"verdict": verdict, "reasons": reasons, "time_coverage_start": start_time},
    )
    groups = {"/": root}
    for run, found in zip(runs, impacts, strict=True):
        groups[f"run_{run.number}"] = xr.Dataset(
            {name: ((), getattr(run, field)) for field, name in RUN.items()} | _impacts(found),
            attrs={
                "run": run.number,
                "verdict": run.verdict,
                "reasons": _joined(run.reasons),
                "excluded": run.excluded,
                "overridden": run.overridden,
            },
        )
    _write(path, groups)


def write_failure(path: str | Path, reason: object, attrs: Mapping, verdict: str = "fail") -> None:
    """Write the dataset of a record without runs: why it could not be processed, or was left out by hand."""
    outcome = {"verdict": verdict, "reasons": str(reason)}
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
        Joint fits of all runs by model; empty when there is none. That of a single run is
        written without samples: they stand in the run's group.
    attrs : mapping
        Root attributes, as for `write_record`; verdict and reasons are those of the record.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    groups = {"/": xr.Dataset(attrs=_root("fits", "models identified", attrs))}
    for number, models in fits.items():
        groups |= _fits(f"run_{number}", models, {"run": number})
    if pooled:
        several = bool(np.any(np.diff(next(iter(pooled.values())).time) < 0))  # it starts again with each run
        groups |= _fits("pooled", pooled, {"comment": "all runs jointly, one after the other"}, several)
    _write(path, groups)


def open_record(path: str | Path, samples: bool = True) -> xr.DataTree:
    """Read the dataset of a record into memory; without samples, all but what runs over time.

    Raises
    ------
    FreerockError
        No such file, damaged, or not the dataset of a record.
    """
    return _open(path, "record", samples)


def open_fits(path: str | Path, samples: bool = True) -> xr.DataTree:
    """Read the dataset of a record's fits into memory, as `open_record` does."""
    return _open(path, "fits", samples)


def one_of_each(
    paths: Iterable[str | Path], scenes: Iterable, opened: Callable, usable: Callable
) -> list[xr.DataTree]:
    """One product of each scene: its first that is usable, or its first where none is.

    Parameters
    ----------
    paths : iterable of path
        Products of one kind.
    scenes : iterable of hashable
        What each shows, such as block and foundation.
    opened : callable
        `open_record` or `open_fits`; called until every scene has been found.
    usable : callable
        Tells of a product whether it has something to show.
    """
    found, good = {}, set()
    for path, scene in zip(paths, scenes, strict=True):
        if scene in good:
            continue
        tree = opened(path)
        if usable(tree):
            good.add(scene)
            found[scene] = tree
        found.setdefault(scene, tree)
    return list(found.values())


def verdict_of(path: str | Path) -> tuple[str, str]:
    """Verdict and reasons of a record or of its fits, without reading more; raises as `open_record`."""
    with _readable(path) as file:
        return file.getncattr("verdict"), file.getncattr("reasons")


def runs_in(record: xr.DataTree) -> list["Run"]:
    """The runs of a record, as they were written."""
    from freerock.runs.segment import Run

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


def motions_in(record: xr.DataTree) -> dict[int, Motion]:
    """The motion of each run of a record, by run number; none of a record that could not be processed."""
    samples = record.dataset
    return {
        run.number: motion_of(run, samples["time"].values, samples["theta"].values) for run in runs_in(record)
    }


def runs_of(tree):
    """Runs of a record or fit dataset, in order.

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `records/<test>.nc` or `fits/<test>.nc`.

    Returns
    -------
    dict of int to xarray.DataTree
        By run number.
    """
    numbered = ((name.removeprefix("run_"), node) for name, node in tree.children.items())
    return dict(sorted((int(number), node) for number, node in numbered if number.isdigit()))


def fits_of(tree):
    """Fits of a dataset: those of each run in order, then the joint fit of all runs ("pooled").

    Parameters
    ----------
    tree : xarray.DataTree
        Root of `fits/<test>.nc`.

    Yields
    ------
    run : int or "pooled"
    model : str
    fit : xarray.Dataset
        View of the group.
    """
    groups = dict(runs_of(tree))
    if "pooled" in tree.children:
        groups["pooled"] = tree["pooled"]
    for run, group in groups.items():
        for model in MODELS:
            if model in group.children:
                yield run, model, group.children[model].dataset


def usable_runs(tree):
    """Runs of a record that are neither failed nor excluded, by number.

    Parameters
    ----------
    tree : xarray.DataTree
        Record dataset.

    Returns
    -------
    dict of int to xarray.DataTree
    """
    return {
        number: run
        for number, run in runs_of(tree).items()
        if run.attrs["verdict"] != "fail" and not run.attrs["excluded"]
    }


def impacts_in(group: xr.DataTree) -> "Impacts":
    """The impacts of a run of a record, or of a model of a run."""
    from freerock.runs.impacts import Impacts

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
        "software": _software(),
        "git": _git_state(),
    }


def inputs_of(record: xr.DataTree) -> dict[str, str]:
    """SHA-256 by path of the raw files of a record; none where it failed for an unforeseen reason."""
    return json.loads(record.attrs.get("provenance", '{"inputs": {}}'))["inputs"]


@cache
def _software() -> dict:
    return {"python": platform.python_version()} | {name: version(name) for name in SOFTWARE}


@cache
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
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": f"{attrs['campaign']}: {attrs['test']}",
        "keywords": "rocking, rigid block, free rocking test, restitution, Housner, Winkler, Hunt-Crossley",
        **attrs,
        "summary": attrs.get("summary") or f"A {ORIGINS[attrs['origin']]}.",
        "id": f"{attrs['campaign']}/{attrs['test']}/{product}",
        "freerock_product": product,
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


def _fits(group: str, models: Mapping, attrs: Mapping, samples: bool = True) -> dict:
    """Datasets of a run and of its models; each group has its own time, so that none is a dimension."""
    first = next(iter(models.values()))
    measured = xr.Dataset({"theta": ("sample", first.theta)}, {"time": ("sample", first.time)}, attrs)
    groups = {group: measured if samples else xr.Dataset(attrs=attrs)}
    for model, fit in models.items():
        if not np.array_equal(fit.time, first.time):
            raise ValueError(f"{group}: the fits must share their time axis")
        arrays = {
            "unit": ("parameter", list(fit.units)),
            "covariance": (("parameter", "parameter_b"), fit.covariance),
            "final_time": ((), fit.final_time_s),
            "n_parameters": ((), np.int32(fit.n_parameters)),
            "success": ((), np.int8(fit.success)),
        }
        arrays |= {
            name: ("parameter", getattr(fit, name)) for name in ("value", "stderr", "ci95_low", "ci95_high")
        }
        if samples:
            arrays |= {name: ("sample", getattr(fit, name)) for name in ("theta_model", "residual")}
        arrays |= {
            name: ((), getattr(fit, name)) for name in ("epsilon_theta", "epsilon_holdout", "aic", "bic")
        }
        if fit.impacts is not None:
            arrays |= _impacts(fit.impacts)
        names = list(fit.parameters)
        groups[f"{group}/{model}"] = xr.Dataset(
            arrays,
            {"parameter": names, "parameter_b": names},
            {"model": model, "message": fit.message, **fit.diagnostics},
        )
    return groups


def _dims(variable: xr.DataArray) -> list[str]:
    """Dimensions of a variable; names of faults are no coordinate, for which CF asks numbers."""
    return ["fault_number" if name == "fault" else str(name) for name in variable.dims]


def _clock(start_time: str | None) -> dict:
    """Attributes of the record's time, for which CF asks a date."""
    origin = start_time or "1970-01-01 00:00:00"
    comment = "counted from the start of the record" + ("" if start_time else "; its date is not known")
    return {"standard_name": "time", "units": f"seconds since {origin}", "comment": comment}


def _write(path: str | Path, groups: Mapping[str, xr.Dataset]) -> None:
    """Write the groups of a file; several times faster than xarray's own way."""
    import netCDF4

    simulated = groups["/"].attrs["origin"] == "simulated"
    with atomic(path) as partial:
        try:
            with netCDF4.Dataset(partial, "w") as file:
                defined = [
                    each
                    for name, dataset in groups.items()
                    for each in _define(file if name == "/" else file.createGroup(name), dataset, simulated)
                ]
                for variable, values in defined:  # last: each return to definitions walks all groups
                    variable[...] = values
        except RuntimeError as error:  # what netCDF4 says of a full disk
            raise OSError(str(error)) from error


def _define(group, dataset: xr.Dataset, simulated: bool) -> Iterator[tuple]:
    """Define the content of a group; yields each variable and its values."""
    group.setncatts(_plain(dataset.attrs))
    inherited = group.parent.dimensions if group.parent else {}
    for name, size in dataset.sizes.items():
        if name not in inherited or len(inherited[name]) != size:
            group.createDimension(str(name), size)
    beside = {name: set(dataset[name].dims) for name in dataset.coords if name not in dataset.dims}
    for key, variable in dataset.variables.items():
        name, dtype = str(key), variable.dtype
        if dtype.kind == "U":
            dtype = str
        elif name in SINGLE_PRECISION and variable.dims:
            dtype = np.float32
        missing = np.nan if variable.dtype.kind == "f" and name not in dataset.coords else None
        packed = {"compression": "zlib", "complevel": 4} if SAMPLES & set(variable.dims) else {}
        written = group.createVariable(name, dtype, variable.dims, fill_value=missing, **packed)
        attrs = _describe(name, dataset, simulated) | variable.attrs
        coordinates = [str(other) for other in beside if beside[other] <= set(variable.dims)]
        if coordinates and name not in dataset.coords:
            attrs["coordinates"] = " ".join(coordinates)
        written.setncatts(attrs)
        yield written, variable.values.astype(object) if dtype is str else variable.values


def _describe(name: str, present: Container, simulated: bool) -> dict:
    """CF and ACDD attributes of a variable among those present beside it."""
    unit, content, long_name = VARIABLES[name.removesuffix("_stderr").removesuffix("_2")]
    if name.endswith("_stderr"):
        content, long_name = "quality", f"standard error of the {long_name}"
    elif content == "measured" and simulated:
        content = "model"
    attrs = {"long_name": long_name, "coverage_content_type": CONTENT[content]}
    if unit:
        attrs["units"] = unit
    beside = [other for other in (f"{name}_stderr", *BESIDE.get(name, ())) if other in present]
    if beside:
        attrs["ancillary_variables"] = " ".join(beside)
    return attrs | EXTRA.get(name, {})


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


@contextmanager
def _readable(path: str | Path) -> Iterator:
    """The netCDF file, with an error of its own for what can't be read."""
    import netCDF4

    if not Path(path).is_file():
        raise FreerockError(path, "there is no such file", "run snakemake to make it")
    try:
        with netCDF4.Dataset(path) as file:
            yield file
    except (OSError, ValueError, RuntimeError, KeyError, AttributeError) as error:
        remedy = "delete the file and run snakemake again"
        raise DamagedProduct(path, f"is not a readable netCDF file ({error})", remedy) from error


def _open(path: str | Path, product: str, samples: bool = True) -> xr.DataTree:
    with _readable(path) as file:
        file.set_auto_maskandscale(False)
        tree = xr.DataTree.from_dict(dict(_groups(file, samples)))
    if tree.attrs.get("freerock_product") != product:
        remedy = "delete the file and run snakemake again"
        raise FreerockError(path, f"is not the {product} dataset of a record", remedy)
    return tree


def _groups(group, samples: bool, axis: str = "sample") -> Iterator[tuple[str, xr.Dataset]]:
    """Path and content of a netCDF group and of those in it; several times faster than xarray's own way.

    Samples are numbered by their time, where it does not fall back.
    """
    variables, coordinates = {}, set(group.variables) & set(group.dimensions)
    if samples and "sample" in group.dimensions and np.all(np.diff(group["time"][...]) > 0):
        axis = "time"
    for name, variable in group.variables.items():
        if not samples and SAMPLES & set(variable.dimensions):
            continue
        attrs = {key: variable.getncattr(key) for key in variable.ncattrs() if key != "_FillValue"}
        coordinates |= set(attrs.pop("coordinates", "").split())
        values = np.asarray(variable[...], str if variable.dtype is str else None)
        dimensions = [axis if each == "sample" else each for each in variable.dimensions]
        variables[name] = xr.Variable(dimensions, values, attrs)
    attrs = {key: group.getncattr(key) for key in group.ncattrs() if key != "coordinates"}
    data = {name: variables[name] for name in variables if name not in coordinates}
    present = {name: variables[name] for name in variables if name in coordinates}
    yield group.path, xr.Dataset(data, present, attrs)
    for inner in group.groups.values():
        yield from _groups(inner, samples, axis)
