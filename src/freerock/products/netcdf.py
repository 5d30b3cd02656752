"""Datasets of a record and of its fits: netCDF in and out, with CF-1.11 and ACDD-1.3 attributes."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from freerock.arrays import Floats
from freerock.models.given import legal
from freerock.models.laws import CANDIDATES
from freerock.products.choices import CHOICE_GROUP, choice_dataset
from freerock.products.groups import Attrs
from freerock.products.names import IMPACT_VARIABLES, RUN_VARIABLES, WITH_TOTAL, root_attributes
from freerock.products.storage import open_product, root_of, root_text, write_groups
from freerock.runs.verdict import Level, Reason

# In seconds: of a time "since" a date xarray makes dates.
FROM_START = {"long_name": "time from the start of the record"}
SINCE_RELEASE = {"long_name": "time since the release"}

# Fields of a fit that are variables along its parameters, by their names.
OF_PARAMETERS = {"value": "value", "stderr": "stderr", "ci95_low": "ci95_low", "ci95_high": "ci95_high"}
OF_PARAMETERS |= {"u_law": "discrepancy", "u_total": "u_total"}
INPUTS_GROUP, PARTS_GROUP = "inputs", "parts"  # in that of a fit

if TYPE_CHECKING:
    from freerock.identification.fit import Fit, ImpactEnergy
    from freerock.noise.spectrum import Noise
    from freerock.runs.impacts import Impacts
    from freerock.runs.measured_total import MeasuredTotal
    from freerock.runs.segment import Run
    from freerock.selection.choice import Choice


def write_record(
    path: str | Path,
    record: xr.Dataset,
    runs: Sequence["Run"],
    impacts: Sequence["Impacts"],
    attrs: Attrs,
    packed: bool = True,
    totals: Sequence["MeasuredTotal | None"] = (),
    noise: "Noise | None" = None,
) -> None:
    """Write what was measured: θ(t) of the whole record and a group per run with its impacts.

    Parameters
    ----------
    path : path
        File to write.
    record : Dataset
        theta [rad], sigma_theta [rad], flags and what was recorded over time [s], with the faults, as
        `rotation.find_rotation` gives them.
    runs : sequence of Run
    impacts : sequence of Impacts
        One per run.
    attrs : mapping
        Root attributes: campaign, test, block, foundation, origin, title, ... and `provenance`; where it is
        known, start_time (ISO 8601).
    packed : bool
        Compress what runs over time.
    totals : sequence of MeasuredTotal, optional
        One per run, where the laboratory's inputs are known.
    noise : Noise, optional
        Of θ at rest.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    root = _root(record, "volts to rotation, runs and impacts", attrs, *_record_verdict(runs))
    groups = {"/": root if noise is None else root.assign(_spectrum(noise)).assign_attrs(noise=noise.told)}
    for run, found, total in zip(runs, impacts, totals or [None] * len(runs), strict=True):
        groups[f"run_{run.number}"] = xr.Dataset(
            {name: ((), getattr(run, field)) for field, name in RUN_VARIABLES.items()}
            | _impacts(found)
            | _totals(total),
            _numbered(len(found.time_s)),
            {
                "run": run.number,
                "verdict": run.verdict.level,
                "reasons": run.verdict.reasons,
                "excluded": run.excluded,
                "overridden": run.overridden,
            },
        )
    write_groups(path, groups, packed)


def write_failure(
    path: str | Path, reason: Reason, attrs: Attrs, record: xr.Dataset | None = None, packed: bool = True
) -> None:
    """Write the dataset of a record without runs: why it could not be processed, or was left out by hand.

    `record` is θ(t), as `write_record` takes it, where that much is known.
    """
    known = xr.Dataset() if record is None else record
    write_groups(path, {"/": _root(known, "not processed", attrs, reason.verdict, [reason])}, packed)


def _root(
    record: xr.Dataset, done: str, attrs: Attrs, verdict: Level, reasons: Sequence[Reason]
) -> xr.Dataset:
    """What stands in the root of a record's file."""
    attrs = {**record.attrs, **attrs}
    start_time = attrs.pop("start_time", None)
    own = ("flag_masks", "flag_meanings")  # more of them where samples are left out by hand
    return xr.Dataset(
        {
            str(name): (_dims(each), each.values, {key: each.attrs[key] for key in own if key in each.attrs})
            for name, each in record.data_vars.items()
        },
        {
            name: (_dims(each), each.values, FROM_START if name == "time" else {})
            for name, each in record.coords.items()
        },
        root_attributes("record", done, attrs)
        | {"verdict": verdict, "reasons": reasons, "time_coverage_start": start_time},
    )


