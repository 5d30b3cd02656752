"""What the page draws and lists of a record, as plain numbers and texts: JSON, angles in degrees."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from freerock.arrays import Floats, extremes
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, LAWS, MODEL_LABELS, MODELS, SYMBOLS
from freerock.products.choices import GROUP
from freerock.products.groups import impacts_of, reasons_in, runs_of
from freerock.products.verdicts import verdict_of_run
from freerock.review.bench import Analysed
from freerock.rotation.flags import FLAGS
from freerock.runs.verdict import in_one_line
from freerock.tables.candidates import STATUS_WORDS
from freerock.tables.text import quantity, unit_text
from freerock.units import BASE

BINS = 900  # of a curve, with two samples drawn in each: about as many as it has columns on the screen
MOST_FLAGGED = 200  # stretches of invalid samples drawn; those that are near each other become one
Json = dict[str, Any]


def rows_of(test: str, found: Analysed) -> list[Json]:
    """The lines of a record in the list of runs: one for each run, or one for a record without any."""
    record, fits = found
    fitted = runs_of(fits) if fits is not None else {}
    same = {"test": test, "block": record.attrs["block"], "foundation": record.attrs["foundation"]}
    rows = []
    for number, run in runs_of(record).items():
        verdict = verdict_of_run(number, run, fits)
        release = run["release"].item()
        rows.append(
            same
            | {"run": number, "verdict": verdict.level, "reasons": in_one_line(verdict.reasons)}
            | {"excluded": bool(run.attrs["excluded"]), "overridden": bool(run.attrs["overridden"])}
            | {"release_s": release, "duration_s": run["end"].item() - release}
            | {"theta0_deg": math.degrees(run["theta0"].item())}
            | chosen(fitted.get(number))
        )
    if not rows:
        left_out = record.attrs["verdict"] != "fail"
        outcome = {"verdict": record.attrs["verdict"], "reasons": in_one_line(reasons_in(record.attrs))}
        rows.append(same | outcome | {"run": None, "excluded": left_out} | chosen(None))
    return rows


def chosen(group: xr.DataTree | None) -> Json:
    """Name of the candidate chosen for a run, whether it explains the run, and its ε_θ."""
    if group is None or GROUP not in group.children:
        return {"model": "", "explained": False, "epsilon": None}
    choice = group.children[GROUP]
    model = str(choice.attrs["selected"])
    epsilon = group.children[model]["epsilon_theta"].item() if model in group.children else math.nan
    explained = bool(choice.attrs["explained"])
    return {"model": MODEL_LABELS.get(model, ""), "explained": explained, "epsilon": _number(epsilon)}


def window(record: xr.Dataset, from_s: float, to_s: float, bins: int = BINS) -> Json:
    """The signals of a record between two instants, thinned so that no extreme is lost.

    Parameters
    ----------
    record : Dataset
        Over time [s]: channels, and where it could be processed theta [rad] and flags.
    from_s, to_s : float
        Instants [s].
    bins : int
        Lowest and highest sample of each are kept.

    Returns
    -------
    dict
        signals: label, unit, time, value of each channel; theta: time, value [degree]; flags: start, end [s]
        and what is wrong, of each stretch of invalid samples.
    """
    time = record["time"].values
    first, last = np.searchsorted(time, [from_s, to_s])
    shown = slice(max(0, int(first) - 1), int(last) + 1)
    found: Json = {"signals": [], "theta": None, "flags": []}
    for label, unit, values in _signals(record):
        found["signals"].append({"label": label, "unit": unit} | _thin(time[shown], values[shown], bins))
    if "theta" in record:
        found["theta"] = _thin(time[shown], np.degrees(record["theta"].values[shown]), bins)
        found["flags"] = _flagged(time[shown], record["flags"].values[shown])
    return found


def run_picture(found: Analysed, number: int, block: Block, means: bool = True) -> Json:
    """What the page shows of a run beside its signals.

    Parameters
    ----------
    found : Analysed
        The record's datasets.
    number : int
        Of the run.
    block : Block
    means : bool
        Whether the means of the record's runs are told: what computes them takes half a second to load.

    Returns
    -------
    dict
        JSON: run, release, end, fit_start, hold [s]; facts, texts; impacts by source ("measured" or a
        candidate): time [s], peak [degree], speed [degree/s], r and its standard error; curves by candidate:
        θ [degree] and residual [σ] over the record's time; fits and choice of the run, and the means of the
        record's runs.
    """
    record, fits = found
    run = runs_of(record)[number]
    group = runs_of(fits).get(number) if fits is not None else None
    release, sigma = run["release"].item(), run["sigma_theta"].item()
    verdict = verdict_of_run(number, run, fits)
    models = (
        {} if group is None else {name: group.children[name] for name in MODELS if name in group.children}
    )
    sources = {"measured": (run.dataset, release)} | {
        model: (fit.dataset, 0.0) for model, fit in models.items() if model in _drawn(group, models)
    }
    theta0, stderr = (math.degrees(run[name].item()) for name in ("theta0", "theta0_stderr"))
    return {
        "run": number,
        "release": release,
        "end": run["end"].item(),
        "fit_start": run["fit_start"].item(),
        "hold_start": _number(run["hold_start"].item()),
        "verdict": verdict.level,
        "reasons": [{"verdict": each.verdict, "text": each.text} for each in verdict.reasons],
        "excluded": bool(run.attrs["excluded"]),
        "facts": [
            ["θ₀", f"{quantity(theta0, stderr)}°"],
            ["σ", f"{quantity(math.degrees(sigma), digits=2)}°"],
            ["Impacts", impacts_of(run)],
        ],
        "impacts": {source: _impacts(data, release - own, block) for source, (data, own) in sources.items()},
        "r_housner": block.restitution_housner,
        "curves": {} if group is None else _curves(group, models, release, sigma),
        "fits": fits_of_group(group),
        "means": means_of(fits) if means else None,
    }


def fits_of_group(group: xr.DataTree | None) -> Json | None:
    """The candidates of a run, or of all runs jointly: what the choice made of them, and their numbers."""
    if group is None or GROUP not in group.children:
        return None
    choice = group.children[GROUP]
    data, attrs = choice.dataset, choice.attrs
    candidates = []
    for i, model in enumerate(data["candidate"].values.astype(str)):
        status = str(data["status"].values[i])
        if status == "selected" and not data["explains"].values[i]:
            status = "nearest"
        epsilon = float(data["epsilon_theta"].values[i])
        candidates.append(
            {
                "model": model,
                "label": MODEL_LABELS[model],
                "status": status,
                "says": STATUS_WORDS[status],
                "reason": str(data["reason"].values[i]),
                "epsilon": _number(epsilon),
                "epsilon_text": quantity(100 * epsilon),
                "parameters": _parameters(group.children[model]) if model in group.children else [],
            }
        )
    told: Json = {key: str(attrs[key]) for key in ("reason", "stories") if key in attrs}
    return told | {"candidates": candidates, "selected": str(attrs["selected"])}


def means_of(fits: xr.DataTree | None) -> Json | None:
    """The mean of a record's runs, candidate by candidate, as the table populations has it."""
    from freerock.tables.populations import populations_table
    from freerock.tables.tidy import parameters_table

    if fits is None or len(runs_of(fits)) == 0:
        return None
    table = populations_table(parameters_table([fits]))
    found: dict[str, Json] = {}
    for row in table[table["level"] == "record"].to_dict("records"):
        of = found.setdefault(
            row["model"],
            {"model": row["model"], "label": MODEL_LABELS[row["model"]], "status": "", "reason": ""}
            | {"says": f"{row['n_runs']} runs" if row["n_runs"] > 1 else "1 run", "parameters": []},
        )
        of["parameters"].append(
            _parameter(row["parameter"], row["mean"], row["stderr"], row["unit"])
            | ({"more": f"spread τ = {quantity(row['tau'], digits=2)}"} if math.isfinite(row["tau"]) else {})
        )
    return {"candidates": [*found.values()]} if found else None


