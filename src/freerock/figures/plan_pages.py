"""The plan of a campaign: predicted standard errors, and differences between rivals."""

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator, ScalarFormatter

from freerock.figures import style
from freerock.figures.style import Labels, Style, styled
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.tables.plan_text import best_known

BLOCK_STYLES: tuple[Style, ...] = (
    {"color": "black", "marker": "o"},
    {"color": "#0072b2", "marker": "s"},
    {"color": "#d55e00", "marker": "D"},
    {"color": "#00805e", "marker": "^"},
    {"color": "#9a4d83", "marker": "v"},
)
RATE_LINES = ("-", "--", ":", "-.")
BELOW = 10.0  # least total uncertainty of a panel over its foot: smaller parts by inputs are not seen


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """Relative standard errors over the release angle: a page per sensor and duration.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan.plan`.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn, with the standard error in per cent of the value.
    """
    frame = frame.assign(percent=(100 * frame["stderr"] / frame["value"]).replace(np.inf, np.nan))
    pages = [
        _page(frame, rows, f"Predicted by noise alone with {sensor}, {duration:g} s from the release", labels)
        for (sensor, duration), rows in frame.groupby(["sensor", "duration_s"], sort=False)
    ]
    return pages, frame


def _page(frame: pd.DataFrame, rows: pd.DataFrame, title: str, labels: Labels) -> Figure:
    """Panels with the axes of the whole frame, so that pages compare."""
    blocks = dict(zip(frame["block"].unique(), cycle(BLOCK_STYLES)))
    rates = dict(zip(sorted(frame["sampling_rate_hz"].unique()), cycle(RATE_LINES)))
    limits = frame.groupby(["model", "parameter"], sort=False)["percent"].agg(["min", "max"])
    expected = {
        name: [key for key in limits.index if key in set(zip(own["model"], own["parameter"], strict=True))]
        for name, own in frame.groupby("foundation", sort=False)
    }
    figure = Figure(figsize=(7.0, 0.9 + 1.5 * len(expected)))
    places = figure.add_gridspec(len(expected), max(map(len, expected.values())))
    shown = list(expected.values())
    for i, (foundation, parameters) in enumerate(expected.items()):
        for j, (model, parameter) in enumerate(parameters):
            ax = figure.add_subplot(places[i, j], xlim=(0, 1.1 * frame["release_angle_deg"].max()))
            above, below = shown[i - 1] if i else [], shown[i + 1] if i + 1 < len(shown) else []
            if above[j : j + 1] != [(model, parameter)]:
                ax.set_title(f"{MODEL_LABELS[model]} {SYMBOLS[parameter]}", loc="left")
            if below[j : j + 1] == [(model, parameter)]:
                ax.tick_params(labelbottom=False)
            low, high = limits.loc[(model, parameter)]
            if low > 0:
                ax.set(yscale="log", ylim=(low / 1.5, high * 1.5))
            here = (rows["foundation"] == foundation) & (rows["model"] == model)
            one = rows[here & (rows["parameter"] == parameter)].sort_values("release_angle_deg")
            for (block, _, rate), curve in one.groupby(["block", "laser", "sampling_rate_hz"]):
                ax.plot(curve["release_angle_deg"], curve["percent"], linestyle=rates[rate], **blocks[block])
            if j == 0:
                ax.set_ylabel(f"{style.label(labels, foundation)}\nstandard error / %")
            if all(j >= len(others) for others in shown[i + 1 :]):
                ax.set_xlabel("release angle / °")
    more = [{"linestyle": line, "label": f"{rate:g} Hz"} for rate, line in rates.items()]
    return _headed(figure, title, blocks, labels, more)


def _headed(
    figure: Figure, title: str, blocks: Mapping[str, Style], labels: Labels, more: Sequence[Style]
) -> Figure:
    """A page with its title, and a legend of the blocks and of further lines."""
    handles = [Line2D([], [], **look, label=style.label(labels, name)) for name, look in blocks.items()]
    handles += [Line2D([], [], color="0.3", **look) for look in more]
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 6))
    figure.suptitle(title, x=0.01, ha="left", fontsize=9, weight="bold")
    return figure


