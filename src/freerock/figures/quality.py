"""One page per run for quality control: findings, doubts, fit and record."""

import textwrap
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from freerock.arrays import Floats
from freerock.errors import number_of
from freerock.figures import looks, style
from freerock.figures.style import Axes, Labels, Style, styled
from freerock.models.free_parameters import OF_RECORD, SYMBOLS
from freerock.models.laws import MODEL_LABELS, MODELS, PAPER_MODELS
from freerock.products.contents import (
    CHOICE_GROUP,
    Attrs,
    impacts_of,
    named_in,
    release_angle_of,
    runs_of,
    verdict_of_run,
)
from freerock.products.netcdf_groups import reasons_in
from freerock.rotation.flags import listed_faults
from freerock.runs.verdict import in_one_line
from freerock.tables.number_text import quantity, value_text
from freerock.units import BASE

Pages = tuple[list[Figure], pd.DataFrame]
"""Pages of a record, and the numbers drawn."""
PAGE: Style = {"dpi": 110, "layout": "none"}
WIDTH_IN, HEIGHT_IN = 7.0, 8.4
LEFT_IN, LABEL_IN = 0.76, 0.45  # of the panels, and between the label of an axis and its panel
SIDES = {"left": LEFT_IN / WIDTH_IN, "right": 1 - 0.12 / WIDTH_IN, "hspace": 0.5}  # of the panels
OF_FITS = ("time", "residual", "parameter", "value", "stderr", "u_total", "unit", "epsilon_theta")  # shown
COLUMNS = ["run", "series", "time_s", "value", "unit"]
UNSELECTED = "0.6"  # instead of black
VERDICT_COLOURS = {"ok": "#00643c", "warn": "#8a5a00", "fail": "#b00020", "excluded": "#5a5a5a"}