def write_fits(
    path: str | Path,
    fits: Mapping[int, Mapping[str, "Fit"]],
    attrs: Attrs,
    choices: Mapping[int, "Choice"] | None = None,
    reasons: Mapping[int, Sequence[Reason]] | None = None,
    packed: bool = True,
    energies: "Mapping[int, ImpactEnergy] | None" = None,
) -> None:
    """Write identified models: a group per run, with a group per model in each.

    Parameters
    ----------
    path : path
        File to write.
    fits : mapping of int to mapping of str to Fit
        Fits of each run by run number and model; the fits of a run share their time axis.
    attrs : mapping
        Root attributes, as for `write_record`; verdict and reasons are those of the record.
    choices : mapping of int to Choice, optional
        Which candidates explain a run, by run number.
    reasons : mapping of int to sequence of Reason, optional
        What the fits of a run say against it, by run number.
    packed : bool
        Compress what runs over time.
    energies : mapping of int to ImpactEnergy, optional
        Of the measured impacts of a run, under the candidate named.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    groups = {"/": xr.Dataset(attrs=root_attributes("fits", "models identified", attrs))}
    for number, models in fits.items():
        own = {"reasons": list(reasons[number])} if reasons and reasons.get(number) else {}
        groups |= _fits(f"run_{number}", models, {"run": number, **own})
    for run, choice in (choices or {}).items():
        group = f"run_{run}"
        if group in groups:
            dataset = choice_dataset(choice)
            if energies and run in energies:
                found = energies[run]
                dataset = dataset.assign(_energies(found)).assign_coords(_numbered(len(found.time_s)))
            groups[f"{group}/{CHOICE_GROUP}"] = dataset
    write_groups(path, groups, packed)


def open_record(path: str | Path, samples: bool = True, only: Collection[str] = ()) -> xr.DataTree:
    """Read the dataset of a record into memory; without samples, all but what runs over time; `only`
    variables, if any are named.

    Raises
    ------
    FreerockError
        No such file, damaged, or not the dataset of a record.
    """
    return open_product(path, "record", samples, only=only)


def samples_in(path: str | Path, names: Iterable[str]) -> dict[str, Floats]:
    """The variables named that a record has over time; raises as `open_record`."""
    with root_of(path) as file:
        return {name: np.asarray(file[name]) for name in names if name in file}


def open_fits(path: str | Path, samples: bool = True, only: Collection[str] = ()) -> xr.DataTree:
    """Read the dataset of a record's fits into memory, as `open_record` does."""
    return open_product(path, "fits", samples, only=only)


def _record_verdict(runs: Sequence["Run"]) -> tuple[Level, list[Reason]]:
    """ok when every run is, fail when none can be used, else warn; with the reasons of all runs."""
    kept = [run for run in runs if not run.excluded]
    usable = [run for run in kept if run.verdict.level != "fail"]
    reasons = [
        reason._replace(text=f"run {run.number}: {reason.text}")
        for run in runs
        for reason in run.verdict.reasons
    ]
    if kept and not usable:
        return "fail", reasons
    return ("ok" if all(run.verdict.level == "ok" for run in runs) else "warn"), reasons


def _impacts(impacts: "Impacts") -> dict[str, Any]:
    return {
        name: ((), impacts.theta_uplift) if field == "theta_uplift" else ("impact", getattr(impacts, field))
        for field, name in IMPACT_VARIABLES.items()
    }


def _numbered(n: int) -> dict[str, Any]:
    """The coordinate of impacts: their numbers, from 1."""
    return {"impact": np.arange(1, n + 1, dtype=np.int32)}


def _spectrum(noise: "Noise") -> dict[str, Any]:
    """The spectrum of the noise at rest, with its frequencies."""
    frequency, density = noise.spectrum()
    return {"frequency": frequency, "noise_density": ("frequency", density)}


def _energies(found: "ImpactEnergy") -> dict[str, Any]:
    return {
        "restitution_energy": ("impact", found.restitution),
        "restitution_energy_u": ("impact", found.u_total),
        "impact_speed": ("impact", found.speed_m_s),
    }


def _totals(total: "MeasuredTotal | None") -> dict[str, Any]:
    if total is None:
        return {}
    each = {f"{name}_u": ("impact", getattr(total, name)) for name in WITH_TOTAL}
    return {"theta0_u": ((), total.theta0), **each}


def _fits(group: str, models: Mapping[str, "Fit"], attrs: Attrs) -> dict[str, xr.Dataset]:
    """Datasets of a run and of its models, each with its own coordinates."""
    first = next(iter(models.values()))
    time = {"time": ("time", first.time, SINCE_RELEASE)}
    groups = {group: xr.Dataset({"theta": ("time", first.theta)}, time, attrs)}
    for model, fit in models.items():
        if not np.array_equal(fit.time, first.time):
            raise ValueError(f"{group}: the fits must share their time axis")
        groups[f"{group}/{model}"] = _fit(model, fit, time)
        if fit.contributions is not None and fit.contributions.inputs:
            groups[f"{group}/{model}/{INPUTS_GROUP}"] = _inputs(fit)
        if fit.parts:
            groups[f"{group}/{model}/{PARTS_GROUP}"] = _parts(fit)
    return groups