@styled()
def draw_rivals(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """How far each rival stays from an expected model, over the release angle: a page per model.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan.plan_rivals`; not empty.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn, with ε_θ in per cent.
    """
    frame = frame.assign(epsilon_percent=100 * frame["epsilon_theta"])
    groups = frame.groupby("model", sort=False)
    return [_rivals_page(frame, rows, labels) for _, rows in groups], frame


def _rivals_page(frame: pd.DataFrame, rows: pd.DataFrame, labels: Labels) -> Figure:
    """A row of panels per foundation, a column per rival; hollow where a sensor or rate can't tell it."""
    blocks = dict(zip(frame["block"].unique(), cycle(BLOCK_STYLES)))
    measured = rows[rows["epsilon_theta"].notna()]
    shown = measured if len(measured) else rows
    foundations, rivals = shown["foundation"].unique(), shown["rival"].unique()
    figure = Figure(figsize=(7.0, 1.1 + 1.5 * len(foundations)))
    axes = figure.subplots(len(foundations), len(rivals), squeeze=False, sharex=True, sharey=True)
    for column, rival in zip(axes.T, rivals, strict=True):
        column[0].set_title(MODEL_LABELS[rival].replace(", ", ",\n", 1), loc="left")
        column[-1].set_xlabel("release angle / °")
        for ax, foundation in zip(column, foundations, strict=True):
            chosen = measured[(measured["rival"] == rival) & (measured["foundation"] == foundation)]
            for block, some in chosen.groupby("block", sort=False):
                of_angle = {"epsilon_percent": "first", "told_apart": "all"}
                curve = some.groupby("release_angle_deg").agg(of_angle)
                (line,) = ax.plot(curve["epsilon_percent"], **blocks[block])
                hidden = curve["epsilon_percent"][~curve["told_apart"]]
                ax.plot(hidden, **blocks[block] | {"linestyle": "", "markerfacecolor": "white"}, zorder=3)
                line.set_zorder(2)
    axes[0, 0].set(yscale="log", xlim=(0, 1.1 * frame["release_angle_deg"].max()))
    for ax, foundation in zip(axes[:, 0], foundations, strict=True):
        ax.set_ylabel(f"{style.label(labels, foundation)}\n$ε_θ$ / %")
    hollow = {"marker": "o", "markerfacecolor": "white", "linestyle": "", "label": "not told apart"}
    title = f"{MODEL_LABELS[rows['model'].iloc[0]]} expected: its rivals at their best"
    return _headed(figure, title, blocks, labels, [hollow])


@styled()
def draw_totals(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """Relative total uncertainty over the number of runs, with what no number of runs makes smaller.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan_total.plan_totals`; not empty.

    Returns
    -------
    pages : list of matplotlib.figure.Figure
        One: a row of panels per foundation, a panel per model and parameter.
    data : pandas.DataFrame
        The rows drawn, each in the case that knows best, with both in per cent of the value.
    """
    best = best_known(frame)
    best = best.assign(u_total_percent=100 * best["u_total"] / best["value"])
    best = best.assign(inputs_percent=100 * best["inputs_fraction"])
    blocks = dict(zip(frame["block"].unique(), cycle(BLOCK_STYLES)))
    expected = {
        name: list(dict.fromkeys(zip(own["model"], own["parameter"], strict=True)))
        for name, own in best.groupby("foundation", sort=False)
    }
    figure = Figure(figsize=(7.0, 0.9 + 1.6 * len(expected)))
    places = figure.add_gridspec(len(expected), max(map(len, expected.values())))
    for i, (foundation, parameters) in enumerate(expected.items()):
        for j, (model, parameter) in enumerate(parameters):
            ax = figure.add_subplot(places[i, j], xscale="log", yscale="log")
            ax.set_title(f"{MODEL_LABELS[model]} {SYMBOLS[parameter]}", loc="left")
            here = best[(best["foundation"] == foundation) & (best["model"] == model)]
            own = here[here["parameter"] == parameter].sort_values("n_runs")
            for block, curve in own.groupby("block", sort=False):
                ax.plot(curve["n_runs"], curve["u_total_percent"], **blocks[block])
                least = {"color": blocks[block]["color"], "linestyle": ":", "linewidth": 0.8}
                ax.plot(curve["n_runs"], curve["inputs_percent"], **least)
            ax.set_ylim(bottom=own["u_total_percent"].min() / BELOW)
            ax.set_xticks(sorted(best["n_runs"].unique()))
            ax.xaxis.set_major_formatter(ScalarFormatter())
            ax.xaxis.set_minor_locator(NullLocator())
            ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
            ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            ax.yaxis.set_minor_locator(NullLocator())
            if j == 0:
                ax.set_ylabel(f"{style.label(labels, foundation)}\n$u$ / %")
            if i == len(expected) - 1:
                ax.set_xlabel("runs per block")
    alone = {"linestyle": ":", "linewidth": 0.8, "label": "inputs alone"}
    return [_headed(figure, "Total uncertainty predicted for a mean", blocks, labels, [alone])], best
