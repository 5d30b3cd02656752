"""Rows of the tidy tables: one per run, parameter, fit, candidate or impact, from datasets."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.columns import table_of
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import LAWS, MODELS
from freerock.populations.impact_energy import of_measured
from freerock.products.contents import (
    EXPLAINED,
    choices_of,
    fits_of,
    n_restitutions,
    named_in,
    paper_fits_of,
    runs_of,
    selected_fit,
    verdict_of_run,
)
from freerock.products.netcdf_groups import reasons_in
from freerock.runs.u_of_measured import OF_LAW
from freerock.runs.verdict import KNOWN_REASONS, Reason, in_one_line
from freerock.tables.choices import POSSIBLE
from freerock.tables.populations import INPUT

R_ENERGY, R_ENERGY_U = "r_energy", "r_energy_u"  # columns of restitution.csv, for those who read them
# Of impacts: columns, and their variables in the datasets, which not all of them have.
OF_IMPACTS = {"r": "restitution", "r_stderr": "restitution_stderr", "r_u": "restitution_u"}
OF_IMPACTS |= {R_ENERGY: "restitution_energy", R_ENERGY_U: "restitution_energy_u"}
OF_IMPACTS |= {"delta": "delta", "delta_u": "delta_u"}
PEAKS = {"peak_before_deg": "peak_before", "peak_before_u_deg": "peak_before_u"}
OF_SELECTED = ("restitution_energy", "restitution_energy_u", "delta", "delta_u")  # of its impacts
NUMBERS_OF_FIT = ("value", "stderr", "u_law", "u_total")
OF_EVIDENCE = ("residual_over_noise", "noise_p", "sigma_r_low", "sigma_r_high", "n_parameters")
IDENTITY = ["campaign", "test", "run", "block", "foundation"]
OF_LAWS = dict.fromkeys(name for law in LAWS.values() for name in law.parameters)
MOVED = [*INPUT, "input_moved", "input_remaining", "input_pull"]
CONTRIBUTIONS = [*IDENTITY, "model", "parameter", "value", *INPUT, "contribution"]
MEASURED_OF_RUN = ("theta0_deg", "theta0_u_deg", "release_s", "duration_s", "sigma_theta_deg")
Trees = Iterable[xr.DataTree]


def runs_table(records: Trees, fits: Trees = ()) -> pd.DataFrame:
    """One row per run; a record that could not be processed has one row without a run number.

    Parameters
    ----------
    records : iterable of xarray.DataTree
        Record datasets.
    fits : iterable of xarray.DataTree, optional
        Fit datasets, whose reasons count too (`products.contents`).

    Returns
    -------
    pandas.DataFrame
        Columns of runs.csv: release_s is on the record's clock [s], duration_s the time from release to
        rest [s], angles in degrees, theta0_u_deg the total uncertainty of theta0_deg; n_impacts are zero
        crossings, n_restitution impacts have a restitution. Failed and excluded runs are rows like any
        other, with their reasons.
    """
    rows = []
    for tree, number, run, verdict, reasons in _judged(records, fits):
        if run is None:
            left_out = verdict != "fail"  # by hand, the whole record
            of_run: dict[str, Any] = dict.fromkeys(MEASURED_OF_RUN, math.nan)
            of_run |= {"n_impacts": 0, "n_restitution": 0, "excluded": left_out}
        else:
            release = run["release"].item()
            of_run = {
                "theta0_deg": math.degrees(run["theta0"].item()),
                "theta0_u_deg": math.degrees(run["theta0_u"].item()),
                "release_s": release,
                "duration_s": run["end"].item() - release,
                "n_impacts": run["n_impacts"].item(),
                "n_restitution": n_restitutions(run),
                "sigma_theta_deg": math.degrees(run["sigma_theta"].item()),
                "excluded": bool(run.attrs["excluded"]),
            }
        told = {"origin": tree.attrs["origin"], "verdict": verdict, "reasons": in_one_line(reasons)}
        rows.append({**_identity(tree, number), **told, **of_run})
    whole = dict.fromkeys(["run", "n_impacts", "n_restitution"], "Int64")
    return table_of("runs", rows).astype(whole)


def reasons_table(records: Trees, fits: Trees = ()) -> pd.DataFrame:
    """One row per reason of a verdict, in the order of `reasons` in the table of runs.

    Parameters
    ----------
    records : iterable of xarray.DataTree
        Record datasets.
    fits : iterable of xarray.DataTree, optional
        Fit datasets, whose reasons count too.

    Returns
    -------
    pandas.DataFrame
        Columns of reasons.csv: verdict is what this reason alone would make of the run; value and limit
        are in unit, NaN of what is no number; key is the limit's in the configuration, empty where no key
        sets it; remedy says what to do.
    """
    rows = [
        _identity(tree, number)
        | {"verdict": each.verdict, "reason": each.name, "sentence": each.text, "remedy": _remedy(each.name)}
        | {"value": each.value, "limit": each.limit, "unit": each.unit, "key": each.key}
        for tree, number, _, _, reasons in _judged(records, fits)
        for each in reasons
    ]
    frame = table_of("reasons", rows)
    return frame.astype({"run": "Int64", "value": float, "limit": float})


def _remedy(name: str) -> str:
    """What to do about a reason, without the links of a page."""
    known = KNOWN_REASONS.get(name)
    return re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", known.remedy) if known else ""


def _judged(
    records: Trees, fits: Trees
) -> Iterator[tuple[xr.DataTree, Any, xr.DataTree | None, str, Sequence[Reason]]]:
    """Each run with its record, number, verdict and reasons; of a record without runs those of its own."""
    by_test = {tree.attrs["test"]: tree for tree in fits}
    for tree in records:
        runs = runs_of(tree)
        for number, run in runs.items():
            verdict = verdict_of_run(number, run, by_test.get(tree.attrs["test"]))
            yield tree, number, run, verdict.level, verdict.reasons
        if not runs:
            yield tree, pd.NA, None, tree.attrs["verdict"], reasons_in(tree.attrs)


def parameters_table(fits: Trees) -> pd.DataFrame:
    """One row per identified parameter, freed release angles and times included.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of parameters.csv, SI units; stderr is that of noise and scatter, u_law what a residual beyond
        the noise adds, u_total the total with the inputs; given is empty of what the fit found, else "fixed",
        "tied: ..." or "undetermined"; success says whether the fit may be used.
    """
    rows = []
    for of_fit, fit, _ in _each_fit(fits):
        numbers = {key: fit[key].values for key in NUMBERS_OF_FIT}
        numbers["correlation"] = _with_first(fit["covariance"].values)
        for i, parameter in enumerate(fit["parameter"].values.astype(str)):
            rows.append(
                {
                    **of_fit,
                    "parameter": parameter,
                    **{key: column[i] for key, column in numbers.items()},
                    "unit": PARAMETERS[parameter].unit,
                    "given": _given(fit, i),
                    "success": bool(fit.attrs["success"]),
                }
            )
    return table_of("parameters", rows).astype({"success": bool})


def _with_first(covariance: Floats) -> Floats:
    """Correlation of each parameter with the first; NaN of the first, and where it is not known."""
    u = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.append(np.nan, (covariance[0] / (u[0] * u))[1:]))


def _given(fit: xr.Dataset, i: int) -> str:
    """What was said of a parameter in place of finding it, in words."""
    if "vary" not in fit or fit["vary"].values[i]:
        return ""
    if expr := str(fit["expr"].values[i]):
        return f"tied: {expr}"
    return "undetermined" if fit.attrs["success"] and np.isnan(fit["stderr"].values[i]) else "fixed"


def contributions_table(fits: Trees) -> pd.DataFrame:
    """One row per identified parameter of a usable fit and input of the laboratory, its law as the last.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns `CONTRIBUTIONS`: contribution is the shift of the parameter for one standard
        uncertainty of the input, in the parameter's unit; input_u in input_unit. What the law does not
        explain counts as an input `law` that all fits of the law share.
    """
    rows = []
    for of_fit, fit, known in _each_fit(fits):
        if "contribution" not in known:
            continue
        inputs = list(zip(*(known[name].values.tolist() for name in INPUT), strict=True))
        inputs.append((OF_LAW, of_fit["model"], math.nan, "", pd.NA))
        shifts = np.column_stack([known["contribution"].values, fit["u_law"].values])
        found = zip(fit["parameter"].values.astype(str), fit["value"].values, shifts, strict=True)
        for parameter, value, own in found:
            for source, shift in zip(inputs, own, strict=True):
                rows.append((*of_fit.values(), parameter, value, *source, shift))
    return pd.DataFrame(rows, columns=CONTRIBUTIONS)


def pulls_table(fits: Trees) -> pd.DataFrame:
    """One row per input of the laboratory and usable fit that moved it.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of pulls.csv: input_moved is the shift of the
        input by the fit, in its standard uncertainties; input_remaining its standard uncertainty after the
        fit over that before; input_pull the shift over its standard deviation, NaN where the run does not see
        the input; influence_k_percent and so on the shift of a parameter for one remaining standard
        uncertainty of the input, in per cent, NaN of other laws.
    """
    rows = []
    for of_fit, fit, inputs in _each_fit(fits):
        if "input_moved" not in inputs or not np.any(inputs["input_moved"].values):
            continue
        shifts = 100 * inputs["influence_of_input"].values / fit["value"].values[:, None]
        shift_of = dict(zip(fit["parameter"].values.astype(str).tolist(), shifts.tolist(), strict=True))
        columns = {name: inputs[name].values.tolist() for name in MOVED}
        unknown = [math.nan] * shifts.shape[1]
        columns |= {f"influence_{name}_percent": shift_of.get(name, unknown) for name in OF_LAWS}
        rows += [
            {**of_fit, **dict(zip(columns, each, strict=True))}
            for each in zip(*columns.values(), strict=True)
        ]
    return table_of("pulls", rows)


def epsilon_table(fits: Sequence[xr.DataTree]) -> pd.DataFrame:
    """One row per fit: how far the model is from the measured θ(t).

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of epsilon.csv; epsilon_theta is a fraction, with inputs and impacts free; selected the model
        chosen for that run (`choice_table`), success says whether the fit may be used.
    """
    rows = []
    named = {tree.attrs["test"]: {run: named_in(own) for run, own in runs_of(tree).items()} for tree in fits}
    for of_fit, fit, _ in _each_fit(fits):
        numbers = {key: fit.attrs[key] for key in OF_EVIDENCE}
        row = {"epsilon_theta": fit["epsilon_theta"].item(), "sigma_r": fit["sigma_r"].item(), **numbers}
        row["selected"] = of_fit["model"] == named[of_fit["test"]][of_fit["run"]]
        row |= {name: bool(fit.attrs[name]) for name in ("agrees_with_noise", "success")}
        rows.append(of_fit | row)
    frame = table_of("epsilon", rows)
    return frame.astype(
        {"n_parameters": "Int64", "selected": bool, "agrees_with_noise": bool, "success": bool}
    )


def paper_table(fits: Trees) -> pd.DataFrame:
    """One row per run, law and parameter of the fits by the paper's own procedure.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of paper.csv, SI units; epsilon_theta is a fraction up to final_time_s [s].
    """
    rows = []
    for tree in fits:
        for run, law, fit in paper_fits_of(tree):
            values = dict(zip(fit["parameter"].values.astype(str), fit["value"].values, strict=True))
            told = {"epsilon_theta": fit["epsilon_theta"].item(), "final_time_s": fit.attrs["final_time_s"]}
            told |= {**_identity(tree, run), "model": law, "success": bool(fit.attrs["success"])}
            rows += [
                told | {"parameter": name, "unit": PARAMETERS[name].unit, "value": values[name]}
                for name in MODELS[law]
            ]
    return table_of("paper", rows).astype({"success": bool})


def choice_table(fits: Trees) -> pd.DataFrame:
    """One row per run and candidate of fit datasets: what the choice made of it, and why.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of choice.csv: status is "selected", "also_possible", "rejected" or "not_fitted"; explains
        whether a candidate that is possible explains the runs of its record, to the noise or to their
        repeatability.
    """
    rows = []
    for tree in fits:
        for run, choice in choices_of(tree):
            numbers = {str(name): values.values.tolist() for name, values in choice.data_vars.items()}
            level = {key: str(choice.attrs[key]) for key in ("level", "criterion")}
            for i, model in enumerate(choice["candidate"].values.astype(str)):
                found = {name: column[i] for name, column in numbers.items()}
                explains = found["status"] in POSSIBLE and level["level"] in EXPLAINED
                rows.append({**_identity(tree, run), "model": model, **found, **level, "explains": explains})
    frame = table_of("choice", rows)
    return frame.astype({"explains": bool, "n_parameters": "Int64"})


def _of_impacts(node: xr.Dataset, name: str) -> Floats:
    """A variable of the impacts that not all of them have; NaN where there is none."""
    return np.asarray(node[name].values if name in node else np.full(node.sizes["impact"], np.nan))


def restitution_table(records: Trees, fits: Trees) -> pd.DataFrame:
    """One row per impact of the measured runs and of the laws fitted to each by the paper's own procedure.

    Parameters
    ----------
    records, fits : iterable of xarray.DataTree
        Record and fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns of restitution.csv; source is "experiment" or a law, impact counts from 1, time_s is
        since the release [s], r the restitution from the peaks before and after the impact, peak_before_deg
        the peak |θ| before it, both of the rotation seen; of those measured r_u and peak_before_u_deg are the
        total uncertainties. r_energy is the root of the ratio of true energies, of a measured impact under
        the selected law, r_energy_u its total uncertainty; delta is by that law.
    """
    fits, parts = list(fits), list[tuple[xr.DataTree, int, str, xr.Dataset, float]]()
    selected = {
        (tree.attrs["test"], number): found[1]
        for tree in fits
        for number, run in runs_of(tree).items()
        if (found := selected_fit(run))
    }
    for tree in records:
        for number, group in runs_of(tree).items():
            measured = _with_energies(group.dataset, selected.get((tree.attrs["test"], number)))
            parts.append((tree, number, "experiment", measured, measured["release"].item()))
    for tree in fits:
        parts += [(tree, run, law, fit, 0.0) for run, law, fit in paper_fits_of(tree)]
    frames = [
        pd.DataFrame(
            {
                **_identity(tree, run),
                "source": source,
                "impact": np.arange(1, node.sizes["impact"] + 1),
                "time_s": node["impact_time"].values - release,
                **{column: _of_impacts(node, name) for column, name in OF_IMPACTS.items()},
                **{column: np.degrees(np.abs(_of_impacts(node, name))) for column, name in PEAKS.items()},
            }
        )
        for tree, run, source, node, release in parts
        if node.sizes.get("impact", 0)
    ]
    if not frames:
        return table_of("restitution", [])
    frame = pd.concat(frames, ignore_index=True)
    ranks = {"test": list(dict.fromkeys(frame["test"])), "source": ["experiment", *MODELS]}
    order = frame.sort_values(
        ["test", "run", "source", "impact"],
        key=lambda column: column.map(ranks[column.name].index) if column.name in ranks else column,
    )
    return table_of("restitution", order).reset_index(drop=True)


def _with_energies(measured: xr.Dataset, fit: xr.Dataset | None) -> xr.Dataset:
    """Measured impacts with their energies under the selected law, those of its nearest impacts."""
    if fit is None or "restitution_energy" not in fit or not fit.sizes["impact"]:
        return measured
    since_s = measured["impact_time"].values - measured["release"].item()
    own = of_measured(since_s, fit["impact_time"].values)
    known = {name: fit[name].values for name in OF_SELECTED if name in fit}
    return measured.assign(
        {name: ("impact", np.where(own >= 0, values[own], np.nan)) for name, values in known.items()}
    )


def _each_fit(fits: Trees) -> Iterator[tuple[dict[str, Any], xr.Dataset, xr.Dataset]]:
    """What each fit is of, the fit, and what the inputs of the laboratory have to do with it."""
    for tree in fits:
        for run, model, fit, inputs in fits_of(tree):
            yield {**_identity(tree, run), "model": model}, fit, inputs


def _identity(tree: xr.DataTree, run: object) -> dict[str, Any]:
    return {key: run if key == "run" else str(tree.attrs[key]) for key in IDENTITY}
