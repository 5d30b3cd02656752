"""The report of a campaign: one HTML file that opens without internet."""

import base64
import math
import struct
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from freerock.datasets import atomic
from freerock.models.housner import housner_lobes
from freerock.tables import MODEL_LABELS, SIMULATED_NOTE, fits_of, fixed, quantity

SETTINGS = ["test", "run", "model", "success", "message", "rtol", "integrator_error"]
SETTINGS += ["averaged", "residual_over_sigma", "coloured", "white"]
COMPARISON = ["test", "r_fitted", "r_fitted_stderr", "r_first", "r_median", "r_low", "r_high"]
COMPARISON += ["first_impact_s", "rigid_s"]


def write_report(
    path,
    *,
    title,
    summary,
    origin,
    runs,
    parameters,
    epsilon,
    choice,
    restitution,
    fits,
    blocks,
    tables,
    figures,
    pages,
    labels=None,
    debonding="geometric",
    provenance=None,
):
    """Write the report of a campaign.

    Parameters
    ----------
    path : path-like
        HTML file to write; replaced in one step.
    title, summary : str
        Of the campaign.
    origin : str
        "simulated" or "measured".
    runs, parameters, epsilon, choice, restitution : pandas.DataFrame
        The tidy tables of the campaign (`freerock.tables`).
    fits : iterable of xarray.DataTree
        Fit datasets, for the numerical settings.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    tables : sequence of (str, pandas.DataFrame, sequence of str)
        Caption, printed cells and footnotes of each table to show.
    figures : sequence of (str, path-like)
        Caption and PNG file of each figure to show.
    pages : mapping of str to path-like
        PNG file of the quality pages by record.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    debonding : str
        "geometric" or "tensionless", as the fits used it.
    provenance : mapping, optional
        What made the products; shown as it is, nested mappings and lists included.
    """
    labels = labels or {}
    compared = restitution_comparison(runs, parameters, restitution, blocks)
    settings = fit_settings(fits)
    rows = _run_rows(runs, epsilon, labels, pages)
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined
    )
    html = environment.get_template("report.html.j2").render(
        title=title,
        summary=summary,
        simulated=origin == "simulated",
        simulated_note=SIMULATED_NOTE,
        counts=_counts(runs),
        runs=rows,
        reasons=[row for row in rows if row["reasons"]],
        tables=tables,
        choice=_choice_text(choice, labels),
        figures=[_image(caption, file) for caption, file in figures],
        pages=[_pages(test, file, rows) for test, file in pages.items()],
        comparison=_comparison_text(compared),
        facts=_facts(runs, settings, compared, blocks),
        debonding=debonding,
        settings=_settings_text(settings),
        provenance=[(key, list(_flat(value))) for key, value in (provenance or {}).items()],
    )
    with atomic(path) as part:
        Path(part).write_text(html, encoding="utf-8")


def restitution_comparison(runs, parameters, restitution, blocks) -> pd.DataFrame:
    """Restitution of the fitted Housner model beside that of the impacts, and the time to the first impact.

    Parameters
    ----------
    runs, parameters, restitution : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    pandas.DataFrame
        One row per record with measured impacts: test, r_fitted and its standard error (joint fit of the
        runs), r_first, the mean r of the runs' first impacts, r_median, r_low and r_high, median and range of
        all impacts, first_impact_s, the mean time from release to the first impact, rigid_s, the mean time of
        a rigid block from the same angles.
    """
    rows = []
    measured = restitution[restitution["source"] == "experiment"]
    for test, impacts in measured.groupby("test", sort=False):
        fitted = parameters[
            (parameters["test"] == test) & (parameters["run"] == "pooled") & (parameters["parameter"] == "r")
        ]
        own = runs[runs["test"] == test]
        block = blocks[own["block"].iloc[0]]
        rigid = [
            housner_lobes(block, 1.0, math.radians(abs(angle)), max_impacts=1).impact_time[0]
            for angle in own["theta0_deg"]
            if abs(angle) < math.degrees(block.theta_cr)
        ]
        rows.append(
            {
                "test": test,
                "r_fitted": fitted["value"].mean(),
                "r_fitted_stderr": fitted["stderr"].mean(),
                "r_first": impacts[impacts["impact"] == 1]["r"].mean(),
                "r_median": impacts["r"].median(),
                "r_low": impacts["r"].min(),
                "r_high": impacts["r"].max(),
                "first_impact_s": impacts[impacts["impact"] == 1]["time_s"].mean(),
                "rigid_s": sum(rigid) / len(rigid) if rigid else math.nan,
            }
        )
    return pd.DataFrame(rows, columns=COMPARISON)


def fit_settings(fits) -> pd.DataFrame:
    """Integrator and sampling of the fits.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        One row per fit: test, run, model, message, success and the diagnostics kept with it (those of
        `freerock.identify.Fit`).
    """
    rows = [
        {**fit.attrs, "test": tree.attrs["test"], "run": run, "model": model, "success": bool(fit["success"])}
        for tree in fits
        for run, model, fit in fits_of(tree)
    ]
    return pd.DataFrame(rows, columns=SETTINGS)


def _counts(runs) -> str:
    def number(n, noun):
        return f"{n} {noun}{'' if n == 1 else 's'}"

    found = runs["run"].notna()
    verdicts = ", ".join(f"{n} {verdict}" for verdict, n in runs["verdict"].value_counts(sort=False).items())
    lost = (~found & (runs["verdict"] == "fail")).sum()
    lost = f" {number(lost, 'record')} could not be processed." if lost else ""
    records = number(runs["test"].nunique(), "record")
    return f"{records} with {number(found.sum(), 'free-rocking run')}; verdicts: {verdicts}.{lost}"


