"""Datasets of a record and of its fits: netCDF in and out, with CF-1.11 and ACDD-1.3 attributes.

A file is written whole by `files.atomic`; `open_product` refuses a damaged one.
"""

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from freerock.models.free_parameters import PARAMETERS
from freerock.models.given import legal
from freerock.products.contents import CHOICE_GROUP, INPUTS_GROUP, Attrs
from freerock.products.netcdf_groups import (
    IMPACT_VARIABLES,
    RUN_VARIABLES,
    WITH_TOTAL,
    open_product,
    root_attributes,
    write_groups,
)
from freerock.runs.verdict import Level, Reason

FROM_START = "time from the start of the record"
# CF wants a date in the units of `time`. With a capital S, which UDUNITS reads alike, xarray keeps seconds.
SINCE, ANY_DATE = "seconds Since {}", "1970-01-01"
SINCE_RELEASE = {"long_name": "time since the release"}

# Numbers of the evidence of a fit that are attributes.
OF_EVIDENCE = ("noise_p", "residual_over_noise", "n_parameters")
CHOICE_NUMBERS = ("minus_two_log", "n_parameters", "residual_over_noise", "p_prediction")
PAPER_GROUP = "paper_{}"  # of a law, in that of a run

if TYPE_CHECKING:
    from freerock.identification.fitted import Fit
    from freerock.identification.paper_fit import PaperFit
    from freerock.populations.impact_energy import ImpactEnergy
    from freerock.runs.runs import Measured
    from freerock.runs.u_of_measured import MeasuredTotal
    from freerock.selection.choice import Choice


def write_record(
    path: str | Path,
    record: xr.Dataset,
    found: "Measured",
    totals: Sequence["MeasuredTotal"],
    attrs: Attrs,
) -> None:
    """Write what was measured: θ(t) of the whole record and a group per run with its impacts.

    The record is ok when every run is, fail when none can be used, else warn; it has the reasons of all runs.

    Parameters
    ----------
    path : path
        File to write.
    record : Dataset
        theta [rad], sigma_theta [rad], flags and what was recorded over time [s], with the faults, as
        `rotation.find_rotation` gives them.
    found : Measured
        Runs, their impacts, and the noise at rest.
    totals : sequence of MeasuredTotal
        One per run.
    attrs : mapping
        Root attributes: campaign, test, block, foundation, origin, title, ... and `provenance`; where it is
        known, start_time (ISO 8601).

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    reasons = [
        reason._replace(text=f"run {run.number}: {reason.text}")
        for run in found.runs
        for reason in run.verdict.reasons
    ]
    verdict: Level = "ok" if all(run.verdict.level == "ok" for run in found.runs) else "warn"
    kept = [run for run in found.runs if not run.excluded]
    if kept and all(run.verdict.level == "fail" for run in kept):
        verdict = "fail"
    root = _root(record, "volts to rotation, runs and impacts", attrs, verdict, reasons)
    if found.noise:
        frequency, density = found.noise.spectrum()
        root = root.assign({"frequency": frequency, "noise_density": ("frequency", density)})
        root = root.assign_attrs(noise=json.dumps(vars(found.noise), default=np.ndarray.tolist))
    groups = {"/": root}
    for run, impacts, total in zip(found.runs, found.impacts, totals, strict=True):
        groups[f"run_{run.number}"] = xr.Dataset(
            {name: ((), getattr(run, field)) for field, name in RUN_VARIABLES.items()}
            | {name: ("impact", getattr(impacts, field)) for field, name in IMPACT_VARIABLES.items()}
            | {"theta_uplift": ((), impacts.theta_uplift), "theta0_u": ((), total.theta0)}
            | {f"{name}_u": ("impact", getattr(total, name)) for name in WITH_TOTAL},
            {"impact": np.arange(1, len(impacts.time_s) + 1, dtype=np.int32)},
            {
                "run": run.number,
                "verdict": run.verdict.level,
                "reasons": run.verdict.reasons,
                "excluded": run.excluded,
                "overridden": "overridden" in run.verdict.names,
            },
        )
    write_groups(path, groups)


def write_failure(path: str | Path, reason: Reason, attrs: Attrs, record: xr.Dataset | None = None) -> None:
    """Write the dataset of a record without runs: why it could not be processed, or was left out by hand.

    `record` is θ(t), as `write_record` takes it, where that much is known.
    """
    known = xr.Dataset() if record is None else record
    write_groups(path, {"/": _root(known, "not processed", attrs, reason.verdict, [reason])})


def _root(
    record: xr.Dataset, done: str, attrs: Attrs, verdict: Level, reasons: Sequence[Reason]
) -> xr.Dataset:
    """What stands in the root of a record's file."""
    if "fault" in record.dims:  # names of faults are no coordinate, for which CF asks numbers
        record = record.rename_dims(fault="fault_number")
    attrs = {**record.attrs, **attrs}
    start_time = attrs.pop("start_time", None)
    from_start = {"long_name": FROM_START + (" (its date is not known)" if start_time is None else "")}
    from_start |= {"standard_name": "time", "units": SINCE.format(start_time or ANY_DATE)}
    own = ("flag_masks", "flag_meanings")  # more of them where samples are left out by hand
    return xr.Dataset(
        {
            str(name): (each.dims, each.values, {key: each.attrs[key] for key in own if key in each.attrs})
            for name, each in record.data_vars.items()
        },
        {
            name: (each.dims, each.values, from_start if name == "time" else {})
            for name, each in record.coords.items()
        },
        root_attributes("record", done, attrs)
        | {"verdict": verdict, "reasons": reasons, "time_coverage_start": start_time},
    )