@styled({"axes.formatter.useoffset": False, "axes.formatter.limits": (-99, 99)})  # no room for them
def draw(record: xr.DataTree, fits: xr.DataTree, labels: Labels = None) -> Pages:
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
        One per run; a single one that gives the reason where the record could not be processed.
    data : pandas.DataFrame
        Columns run (empty: the whole record), series, time_s, value, unit; times on the record's clock, of
        a run since its release.
    """
    runs = runs_of(record)
    if not runs:
        reasons = in_one_line(reasons_in(record.attrs))
        drawn = "time" in record.dataset
        return failed(record, labels, reasons, record.attrs["verdict"], drawn)
    title, fitted, whole = _title(record, labels), runs_of(fits), _record_series(record)
    pages, parts = [], [whole]
    for number, run in runs.items():
        judged, fit = verdict_of_run(number, run, fits), fitted.get(number)
        told = {"verdict": judged.level, "reasons": in_one_line(judged.reasons), "found": _found(fit)}
        told["selected"] = named_in(fit) if fit is not None else ""
        own = _run_series(record, number, run, fit)
        pages.append(_page(record, f"{title}, run {number}", run.attrs | told, run, whole, own))
        parts.append(own)
    return pages, pd.concat(parts, ignore_index=True)


def failed(
    record: xr.DataTree, labels: Labels, reasons: str, verdict: str = "fail", signal: bool = False
) -> Pages:
    """The page of a record without runs, or one that can't be drawn: what and why, perhaps its signal.

    Returns as `draw`.
    """
    height_in = 5.0 if signal else 2.0
    figure = Figure(figsize=(WIDTH_IN, height_in), **PAGE)
    band = _header(figure, _title(record, labels), {"verdict": verdict, "reasons": reasons})
    data = _record_series(record) if signal else pd.DataFrame(columns=COLUMNS)
    if signal:
        angle, volts = figure.subplots(
            2, gridspec_kw=SIDES | {"bottom": 0.11, "top": 0.95 - band / height_in}
        )
        _draw_record(volts, angle, record, data)
    style.footer(figure, record.attrs["origin"])
    return [figure], data


def _title(record: xr.DataTree, labels: Labels) -> str:
    names = style.label(labels, record.attrs["block"], record.attrs["foundation"])
    return f"{record.attrs['test']}: {names}"


def _series(run: Any, series: str, time_s: Floats, value: Floats, unit: str) -> pd.DataFrame:
    return pd.DataFrame({"run": run, "series": series, "time_s": time_s, "value": value, "unit": unit})


def _recorded(record: xr.DataTree) -> dict[str, str]:
    """Name and unit of each channel as recorded: volts, mostly."""
    names = {f"{name}{suffix}": unit for name, unit in BASE.items() for suffix in ("", "_2")}
    return {name: unit for name, unit in names.items() if name in record.data_vars}


def _record_series(record: xr.DataTree) -> pd.DataFrame:
    time, flags = record.dataset["time"].values, record.dataset["flags"]
    signals = {"theta": (np.degrees(record.dataset["theta"].values), "degree")}
    signals |= {name: (record.dataset[name].values, unit) for name, unit in _recorded(record).items()}
    parts = []
    for name, (values, unit) in signals.items():
        drawn = looks.extremes(values)
        parts.append(_series(pd.NA, name, time[drawn], values[drawn], unit))
    values, unit = signals[next(iter(_recorded(record)))]
    masks = np.atleast_1d(flags.attrs["flag_masks"])
    for mask, meaning in zip(masks, flags.attrs["flag_meanings"].split(), strict=True):
        flagged = np.flatnonzero(flags.values & mask)
        flagged = flagged[style.thin(len(flagged), 300)]
        parts.append(_series(pd.NA, meaning, time[flagged], values[flagged], unit))
    return pd.concat(parts)


def _run_series(record: xr.DataTree, number: int, run: xr.DataTree, fit: xr.DataTree | None) -> pd.DataFrame:
    release, end = run.dataset["release"].item(), run.dataset["end"].item()
    time, theta = record.dataset["time"].values, np.degrees(record.dataset["theta"].values)
    during = np.flatnonzero((time >= release - 0.1) & (time <= end))
    during = during[style.thin(len(during))]
    parts = [_series(number, "theta", time[during] - release, theta[during], "degree")]
    if run.sizes.get("impact", 0):
        impacts = run.dataset["impact_time"].values - release
        parts.append(_series(number, "impact", impacts, np.zeros(len(impacts)), "degree"))
    for model in _drawn_models(fit):
        assert fit is not None
        residual = np.degrees(fit.children[model].dataset["residual"].values)
        drawn = looks.extremes(residual, 350)
        time_s = fit.dataset["time"].values[drawn]
        parts.append(_series(number, f"residual_{model}", time_s, residual[drawn], "degree"))
    return pd.concat(parts)


def _drawn_models(fit: xr.DataTree | None) -> list[str]:
    """The laws of the paper, of the other candidates that with the least ε_θ, and last the selected one."""
    if fit is None:
        return []
    selected = named_in(fit)
    fitted = [model for model in MODELS if model in fit.children and model != selected]
    epsilon = {model: fit.children[model]["epsilon_theta"].item() for model in fitted}
    known = {model: each for model, each in epsilon.items() if model not in PAPER_MODELS and each >= 0}
    rival = min(known, key=known.__getitem__, default="")
    drawn = [model for model in fitted if model in PAPER_MODELS or model == rival]
    return [*drawn, selected] if selected in fit.children else drawn


def _page(
    record: xr.DataTree, title: str, attrs: Attrs, run: xr.DataTree, whole: pd.DataFrame, own: pd.DataFrame
) -> Figure:
    """The run, the residuals, then the record with the run marked in it, and its signal."""
    sigma_deg = float(np.degrees(run.dataset["sigma_theta"].item()))
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), **PAGE)
    band = _header(figure, title, attrs, _facts(run, sigma_deg), _faults(record))
    sides = SIDES | {"bottom": 0.55 / HEIGHT_IN, "top": 1 - (band + 0.25) / HEIGHT_IN}
    motion, residual, angle, volts = figure.subplots(4, height_ratios=[1.5, 1.2, 1, 1], gridspec_kw=sides)
    for ax in (volts, angle, motion):
        ax.locator_params(axis="y", nbins=5)  # half of the time to draw a page goes into ticks
    for ax in (volts, angle, motion, residual):
        ax.locator_params(axis="x", nbins=7)
    _draw_motion(motion, own, record.attrs["origin"])
    _draw_residuals(residual, own, sigma_deg, attrs["selected"])
    if own["series"].str.startswith("residual").any():
        _draw_noise(residual, sigma_deg)
        _legend(residual)
    else:
        residual.text(0.5, 0.5, "not fitted", transform=residual.transAxes, ha="center", va="center")
        residual.set(yticks=[], ylabel="residual / σ")
    residual.set(xlabel="time since release / s", xlim=motion.get_xlim())
    _draw_record(volts, angle, record, whole, (run.dataset["release"].item(), run.dataset["end"].item()))
    for ax in figure.axes:
        ax.yaxis.set_label_coords(-LABEL_IN / WIDTH_IN / ax.get_position().width, 0.5)
        ax.xaxis.set_label_coords(0.5, -0.25 / HEIGHT_IN / ax.get_position().height)
    style.footer(figure, record.attrs["origin"])
    return figure


def _draw_record(
    volts: Axes,
    angle: Axes,
    record: xr.DataTree,
    whole: pd.DataFrame,
    span: tuple[float, float] | tuple[()] = (),
) -> None:
    """The channels as recorded with their flags, θ(t), and where the run lies in them."""
    channels = _recorded(record)
    colours = dict(zip(channels, ("black", "0.55"), strict=False))
    flag: Style = {"color": "#b00020", "markersize": 4}
    for series, part in whole.groupby("series", sort=False):
        if series in channels:
            volts.plot(part["time_s"], part["value"], color=colours[series], linewidth=0.6)
        elif series == "theta":
            angle.plot(part["time_s"], part["value"], color="black", linewidth=0.6)
        elif len(part):
            volts.plot(part["time_s"], part["value"], "x", label=str(series).replace("_", " "), **flag)
    for ax in (volts, angle):
        if span:
            ax.axvspan(*span, color="#0a5bd3", alpha=0.12, linewidth=0)
        ax.set_xlim(record.dataset["time"].values[[0, -1]])
    angle.tick_params(labelbottom=False)
    channel, unit = next(iter(channels.items()))
    sensor = "sensor" if channel == "rotation" else "laser"
    volts.set(xlabel="time of the record / s", ylabel=f"{sensor} / {unit}")
    angle.set_ylabel("θ / °")
    for instant, text, align in zip(span, ("release ", " rest"), ("right", "left"), strict=False):
        angle.axvline(instant, color="#0a5bd3", linewidth=0.8)
        above = {"transform": angle.get_xaxis_transform(), "va": "bottom", "fontsize": 7}
        angle.text(instant, 1.0, text, ha=align, **above)
    if volts.get_legend_handles_labels()[0]:
        _legend(volts)


def _draw_motion(motion: Axes, own: pd.DataFrame, origin: str) -> None:
    """θ(t) since the release with its impacts."""
    theta, impacts = (own[own["series"] == series] for series in ("theta", "impact"))
    motion.plot(theta["time_s"], theta["value"], color="black", label=origin)
    if len(impacts):
        at_impacts: Style = {"color": "#d55e00", "markersize": 4, "label": "impact with r"}
        motion.plot(impacts["time_s"], impacts["value"], "o", **at_impacts)
    _legend(motion)
    motion.set_ylabel("θ / °")
    motion.tick_params(labelbottom=False)  # as of the residuals below; texts take most of the time


def _draw_residuals(residual: Axes, own: pd.DataFrame, sigma_deg: float, selected: str) -> None:
    """The residuals of laws over the noise; the selected one is black, solid and on top."""
    for series, part in own[own["series"].str.startswith("residual")].groupby("series", sort=False):
        model = str(series).removeprefix("residual_")
        look = looks.MODEL_STYLES[model]
        if model == selected:
            look = look | {"color": "black", "linestyle": "-", "label": f"{look['label']} (selected)"}
        elif look["color"] == "black":
            look = look | {"color": UNSELECTED}
        residual.plot(part["time_s"], part["value"] / (sigma_deg or 1.0), **look)


def _legend(ax: Axes) -> None:
    """Above the panel's right corner, clear of the curves."""
    columns = style.legend_columns(ax.get_legend_handles_labels()[1], 0.93)
    at: Style = {"loc": "lower right", "bbox_to_anchor": (1, 1), "borderaxespad": 0.2}
    ax.legend(ncols=columns, labelspacing=0.3, **at)