def _run_rows(runs, epsilon, labels, pages) -> list:
    chosen = epsilon[epsilon["selected"].astype(bool)]
    best = {(test, str(run)): model for test, run, model in chosen[["test", "run", "model"]].values}
    rows = []
    for run in runs.itertuples():
        number = "–" if pd.isna(run.run) else str(run.run)
        rows.append(
            {
                "test": run.test,
                "anchor": _anchor(run.test, number) if run.test in pages else "",
                "run": number,
                "block": labels.get(run.block, run.block),
                "foundation": labels.get(run.foundation, run.foundation),
                "verdict": run.verdict,
                "theta0": fixed(run.theta0_deg, 3),
                "start": fixed(run.start_s, 3),
                "duration": fixed(run.duration_s, 2),
                "impacts": str(run.n_impacts),
                "sigma": quantity(run.sigma_theta_deg, digits=2),
                "selected": MODEL_LABELS.get(best.get((run.test, number)), "–"),
                "reasons": run.reasons,
            }
        )
    return rows


def _choice_text(choice, labels) -> pd.DataFrame:
    rows = list(choice.itertuples())
    return pd.DataFrame(
        {
            "Record": [row.test for row in rows],
            "Run": ["all" if row.run == "pooled" else str(row.run) for row in rows],
            "Block": [labels.get(row.block, row.block) for row in rows],
            "Foundation": [labels.get(row.foundation, row.foundation) for row in rows],
            "Model": [MODEL_LABELS.get(row.model, "–") for row in rows],
            "Reason": [row.reason for row in rows],
        }
    )


def _anchor(test, run) -> str:
    return f"qc-{test}" + ("" if run == "–" else f"-{run}")


def _image(caption, file) -> dict:
    data = Path(file).read_bytes()
    width, height = struct.unpack(">II", data[16:24])  # in the header of every PNG
    return {"caption": caption, "data": base64.b64encode(data).decode(), "width": width, "height": height}


def _pages(test, file, rows) -> dict:
    """The image of a record's quality pages, and where in it the page of each run lies."""
    image, own = _image(test, file), [row["run"] for row in rows if row["test"] == test]
    height = image["height"] / len(own)
    pages = [
        {
            "anchor": _anchor(test, run),
            "caption": test + ("" if run == "–" else f", run {run}"),
            "top": f"{i * height:g}",
            "height": f"{height:g}",
        }
        for i, run in enumerate(own)
    ]
    return {**image, "test": test, "pages": pages}


def _flat(value, key=""):
    """Nested mappings and lists as pairs of dotted key and text; what is empty is left out."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _flat(inner, f"{key}.{name}" if key else name)
    elif isinstance(value, list | tuple) and any(isinstance(inner, Mapping) for inner in value):
        for i, inner in enumerate(value, 1):
            yield from _flat(inner, f"{key}.{i}")
    elif isinstance(value, list | tuple):
        yield from _flat(", ".join(map(str, value)), key)
    elif value not in (None, ""):
        yield key, str(value)


def _comparison_text(compared) -> pd.DataFrame:
    rows = list(compared.itertuples())
    return pd.DataFrame(
        {
            "Record": [row.test for row in rows],
            "Housner r, fitted": [quantity(row.r_fitted, row.r_fitted_stderr) for row in rows],
            "r, first impact": [fixed(row.r_first, 3) for row in rows],
            "r per impact, median": [fixed(row.r_median, 3) for row in rows],
            "Range": [f"{row.r_low:.3f} to {row.r_high:.3f}" for row in rows],
            "First impact / s": [fixed(row.first_impact_s, 4) for row in rows],
            "First impact, rigid / s": [fixed(row.rigid_s, 4) for row in rows],
        }
    )


def _facts(runs, settings, compared, blocks) -> dict:
    """Numbers of the report's sentences, as text."""
    shifts_mm = [
        500 * blocks[run.block].width_m * (1 - math.cos(math.radians(run.theta0_deg)))
        for run in runs.dropna(subset=["theta0_deg"]).itertuples()
    ]
    known = compared.dropna(subset=["r_fitted", "first_impact_s", "rigid_s"])
    later = 100 * (known["first_impact_s"] / known["rigid_s"] - 1)
    integrated = settings[settings["model"] != "housner"]
    return {
        "shift_mm": quantity(max(shifts_mm, default=math.nan), digits=2),
        "latest": _later(later.max()),
        "earliest": _later(later.min()),
        "some_earlier": bool((later < 0).any()),
        "n_above": int((known["r_fitted"] > known["r_first"]).sum()),
        "n_known": len(known),
        "n_integrated": len(integrated),
        "rtol_low": f"{integrated['rtol'].min():g}",
        "rtol_high": f"{integrated['rtol'].max():g}",
        "error_percent": quantity(100 * integrated["integrator_error"].max(), digits=2),
    }


def _later(percent) -> str:
    return f"{fixed(abs(percent), 1)} % {'later' if percent > 0 else 'earlier'}"


def _settings_text(settings) -> pd.DataFrame:
    rows = list(settings.itertuples())
    return pd.DataFrame(
        {
            "Record": [row.test for row in rows],
            "Run": [str(row.run) for row in rows],
            "Model": [MODEL_LABELS[row.model] for row in rows],
            "Tolerance": ["closed form" if row.model == "housner" else f"{row.rtol:g}" for row in rows],
            "Integrator's shift / % of s.e.": [
                quantity(100 * row.integrator_error, digits=2) for row in rows
            ],
            "Samples averaged": [f"{row.averaged:.0f}" for row in rows],
            "Residual / σ": [quantity(row.residual_over_sigma) for row in rows],
            "Residual is": [
                "coloured" if row.coloured else "white" if row.white else "not quite white" for row in rows
            ],
            "Outcome": [row.message for row in rows],
        }
    )
