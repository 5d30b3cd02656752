"""One page per run for quality control: volts, record, run with impacts, residuals of the models."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import MODEL_STYLES, extremes, footer, label, legend_above, styled, thin
from freerock.models.laws import MODELS
from freerock.products.groups import reasons_in, runs_of
from freerock.rotation.faults import listed_faults
from freerock.runs.verdict import in_one_line
from freerock.tables.text import quantity
from freerock.units import BASE

PAGE_DPI = 110
COLUMNS = ["run", "series", "time_s", "value", "unit"]
VERDICT_COLOURS = {"ok": "#00643c", "warn": "#8a5a00", "fail": "#b00020"}


@styled()
def draw(record, fits, labels=None):
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
        One per run; a single one with the reason where the record could not be processed.
    data : pandas.DataFrame
        Columns run (empty: the whole record), series, time_s, value, unit; times on the record's clock, of
        a run since its release.
    """
    runs = runs_of(record)
    if not runs:
        reasons = in_one_line(reasons_in(record.attrs))
        return failed(record, labels, reasons, record.attrs["verdict"])
    title = _title(record, labels)
    whole = _record_series(record)
    fitted = runs_of(fits)
    pages, parts = [], [whole]
    for number, run in runs.items():
        own = _run_series(record, number, run, fitted.get(number))
        pages.append(_page(record, title, number, run, whole, own))
        parts.append(own)
    return pages, pd.concat(parts, ignore_index=True)


def failed(record, labels, reasons, verdict="fail"):
    """The page of a record without runs, or one that can't be drawn: what and why; returns as `draw`."""
    figure = Figure(figsize=(7.0, 2.0), dpi=PAGE_DPI, layout="none")
    _header(figure, _title(record, labels), {"verdict": verdict, "reasons": reasons})
    footer(figure, record.attrs["origin"])
    return [figure], pd.DataFrame(columns=COLUMNS)


def _title(record, labels):
    names = [label(labels, record.attrs[key]) for key in ("block", "foundation")]
    return f"{record.attrs['test']}: {', '.join(names)}"


def _series(run, series, time_s, value, unit):
    return pd.DataFrame({"run": run, "series": series, "time_s": time_s, "value": value, "unit": unit})


def _recorded(record):
    """Name and unit of each channel as recorded: volts, mostly."""
    return {
        f"{quantity}{suffix}": unit
        for quantity, unit in BASE.items()
        for suffix in ("", "_2")
        if f"{quantity}{suffix}" in record.data_vars
    }


def _record_series(record):
    time, flags = record["time"].values, record["flags"].values
    channels = _recorded(record)
    theta = np.degrees(record["theta"].values)
    angles = extremes(theta)
    masks = np.atleast_1d(record["flags"].attrs["flag_masks"])
    meanings = record["flags"].attrs["flag_meanings"].split()
    parts = [_series(pd.NA, "theta", time[angles], theta[angles], "degree")]
    for name, unit in channels.items():
        values = record[name].values
        drawn = extremes(values)
        parts.append(_series(pd.NA, name, time[drawn], values[drawn], unit))
    first, unit = next(iter(channels.items()))
    values = record[first].values
    for mask, meaning in zip(masks, meanings, strict=True):
        flagged = np.flatnonzero(flags & mask)
        flagged = flagged[thin(len(flagged), 300)]
        parts.append(_series(pd.NA, meaning, time[flagged], values[flagged], unit))
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
    attrs = run.attrs | {"reasons": in_one_line(reasons_in(run.attrs))}
    band = _header(figure, f"{title}, run {number}", attrs, _facts(run, sigma_deg), _faults(record))
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
    for ax in (volts, angle, motion):
        ax.locator_params(axis="y", nbins=5)  # half of the time to draw a page goes into ticks
    for ax in (volts, angle, motion, residual):
        ax.locator_params(axis="x", nbins=7)
    release, end = run["release"].item(), run["end"].item()

    channels = _recorded(record)
    colours = dict(zip(channels, ("black", "0.55"), strict=False))
    for series, part in whole.groupby("series", sort=False):
        if series in channels:
            volts.plot(part["time_s"], part["value"], color=colours[series], linewidth=0.6)
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
    quantity, unit = next(iter(channels.items()))
    volts.set_ylabel(f"laser / {unit}" if quantity != "rotation" else "sensor / rad")
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
    noise = {"facecolor": "0.85", "edgecolor": "#f0c000", "linewidth": 0.8, "label": "noise ± 2σ"}
    residual.axhspan(-2 * sigma_deg, 2 * sigma_deg, **noise)
    for edge in (-2 * sigma_deg, 2 * sigma_deg):  # on top: a residual that is noise hides the band
        residual.axhline(edge, color="#f0c000", linewidth=0.8, zorder=3)
    residual.set_yscale("symlog", linthresh=10 ** np.ceil(np.log10(3 * sigma_deg)) if sigma_deg else 0.1)
    residual.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
    residual.set_ylabel("model − measured / °, symlog", fontsize=6.5)
    if not own["series"].str.startswith("residual").any():
        residual.text(0.5, 0.5, "not fitted", transform=residual.transAxes, ha="center", va="center")
    residual.set_xlabel("time since release / s")
    residual.set_xlim(motion.get_xlim())
    legend_above(residual)
    for ax in figure.axes:
        ax.yaxis.set_label_coords(-0.45 / width / (1 - 0.72 / width), 0.5)
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


def _faults(record):
    """What is wrong with the signal of the record, each fault with the first time it occurs."""
    found = {}
    for fault in listed_faults(record):
        found.setdefault(fault.name, []).append(fault)
    texts = []
    for name, each in found.items():
        first = each[0]
        more = f", {len(each) - 1} more" if len(each) > 1 else ""
        when = f"{first.start_s:.2f} to {first.end_s:.2f} s"
        texts.append(f"{name.replace('_', ' ')} {when} ({first.note}){more}")
    return "signal: " + "; ".join(texts) if texts else ""


def _header(figure, title, attrs, facts="", faults=""):
    """Title, verdict, facts, faults and reasons at the top of a page; returns their height [inch]."""
    verdict = attrs["verdict"] + (", excluded" if attrs.get("excluded") else "")
    lines = [(line, "0.3") for line in textwrap.wrap(faults, 115)]
    lines += [(line, VERDICT_COLOURS[attrs["verdict"]]) for line in textwrap.wrap(attrs["reasons"], 115)]
    colour, height = VERDICT_COLOURS[attrs["verdict"]], figure.get_figheight()

    def write(x, inches, text, **style):
        figure.text(x, 1 - inches / height, text, va="top", **style)

    write(0.01, 0.05, title, fontsize=11)
    write(0.99, 0.05, verdict, fontsize=11, ha="right", color=colour)
    write(0.01, 0.28, facts)
    for i, (line, shade) in enumerate(lines):
        write(0.01, 0.44 + 0.14 * i, line, color=shade)
    return 0.44 + 0.14 * len(lines)