def _draw_noise(residual: Axes, sigma_deg: float) -> None:
    """The band of the noise; beyond it the scale is logarithmic. Without noise the residual is in °."""
    if not sigma_deg:
        residual.set_ylabel("residual / °\nlog beyond ±0.1")
        residual.set_yscale("symlog", linthresh=0.1)
        residual.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
        return
    residual.set_ylabel(f"residual / σ\nlog beyond ±{style.LINEAR:g}")
    style.scale_by_noise(residual, float(np.abs(residual.dataLim.intervaly).max()))


def _found(run: xr.DataTree | None) -> str:
    """The candidate selected for a run with its parameters, and why, in the words of the choice."""
    if run is None:
        return "Selected: none, not fitted"
    model = named_in(run)
    if not model:
        return "Selected: none"
    fit = run.children[model].dataset
    sure = "u_total" if "u_total" in fit else "stderr"
    columns = (fit[key].values.tolist() for key in ("parameter", "value", sure, "unit"))
    told = [
        f"{SYMBOLS[name]} = {value_text(value, u, unit)}"
        for name, value, u, unit in zip(*columns, strict=True)
        if name in MODELS[model] or name in OF_RECORD
    ]
    told.append(f"ε_θ of this fit = {quantity(100 * fit['epsilon_theta'].item())} %")
    told.append("± total uncertainty" if sure == "u_total" else "± noise alone")
    whole = ", ".join(each.replace(" ", "\N{NO-BREAK SPACE}") for each in told)
    return f"Selected: {MODEL_LABELS[model]}: {whole}. {run.children[CHOICE_GROUP].attrs['reason']}"