def _fit(model: str, fit: "Fit", time: Mapping[str, Any]) -> xr.Dataset:
    """The dataset of one fit."""
    names = list(fit.parameters)
    arrays: dict[str, Any] = {
        name: ("parameter", getattr(fit, field)) for name, field in OF_PARAMETERS.items()
    }
    arrays |= {
        "covariance": (("parameter", "parameter_b"), fit.covariance),
        "theta_model": ("time", fit.theta_model),
        "residual": ("time", fit.residual),
        "epsilon_theta": ((), fit.epsilon_theta),
    }
    coordinates = {"parameter": names, "parameter_b": names, "unit": ("parameter", list(fit.units)), **time}
    if fit.result is not None:
        each = [fit.result.params[legal(name)] for name in names]
        arrays |= {
            "min": ("parameter", np.array([one.min for one in each], float)),
            "max": ("parameter", np.array([one.max for one in each], float)),
            "vary": ("parameter", np.array([one.vary for one in each], np.int8)),
            "expr": ("parameter", np.array([one.expr or "" for one in each], str)),
        }
    if fit.impacts is not None:
        own = _impacts(fit.impacts)
        arrays |= {name: own[name] for name in ("impact_time", "peak_before", "restitution")}
        coordinates |= _numbered(len(fit.impacts.time_s))
    if fit.energies is not None:
        arrays |= _energies(fit.energies)
    scalars = {
        "success": np.int8(fit.success),
        "message": fit.message,
        "final_time_s": fit.final_time_s,
        "n_parameters": np.int32(fit.n_parameters),
        **{name: getattr(fit, name) for name in ("aic", "bic", "epsilon_holdout")},
    }
    return xr.Dataset(
        arrays, coordinates, _assumes(model, names) | scalars | _of_lmfit(fit) | fit.diagnostics
    )


def _inputs(fit: "Fit") -> xr.Dataset:
    """What the inputs of the laboratory contribute to a fit, and how far it moved them."""
    assert fit.contributions is not None
    inputs = fit.contributions.inputs
    return xr.Dataset(
        {
            "contribution": (("parameter", "input"), fit.contributions.values),
            "influence_of_input": (("parameter", "input"), fit.contributions.impacts),
        },
        {
            "parameter": list(fit.parameters),
            "input": [each.name for each in inputs],
            "input_owner": ("input", [each.owner for each in inputs]),
            "input_u": ("input", np.array([each.u for each in inputs], float)),
            "input_unit": ("input", [each.unit for each in inputs]),
            "input_stated": ("input", np.array([each.stated for each in inputs], np.int8)),
            "input_moved": ("input", fit.contributions.moved),
            "input_remaining": ("input", fit.contributions.remaining),
            "input_pull": ("input", fit.contributions.pulls),
        },
    )


def _parts(fit: "Fit") -> xr.Dataset:
    """The numbers of a fit from each part of its run."""
    return xr.Dataset(
        {
            "part_start": ("part", [part.start_s for part in fit.parts]),
            "part_end": ("part", [part.end_s for part in fit.parts]),
            "part_value": (("part", "parameter"), np.array([part.value for part in fit.parts])),
            "part_value_stderr": (("part", "parameter"), np.array([part.stderr for part in fit.parts])),
        },
        {"parameter": list(fit.parameters)},
    )


def _of_lmfit(fit: "Fit") -> dict[str, Any]:
    """Method and evaluations of the least squares whose numbers are reported."""
    return {} if fit.result is None else {"method": fit.result.method, "nfev": int(fit.result.nfev)}


def _assumes(model: str, freed: Sequence[str]) -> dict[str, Any]:
    """What a candidate assumes, as attributes of its group."""
    candidate = CANDIDATES[model]
    return {
        "model": model,
        "law": candidate.law,
        "kinematics": candidate.kinematics,
        "width_freed": np.int8("width" in freed),
    }


def _dims(variable: xr.DataArray) -> list[str]:
    """Dimensions of a variable; names of faults are no coordinate, for which CF asks numbers."""
    return ["fault_number" if name == "fault" else str(name) for name in variable.dims]


def sampling_rate_of(path: str | Path) -> float:
    """Sampling rate of a record [Hz]; 0 where it is not known; raises as `open_record`."""
    return float(root_text(path, "sampling_rate_hz", "0"))
