"""Figure of the valleys: how far ε_θ rises around the parameters identified on each record."""

import math

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from freerock.figures.style import (
    columns,
    footer,
    gathered,
    label,
    of_run,
    panel,
    printed,
    scaled,
    size,
    wrapped,
)
from freerock.identification.misfit import SPAN, misfit_map
from freerock.models.laws import MODEL_LABELS, MODELS, SYMBOLS
from freerock.products.estimates import estimates_in
from freerock.tables.text import quantity

MODEL = "hunt_crossley"
NARROWEST_IN = 2.5  # of a panel
LEVELS_PERCENT = (2.0, 5.0, 10.0, 30.0)
COLUMNS = ["test", "block", "foundation", "run", "quantity", "k", "lambda", "epsilon_theta", "correlation"]


@printed
def draw(fits, blocks, origin, labels=None, debonding="geometric"):
    """Contours of ε_θ over stiffness and damping of the first run of each record, and what all runs gave.

    Angle and instant of release are those identified on the run; their own part in the valley is in the
    covariances of the fit datasets.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.
    blocks : mapping of str to freerock.models.block.Block
        The campaign's blocks by name.
    origin : str
        "simulated" or "measured".
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        Columns `COLUMNS`: the contours' grid, the identified values (quantity "identified") with the
        correlation of ln k and ln λ; SI units.
    """
    shown = [(tree, _identified(tree)) for tree in fits]
    shown = [(tree, found) for tree, found in shown if found]
    width, _ = size(1)
    beside = 2 if len(shown) > 1 and width > 2 * NARROWEST_IN else 1
    rows = max(1, math.ceil(len(shown) / beside))
    figure = Figure(figsize=size(2.5 * rows + 0.4))
    axes = figure.subplots(rows, beside, squeeze=False).ravel()
    parts = []
    for i, (ax, (tree, found)) in enumerate(zip(axes, shown, strict=False)):
        parts += _panel(ax, tree, found, blocks[tree.attrs["block"]], debonding)
        block, foundation = (label(labels, tree.attrs[key]) for key in ("block", "foundation"))
        test, run = tree.attrs["test"], found[0].run
        told = f"{test}, joint fit" if run == "pooled" else of_run(test, run)
        title = panel(i, len(shown), f"{block}, {foundation}: {told}")
        ax.set_title(wrapped(title, 0.8 / beside), loc="left")
        ax.set(xlabel=f"{SYMBOLS['k']} / (N/m²)", ylabel=f"{SYMBOLS['lambda']} / (N s/m³)")
    for ax in axes[len(shown) :]:
        ax.set_axis_off()
    handles = [
        Line2D(
            [],
            [],
            color="0.4",
            linewidth=scaled(0.8),
            label=f"$ε_θ$ of {MODEL_LABELS[MODEL]} on the run named / %",
        ),
        Line2D(
            [],
            [],
            color="black",
            marker="o",
            linestyle="",
            markersize=scaled(4),
            label="identified, run by run",
        ),
        Line2D(
            [], [], color="#d55e00", marker="x", linestyle="", markersize=scaled(5), label="all runs jointly"
        ),
    ]
    names = [handle.get_label() for handle in handles]
    figure.legend(handles=handles, loc="outside upper right", ncols=columns(names))
    if shown:
        footer(figure, origin)
    return figure, gathered(parts, COLUMNS)


def has_map(tree):
    """Whether a fit dataset holds a fit to be shown."""
    return bool(_identified(tree))


def _identified(tree):
    """The estimates to be shown."""
    return [each for each in estimates_in(tree) if each.model == MODEL]


def _panel(ax, tree, found, block, debonding):
    names = MODELS[MODEL]
    own = found[0]
    node = tree["pooled" if own.run == "pooled" else f"run_{own.run}"]
    time_s, theta = node["time"].values, node["theta"].values
    found_map = misfit_map(MODEL, block, own.values, time_s, theta, debonding)
    k, damping = found_map.first, found_map.second
    # √ε_θ is nearly linear on the slopes: smoother contours
    lines = ax.contour(
        found_map.first_finer,
        found_map.second_finer,
        np.sqrt(100 * found_map.epsilon_finer),
        levels=np.sqrt(LEVELS_PERCENT),
        colors="0.4",
        linewidths=scaled(0.7),
    )
    percent = {level: f"{level**2:.3g}" for level in lines.levels}
    small = 0.85 * matplotlib.rcParams["legend.fontsize"]
    labels = ax.clabel(lines, fmt=percent, fontsize=small, inline=False)
    identity = {key: tree.attrs[key] for key in ("test", "block", "foundation")}
    for each in found:
        pooled = each.run == "pooled"
        style = {"marker": "x", "color": "#d55e00"} if pooled else {"marker": "o", "color": "black"}
        ax.plot(*each.parameters.values(), linestyle="", markersize=scaled(4), **style)
    ax.set(xscale="log", yscale="log", xlim=(k[0], k[-1]), ylim=(damping[0], damping[-1]))
    ax.minorticks_off()
    for axis, values in ((ax.xaxis, k), (ax.yaxis, damping)):
        ticks = MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(values[0], values[-1])
        ticks = ticks[(values[0] < ticks) & (ticks < values[-1])]
        axis.set_ticks(ticks, [quantity(tick, digits=2) for tick in ticks])
    for text in labels:  # one under a marker cannot be read
        at = np.log(text.get_position()) - np.log([k[0], damping[0]])
        marked = (np.log([e.values[names[0]] / k[0], e.values[names[1]] / damping[0]]) for e in found)
        gaps = [np.hypot(*(at - marker)) for marker in marked]
        text.set_visible(min(gaps) > 0.2 * SPAN)
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.3})
    grid = np.meshgrid(k, damping)
    yield pd.DataFrame(
        {
            **identity,
            "run": str(own.run),
            "quantity": "grid",
            "k": grid[0].ravel(),
            "lambda": grid[1].ravel(),
            "epsilon_theta": found_map.epsilon_theta.ravel(),
        }
    )
    yield pd.DataFrame(
        [
            {
                **identity,
                "run": str(each.run),
                "quantity": "identified",
                **each.parameters,
                "correlation": each.correlation,
            }
            for each in found
        ]
    )