def _facts(run: xr.DataTree, sigma_deg: float) -> str:
    release = quantity(run["release"].item(), run["release_stderr"].item())
    angle, sigma = quantity(*release_angle_of(run)), quantity(sigma_deg, digits=2)
    return f"α = {angle}°; σ = {sigma}°; release at {release} s; {impacts_of(run)}"


def _faults(record: xr.DataTree) -> str:
    """What is wrong with the signal of the record, each fault with the first time it occurs."""
    faults = listed_faults(record)
    counts, texts = Counter(each.name for each in faults), []
    for name, n in counts.items():
        first = next(each for each in faults if each.name == name)
        more = f", {number_of(n - 1, 'more time')}" if n > 1 else ""
        when = f"{first.start_s:.2f} to {first.end_s:.2f} s"
        texts.append(f"{name.replace('_', ' ')} {when} ({first.note}){more}")
    return "Signal: " + "; ".join(texts) if texts else ""


def _header(figure: Figure, title: str, attrs: Mapping[Any, Any], facts: str = "", faults: str = "") -> float:
    """Title, verdict, what was found, what is doubtful, faults at the top of a page; their height [inch]."""
    verdict = attrs["verdict"] + (", excluded" if attrs.get("excluded") else "")
    colour = VERDICT_COLOURS["excluded" if attrs.get("excluded") else attrs["verdict"]]
    heading = "Failed" if attrs["verdict"] == "fail" else "Doubtful"
    doubtful = f"{heading}: {attrs['reasons']}" if attrs["reasons"] else "No check found a doubt"
    told = ((attrs.get("found", ""), "black"), (facts, "black"), (doubtful, colour), (faults, "0.3"))
    lines = [(line, shade) for text, shade in told for line in textwrap.wrap(text, 115)]
    height = figure.get_figheight()

    def write(x: float, inches: float, text: str, **look: Any) -> None:
        set_text = text.replace("$", r"\$").replace("ε_θ", "$ε_θ$")
        figure.text(x, 1 - inches / height, set_text, va="top", **look)

    write(0.01, 0.05, title, fontsize=11)
    write(0.99, 0.05, verdict, fontsize=11, ha="right", color=colour)
    for i, (line, shade) in enumerate(lines):
        write(0.01, 0.28 + 0.15 * i, line, color=shade)
    return 0.28 + 0.15 * len(lines)