def _parameters(fit: xr.DataTree) -> list[Json]:
    data = fit.dataset
    columns = (data[name].values for name in ("parameter", "value", "stderr", "unit"))
    return [_parameter(*row) for row in zip(*columns, strict=True)]


def _parameter(name: str, value: float, stderr: float, unit: str) -> Json:
    """A parameter as shown, and with the digits that tables have."""
    return {
        "name": name,
        "symbol": symbol(name),
        "value": f"{value:.10g}",
        "stderr": f"{stderr:.10g}" if math.isfinite(stderr) else "",
        "text": quantity(value, stderr),
        "unit": unit_text(str(unit)),
    }


def symbol(parameter: str) -> str:
    """Symbol of a parameter; with its number that of an impact, or in a joint fit of a run."""
    kind, _, number = parameter.partition("_")
    return SYMBOLS[kind] + (f" {number}" if number else "")


def _drawn(group: xr.DataTree | None, models: dict[str, xr.DataTree]) -> list[str]:
    """The candidates that are drawn: the laws as the paper has them, and the one that is named."""
    named = group.children[GROUP].attrs["selected"] if group is not None and GROUP in group.children else ""
    return [model for model in models if model in LAWS or not CANDIDATES[model].is_rival or model == named]


def _curves(group: xr.DataTree, models: dict[str, xr.DataTree], release: float, sigma: float) -> Json:
    time = group.dataset["time"].values + release
    curves = {}
    for model in _drawn(group, models):
        fit = models[model].dataset
        curves[model] = {
            "theta": _thin(time, np.degrees(fit["theta_model"].values), BINS),
            "residual": _thin(time, fit["residual"].values / sigma, BINS),
        }
    return curves


