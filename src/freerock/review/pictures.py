"""What the page draws and lists of a record, as plain numbers and texts: JSON, angles in degrees."""

import math

import numpy as np
import xarray as xr

from freerock.arrays import Floats
from freerock.errors import number_of
from freerock.models.block import Block
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import CANDIDATES, LAWS, MODEL_LABELS, MODELS
from freerock.products.contents import (
    CHOICE_GROUP,
    EXPLAINED,
    impacts_of,
    named_in,
    release_angle_of,
    runs_of,
    verdict_of_run,
)
from freerock.review.listing import lines_of_runs
from freerock.review.reprocessing import Analysed
from freerock.review.signals import Json, screen_digits, thinned
from freerock.tables.choices import STATUS_WORDS
from freerock.tables.number_text import quantity, unit_text


def lines_of_record(test: str, found: Analysed) -> list[Json]:
    """The lines of a record in the list of runs: one for each run, or one for a record without any."""
    from freerock.tables.tidy_tables import choice_table, epsilon_table, runs_table

    record, fits = found
    known = [fits] if fits is not None else []
    return lines_of_runs(runs_table([record], known), choice_table(known), epsilon_table(known))[test]


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
        Whether the means of the record's runs are shown: what computes them takes half a second to load.

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
    drawn = {} if group is None else _drawn(group)
    sources: dict[str, tuple[xr.Dataset, float]] = {"measured": (run.dataset, release)}
    sources |= {model: (fit, 0.0) for model, fit in drawn.items()}
    return {
        "run": number,
        "release": release,
        "end": run["end"].item(),
        "fit_start": run["fit_start"].item(),
        "hold_start": screen_digits(run["hold_start"].item()),
        "verdict": verdict.level,
        "reasons": [{"verdict": each.verdict, "text": each.text} for each in verdict.reasons],
        "excluded": bool(run.attrs["excluded"]),
        "facts": [
            ["α", f"{quantity(*release_angle_of(run))}°"],
            ["σ", f"{quantity(math.degrees(sigma), digits=2)}°"],
            ["Motion", impacts_of(run)],
        ],
        "impacts": {source: _impacts(data, release - own, block) for source, (data, own) in sources.items()},
        "r_housner": block.restitution_housner,
        "curves": {
            model: {
                "theta": thinned(fit["time"].values + release, np.degrees(fit["theta_model"].values)),
                "residual": thinned(fit["time"].values + release, fit["residual"].values / sigma),
            }
            for model, fit in drawn.items()
        },
        "fits": fits_of_group(group),
        "means": means_of(fits) if means else None,
    }


def fits_of_group(group: xr.DataTree | None) -> Json | None:
    """The candidates of a run, or of all runs jointly: what the choice made of them, and their numbers."""
    if group is None or CHOICE_GROUP not in group.children:
        return None
    choice = group.children[CHOICE_GROUP]
    data, attrs = choice.dataset, choice.attrs
    candidates = []
    for i, model in enumerate(data["candidate"].values.astype(str)):
        status = str(data["status"].values[i])
        if status == "selected" and attrs["level"] not in EXPLAINED:
            status = "nearest"
        fitted = group.children[model].dataset if model in group.children else {}
        epsilon = float(fitted["epsilon_theta"]) if "epsilon_theta" in fitted else math.nan
        candidates.append(
            {
                "model": model,
                "label": MODEL_LABELS[model],
                "status": status,
                "says": STATUS_WORDS[status],
                "reason": str(data["reason"].values[i]),
                "epsilon": screen_digits(epsilon),
                "epsilon_text": quantity(100 * epsilon),
                "parameters": _parameters(group.children[model]) if model in group.children else [],
            }
        )
    told: Json = {key: str(attrs[key]) for key in ("reason", "level") if key in attrs}
    return told | {"candidates": candidates, "selected": str(attrs["selected"])}


def means_of(fits: xr.DataTree | None) -> Json | None:
    """The mean of a record's runs, candidate by candidate, as in the table populations."""
    from freerock.tables.populations import means_in, populations_table
    from freerock.tables.tidy_tables import contributions_table, parameters_table

    if fits is None or len(runs_of(fits)) == 0:
        return None
    table = populations_table(means_in(parameters_table([fits]), contributions_table([fits])))
    found: dict[str, Json] = {}
    for row in table[table["level"] == "record"].to_dict("records"):
        of = found.setdefault(
            row["model"],
            {"model": row["model"], "label": MODEL_LABELS[row["model"]], "status": "", "reason": ""}
            | {"says": number_of(row["n_runs"], "run"), "parameters": []},
        )
        of["parameters"].append(
            _parameter(row["parameter"], row["mean"], row["u_total"], row["unit"])
            | ({"more": f"spread τ = {quantity(row['tau'], digits=2)}"} if math.isfinite(row["tau"]) else {})
        )
    return {"candidates": [*found.values()]} if found else None


def _parameters(fit: xr.DataTree) -> list[Json]:
    data = fit.dataset
    columns = (data["parameter"].values, data["value"].values, data["u_total"].values, data["unit"].values)
    return [_parameter(*row) for row in zip(*columns, strict=True)]


def _parameter(name: str, value: float, u: float, unit: str) -> Json:
    """A parameter with its total standard uncertainty as shown, and with the digits that tables have."""
    return {
        "name": name,
        "symbol": SYMBOLS[name],
        "value": f"{value:.10g}",
        "u": f"{u:.10g}" if math.isfinite(u) else "",
        "text": quantity(value, u),
        "unit": unit_text(str(unit)),
    }


def _drawn(group: xr.DataTree) -> dict[str, xr.Dataset]:
    """The fits that are drawn: of the laws as the paper has them, and of the candidate that is named."""
    named, fits = named_in(group), group.children
    shown = [each for each in MODELS if each in LAWS or not CANDIDATES[each].is_rival or each == named]
    return {model: fits[model].dataset for model in shown if model in fits}


def _impacts(data: xr.Dataset, later_s: float, block: Block) -> list[list[float | None]]:
    """Time on the record's clock [s], peak before [degree], speed [degree/s], r and its uncertainty.

    r is that by energy of a law, that of the peaks as seen of what was measured.
    """
    if not data.sizes.get("impact", 0):
        return []
    unknown, peak = np.full(data.sizes["impact"], np.nan), np.abs(data["peak_before"].values)
    names = ("restitution", "restitution_stderr")
    names = ("restitution_energy", "restitution_energy_u") if "delta" in data else names
    r, u = (data[name].values if name in data else unknown for name in names)
    columns = (
        data["impact_time"].values + later_s,
        np.degrees(peak),
        np.degrees(impact_speed(peak, block)),
        r,
        u,
    )
    return [[screen_digits(float(each)) for each in row] for row in zip(*columns, strict=True)]


def impact_speed(peak: Floats, block: Block) -> Floats:
    """Angular rate of a rigid block at the impact that follows a peak |θ| [rad/s].

    p √(2 (cos(θ_cr − |θ|) − cos θ_cr)), from the energy of free rocking (Housner 1963,
    doi:10.1785/BSSA0530020403).
    """
    theta_cr = block.theta_cr
    fall = np.cos(theta_cr - np.asarray(peak)) - math.cos(theta_cr)
    return np.asarray(block.p * np.sqrt(2 * np.maximum(fall, 0.0)))