def write_fits(
    path: str | Path,
    fits: Mapping[int, Mapping[str, "Fit"]],
    attrs: Attrs,
    choice: "Choice | None" = None,
    papers: Mapping[int, Mapping[str, "PaperFit"]] | None = None,
    reasons: Mapping[int, Sequence[Reason]] | None = None,
    energies: "Mapping[int, Mapping[str, ImpactEnergy]] | None" = None,
) -> None:
    """Write identified models: a group per run, with a group per candidate and law of the paper in each.

    Parameters
    ----------
    path : path
        File to write.
    fits : mapping of int to mapping of str to Fit
        Fits of each run by run number and candidate; the fits of a run share their time axis.
    attrs : mapping
        Root attributes, as for `write_record`; verdict and reasons are those of the record.
    choice : Choice, optional
        Which law the runs need: it stands with each of them.
    papers : mapping of int to mapping of str to PaperFit, optional
        The paper's own fits of each run, by law.
    reasons : mapping of int to sequence of Reason, optional
        What the fits of a run say against it, by run number.
    energies : mapping of int to mapping of str to ImpactEnergy, optional
        Of the impacts of each fit, by run number and candidate.

    Raises
    ------
    FreerockError
        The file can't be written.
    """
    groups = {"/": xr.Dataset(attrs=root_attributes("fits", "models identified", attrs))}
    for number, models in fits.items():
        own = {"reasons": list(reasons[number])} if reasons and reasons.get(number) else {}
        group, curve = f"run_{number}", next(iter(models.values())).curve
        groups[group] = xr.Dataset(
            {"theta": ("time", curve.theta)},
            {"time": ("time", curve.time, SINCE_RELEASE)},
            {"run": number, **own},
        )
        for model, fit in models.items():
            if not np.array_equal(fit.curve.time, curve.time):
                raise ValueError(f"{group}: the fits must share their time axis")
            groups[f"{group}/{model}"] = _fit(model, fit, (energies or {}).get(number, {}).get(model))
            if fit.uncertainty.contributions.inputs:
                groups[f"{group}/{model}/{INPUTS_GROUP}"] = _inputs(fit)
        for law, paper in (papers or {}).get(number, {}).items():
            groups[f"run_{number}/{PAPER_GROUP.format(law)}"] = _paper(paper)
        if choice:
            groups[f"run_{number}/{CHOICE_GROUP}"] = _choice(choice)
    write_groups(path, groups, named=False)


def open_record(path: str | Path, samples: bool = True, only: Collection[str] = ()) -> xr.DataTree:
    """Read the dataset of a record into memory; without samples, all but what runs over time; `only`
    variables, if any are named.

    Raises
    ------
    FreerockError
        No such file, damaged, or not the dataset of a record.

    Examples
    --------
    >>> record = freerock.open_record("results/palermo_virtual/records/config2_marble.nc")  # doctest: +SKIP
    >>> round(record["run_1"]["restitution"].sel(impact=1).item(), 3)  # doctest: +SKIP
    0.943
    """
    return open_product(path, "record", samples, only)


def open_fits(path: str | Path, samples: bool = True, only: Collection[str] = ()) -> xr.DataTree:
    """Read the dataset of a record's fits into memory, as `open_record` does.

    Examples
    --------
    >>> fits = freerock.open_fits("results/palermo_virtual/fits/config2_marble.nc")  # doctest: +SKIP
    >>> fits["run_1/hunt_crossley/theta_model"].plot()  # doctest: +SKIP
    [<matplotlib.lines.Line2D object at ...>]
    >>> print(f"{fits['run_1/hunt_crossley/value'].sel(parameter='k').item():.1e}")  # doctest: +SKIP
    6.9e+06
    """
    return open_product(path, "fits", samples, only)