def _impacts(data: xr.Dataset, later_s: float, block: Block) -> list[list[float | None]]:
    """Time on the record's clock [s], peak before [degree], speed [degree/s], r and its standard error."""
    if not data.sizes.get("impact", 0):
        return []
    peak = np.abs(data["peak_before"].values)
    columns = (
        data["impact_time"].values + later_s,
        np.degrees(peak),
        np.degrees(impact_speed(peak, block)),
        data["restitution"].values,
        data["restitution_stderr"].values,
    )
    return [[_number(float(each)) for each in row] for row in zip(*columns, strict=True)]


def impact_speed(peak: Floats, block: Block) -> Floats:
    """Angular rate of a rigid block at the impact that follows a peak |θ| [rad/s].

    p √(2 (cos(α − |θ|) − cos α)), from the energy of free rocking (Housner 1963,
    doi:10.1785/BSSA0530020403); α is the critical angle.
    """
    alpha = block.theta_cr
    fall = np.cos(alpha - np.asarray(peak)) - math.cos(alpha)
    return np.asarray(block.p * np.sqrt(2 * np.maximum(fall, 0.0)))


def _signals(record: xr.Dataset) -> Iterator[tuple[str, str, Floats]]:
    """Label, unit and samples of each channel."""
    for name, variable in record.data_vars.items():
        kind, _, second = str(name).partition("_")
        if variable.dims == ("time",) and (kind in BASE or "theta" not in record):
            label = f"{kind} of laser {second}" if second.isdigit() else kind
            yield label, BASE.get(kind) or str(variable.attrs.get("units", "")), variable.values


def _thin(time: Floats, values: Floats, bins: int) -> Json:
    kept = extremes(values, bins)
    return {"t": [round(float(t), 5) for t in time[kept]], "v": [_number(float(v)) for v in values[kept]]}


def _flagged(time: Floats, flags: Any) -> list[list[Any]]:
    """Start, end [s] and what is wrong, of each stretch of invalid samples."""
    bad = np.flatnonzero(flags)
    if not bad.size:
        return []
    near = max(1, len(time) // MOST_FLAGGED)
    parts = np.split(bad, np.flatnonzero(np.diff(bad) > near) + 1)
    found = []
    for part in parts:
        seen = int(np.bitwise_or.reduce(flags[part]))
        told = ", ".join(name.replace("_", " ") for name, bit in FLAGS.items() if seen & bit)
        found.append([float(time[part[0]]), float(time[part[-1]]), told])
    return found


def _number(value: float) -> float | None:
    """A number with as many digits as a screen shows, None where there is none."""
    return float(f"{value:.7g}") if math.isfinite(value) else None
