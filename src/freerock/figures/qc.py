"""One page per run for quality control: volts, record, run with impacts, residuals of the models."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import MODEL_STYLES, extremes, footer, label, legend_above, styled, thin
from freerock.models import MODELS
from freerock.tables import quantity, runs_of

PAGE_DPI = 110
COLUMNS = ["run", "series", "time_s", "value", "unit"]
VERDICT_COLOURS = {"ok": "#00643c", "warn": "#8a5a00", "fail": "#b00020"}


@styled()
def qc(record, fits, labels=None):
    """Pages of quality control of one record.

    Parameters
    ----------
    record, fits : xarray.DataTree
        Record and fit dataset of one test.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
        One per run; a single one that tells the reason where the record could not be processed.
    data : pandas.DataFrame
        Columns run (empty: the whole record), series, time_s, value, unit; times on the record's clock, of
        a run since its release.
    """
    names = [label(labels, record.attrs[key]) for key in ("block", "foundation")]
    title = f"{record.attrs['test']}: {', '.join(names)}"
    runs = runs_of(record)
    if not runs:
        return [_failed(record, title)], pd.DataFrame(columns=COLUMNS)
    whole = _record_series(record)
    fitted = runs_of(fits)
    pages, parts = [], [whole]
    for number, run in runs.items():
        own = _run_series(record, number, run, fitted.get(number))
        pages.append(_page(record, title, number, run, whole, own))
        parts.append(own)
    return pages, pd.concat(parts, ignore_index=True)


def _series(run, series, time_s, value, unit):
    return pd.DataFrame({"run": run, "series": series, "time_s": time_s, "value": value, "unit": unit})


def _record_series(record):
    time, volts, flags = (record[name].values for name in ("time", "voltage", "flags"))
    theta = np.degrees(record["theta"].values)
    drawn, angles = extremes(volts), extremes(theta)
    masks = np.atleast_1d(record["flags"].attrs["flag_masks"])
    meanings = record["flags"].attrs["flag_meanings"].split()
    parts = [
        _series(pd.NA, "voltage", time[drawn], volts[drawn], "V"),
        _series(pd.NA, "theta", time[angles], theta[angles], "degree"),
    ]
    for mask, meaning in zip(masks, meanings, strict=True):
        flagged = np.flatnonzero(flags & mask)
        flagged = flagged[thin(len(flagged), 300)]
        parts.append(_series(pd.NA, meaning, time[flagged], volts[flagged], "V"))
    return pd.concat(parts)


def _run_series(record, number, run, fit):
    release, end = run["release"].item(), run["end"].item()
    time, theta = record["time"].values, np.degrees(record["theta"].values)
    during = np.flatnonzero((time >= release - 0.1) & (time <= end))
    during = during[thin(len(during))]
    parts = [_series(number, "theta", time[during] - release, theta[during], "degree")]
    if run.sizes.get("impact", 0):
        impacts = run["impact_time"].values - release
        parts.append(_series(number, "impact", impacts, np.zeros(len(impacts)), "degree"))
    for model in MODELS if fit is not None else ():
        if model in fit.children:
            residual = np.degrees(fit[model]["residual"].values)
            drawn = extremes(residual, 600)
            parts.append(
                _series(number, f"residual_{model}", fit["time"].values[drawn], residual[drawn], "degree")
            )
    return pd.concat(parts)


def _page(record, title, number, run, whole, own):
    sigma_deg = np.degrees(run["sigma_theta"].item())
    width, height = 7.0, 8.4
    figure = Figure(figsize=(width, height), dpi=PAGE_DPI, layout="none")
    band = _header(figure, f"{title}, run {number}", run.attrs, _facts(run, sigma_deg))
    volts, angle, motion, residual = figure.subplots(
        4,
        height_ratios=[1, 1, 1.5, 1.2],
        gridspec_kw={
            "left": 0.6 / width,
            "right": 1 - 0.12 / width,
            "bottom": 0.55 / height,
            "top": 1 - (band + 0.25) / height,
            "hspace": 0.6,
        },
    )
    release, end = run["release"].item(), run["end"].item()

    for series, part in whole.groupby("series", sort=False):
        if series == "voltage":
            volts.plot(part["time_s"], part["value"], color="black", linewidth=0.6)
        elif series == "theta":
            angle.plot(part["time_s"], part["value"], color="black", linewidth=0.6)
        elif len(part):
            volts.plot(
                part["time_s"],
                part["value"],
                "x",
                color="#b00020",
                label=series.replace("_", " "),
                markersize=4,
            )
    for ax in (volts, angle):
        ax.axvspan(release, end, color="#0a5bd3", alpha=0.12, linewidth=0)
        ax.set_xlim(record["time"].values[[0, -1]])
        ax.set_xlabel("time of the record / s")
    volts.set_ylabel("laser / V")
    angle.set_ylabel("θ / °")
    for instant, text, align in ((release, "release ", "right"), (end, " rest", "left")):
        angle.axvline(instant, color="#0a5bd3", linewidth=0.8)
        angle.text(
            instant, 1.0, text, transform=angle.get_xaxis_transform(), ha=align, va="bottom", fontsize=7
        )
    if volts.get_legend_handles_labels()[0]:
        legend_above(volts)

    for series, part in own.groupby("series", sort=False):
        if series == "theta":
            motion.plot(part["time_s"], part["value"], color="black", label="measured")
        elif series == "impact":
            motion.plot(part["time_s"], part["value"], "o", color="#d55e00", markersize=4, label="impact")
        else:
            residual.plot(part["time_s"], part["value"], **MODEL_STYLES[series.removeprefix("residual_")])
    legend_above(motion)
    motion.set_ylabel("θ / °")
    motion.set_xlabel("time since release / s")
    residual.axhspan(-2 * sigma_deg, 2 * sigma_deg, color="0.85", linewidth=0, label="noise ± 2σ")
    residual.set_yscale("symlog", linthresh=10 ** np.ceil(np.log10(3 * sigma_deg)) if sigma_deg else 0.1)
    residual.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
    residual.set_ylabel("residual / °")
    if not own["series"].str.startswith("residual").any():
        residual.text(0.5, 0.5, "not fitted", transform=residual.transAxes, ha="center", va="center")
    residual.set_xlabel("time since release / s")
    residual.set_xlim(motion.get_xlim())
    legend_above(residual)
    figure.align_ylabels()
    footer(figure, record.attrs["origin"])
    return figure


def _facts(run, sigma_deg):
    facts = [
        f"θ₀ = {quantity(*np.degrees([run['theta0'].item(), run['theta0_stderr'].item()]))} °",
        f"σ = {quantity(sigma_deg, digits=2)} °",
        f"release at {quantity(run['release'].item(), run['release_stderr'].item())} s",
        f"{run.sizes.get('impact', 0)} impacts",
    ]
    return "    ".join(facts)


def _header(figure, title, attrs, facts=""):
    """Title, verdict, facts and reasons at the top of a page; returns the height they take [inch]."""
    verdict = attrs["verdict"] + (", excluded" if attrs.get("excluded") else "")
    reasons = textwrap.wrap(attrs["reasons"], 115)
    colour, height = VERDICT_COLOURS[attrs["verdict"]], figure.get_figheight()

    def write(x, inches, text, **style):
        figure.text(x, 1 - inches / height, text, va="top", **style)

    write(0.01, 0.05, title, fontsize=11)
    write(0.99, 0.05, verdict, fontsize=11, ha="right", color=colour)
    write(0.01, 0.28, facts)
    for i, line in enumerate(reasons):
        write(0.01, 0.44 + 0.14 * i, line, color=colour)
    return 0.44 + 0.14 * len(reasons)


def _failed(record, title):
    figure = Figure(figsize=(7.0, 2.0), dpi=PAGE_DPI, layout="none")
    _header(figure, title, record.attrs)
    footer(figure, record.attrs["origin"])
    return figure
