"""Ticks of panels drawn as few artists: five each, as Matplotlib has them, take a third of a page's time."""

from typing import Any

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, ScalarFormatter

from freerock.arrays import Floats
from freerock.figures.style import Axes, Style


def lighten(figure: Figure) -> None:
    """Draw grids and tick marks of all panels as one collection each, numbers as texts of their panel.

    For a figure without a layout engine, where limits, ticks and places of the panels are settled.
    """
    looks: Any = matplotlib.rcParams
    inches = figure.dpi_scale_trans
    grid, marks = [], []
    for ax in figure.axes:
        ax.set_facecolor("none")  # the grid lies below
        for n, name in enumerate("xy"):
            ticks = _numbered(ax, name)
            place = getattr(ax, f"get_{name}axis_transform")() - inches
            near, far = (
                place.transform(np.column_stack([ticks, np.full(len(ticks), edge)][:: 1 - 2 * n]))
                for edge in (0.0, 1.0)
            )
            outside = near - np.eye(2)[1 - n] * looks[f"{name}tick.major.size"] / 72
            grid += [*np.stack([near, far], axis=1)]
            marks += [*np.stack([near, outside], axis=1)]
    thin: Style = {"color": looks["grid.color"], "linewidth": looks["grid.linewidth"], "zorder": -1}
    dark: Style = {"color": looks["xtick.color"], "linewidth": looks["xtick.major.width"]}
    for lines, look in ((grid, thin), (marks, dark)):
        figure.add_artist(LineCollection(lines, transform=inches, **look))


def _numbered(ax: Axes, name: str) -> Floats:
    """Take the ticks of one of a panel's axes away and write their numbers; where they were [data]."""
    axis = getattr(ax, f"{name}axis")
    low, high = sorted(axis.get_view_interval())
    ticks: Floats = np.asarray(axis.get_majorticklocs(), float)
    ticks = ticks[(low <= ticks) & (ticks <= high)]
    formatter = axis.get_major_formatter()
    if isinstance(formatter, ScalarFormatter):  # a number is written whole, with no power or offset beside
        formatter.set_useOffset(False)
        formatter.set_scientific(False)
    numbers = formatter.format_ticks(ticks)
    if axis.get_tick_params()["labelbottom" if name == "x" else "labelleft"]:
        looks: Any = matplotlib.rcParams
        pad = looks[f"{name}tick.major.size"] + looks[f"{name}tick.major.pad"]
        place, vertical, horizontal = getattr(ax, f"get_{name}axis_text1_transform")(pad)
        look: Style = {"va": vertical, "ha": horizontal, "fontsize": looks[f"{name}tick.labelsize"]}
        for tick, number in zip(ticks, numbers, strict=True):
            ax.text(*((tick, 0) if name == "x" else (0, tick)), number, transform=place, **look)
    axis.set_major_locator(NullLocator())
    axis.set_minor_locator(NullLocator())
    return ticks