def _fit(model: str, fit: "Fit", energies: "ImpactEnergy | None") -> xr.Dataset:
    """The dataset of one fit."""
    names, known, scatter = list(fit.values), fit.uncertainty, fit.scatter.of_record
    n = len(fit.impacts.time_s) if fit.impacts is not None else len(fit.scatter.delta)
    each = [fit.result.params[legal(name)] for name in names]
    of_parameters: dict[str, Any] = {
        "unit": np.array(fit.units, str),
        "value": fit.value,
        "stderr": known.stderr,
        "u_law": known.u_law,
        "u_total": known.u_total,
        "min": np.array([one.min for one in each], float),
        "max": np.array([one.max for one in each], float),
        "vary": np.array([one.vary for one in each], np.int8),
        "expr": np.array([one.expr or "" for one in each], str),
    }
    of_impacts = {"delta": fit.scatter.delta, "delta_u": fit.scatter.u_delta}
    if fit.impacts is not None:
        of_impacts |= {"impact_time": fit.impacts.time_s, "peak_before": fit.impacts.peak_before_rad}
    if energies is not None:
        of_impacts |= {"restitution_energy": energies.restitution, "restitution_energy_u": energies.u_total}
    scalars = {"epsilon_theta": fit.evidence.epsilon_theta, "sigma_r": scatter.sigma_r}
    arrays: dict[str, Any] = {name: ("parameter", values) for name, values in of_parameters.items()}
    arrays |= {"covariance": (("parameter", "parameter_b"), known.covariance)}
    arrays |= {"theta_model": ("time", fit.curve.theta_model), "residual": ("time", fit.curve.residual)}
    unknown = np.full(n, np.nan)  # of impacts beyond those that a quantity has
    arrays |= {name: ("impact", np.append(values, unknown)[:n]) for name, values in of_impacts.items()}
    arrays |= {name: ((), value) for name, value in scalars.items()}
    told = {
        "model": model,
        "success": np.int8(fit.success),
        "message": fit.message,
        "sigma_r_low": scatter.low,
        "sigma_r_high": scatter.high,
        "agrees_with_noise": np.int8(fit.evidence.agrees),
        **{name: getattr(fit.evidence, name) for name in OF_EVIDENCE},
        "nfev": int(fit.result.nfev),
    }
    coordinates: dict[str, Any] = {"parameter": names, "time": ("time", fit.curve.time, SINCE_RELEASE)}
    coordinates["impact"] = np.arange(1, n + 1, dtype=np.int32)
    return xr.Dataset(arrays, coordinates, told)


def _paper(fit: "PaperFit") -> xr.Dataset:
    """The dataset of a law as the paper fits it."""
    names = list(fit.values)
    arrays: dict[str, Any] = {
        "unit": ("parameter", [PARAMETERS[name].unit for name in fit.values]),
        "value": ("parameter", np.array(list(fit.values.values()))),
        "stderr": ("parameter", fit.stderr),
        "theta_model": ("time", fit.curve.theta_model),
        "residual": ("time", fit.curve.residual),
        "epsilon_theta": ((), fit.epsilon_theta),
    }
    coordinates: dict[str, Any] = {"parameter": names, "time": ("time", fit.curve.time, SINCE_RELEASE)}
    if fit.impacts is not None:
        arrays |= {"impact_time": ("impact", fit.impacts.time_s)}
        arrays |= {"peak_before": ("impact", fit.impacts.peak_before_rad)}
        arrays |= {"restitution": ("impact", fit.impacts.restitution)}
        coordinates["impact"] = np.arange(1, len(fit.impacts.time_s) + 1, dtype=np.int32)
    told = {"law": fit.model, "success": np.int8(fit.success), "message": fit.message}
    told |= {"final_time_s": float(fit.curve.time[-1]), "nfev": int(fit.result.nfev)}
    return xr.Dataset(arrays, coordinates, told)


def _inputs(fit: "Fit") -> xr.Dataset:
    """What the inputs of the laboratory contribute to a fit, and how far it moved them."""
    from freerock.rotation.laboratory import UNITS  # loads in 0.5 s; readers do not need it

    known = fit.uncertainty.contributions
    return xr.Dataset(
        {
            "contribution": (("parameter", "input"), known.values),
            "influence_of_input": (("parameter", "input"), known.impacts),
        },
        {
            "parameter": list(fit.values),
            "input": [each.name for each in known.inputs],
            "input_owner": ("input", [each.owner for each in known.inputs]),
            "input_u": ("input", np.array([each.u for each in known.inputs], float)),
            "input_unit": ("input", [UNITS[each.name] for each in known.inputs]),
            "input_stated": ("input", np.array([each.stated for each in known.inputs], np.int8)),
            "input_moved": ("input", known.moved),
            "input_remaining": ("input", known.remaining),
            "input_pull": ("input", known.pulls),
        },
    )


def _choice(choice: "Choice") -> xr.Dataset:
    """The choice of a record as it is stored with each run.

    Parameters
    ----------
    choice : freerock.selection.choice.Choice

    Returns
    -------
    xarray.Dataset
        Along candidate: status and reason (texts), and `CHOICE_NUMBERS`, NaN where a candidate has no such
        number. Attributes: selected, level, criterion, reason.
    """
    kinds: dict[str, type] = {"status": str, "reason": str} | dict.fromkeys(CHOICE_NUMBERS, float)
    arrays: dict[str, Any] = {
        name: ("candidate", np.array([getattr(each, name) for each in choice.judged], kind))
        for name, kind in kinds.items()
    }
    told = {name: getattr(choice, name) for name in ("selected", "level", "criterion", "reason")}
    return xr.Dataset(arrays, {"candidate": [each.model for each in choice.judged]}, told)
