"""Figure of the valleys: how far ε_θ rises around the parameters identified on each record."""

import math

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from scipy.interpolate import CubicSpline

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
from freerock.identification.choice import epsilon_theta
from freerock.models.laws import MODEL_LABELS, MODELS, SYMBOLS
from freerock.models.simulate import simulate_fitted
from freerock.products.groups import fits_of
from freerock.tables.tidy import quantity

MODEL = "hunt_crossley"
SPAN = 0.3  # of the parameters around the identified ones, in logarithms
CELLS = 25  # each way
FINER = 4 * CELLS - 3  # points each way of the contours, between which θ(t) is interpolated
MOST_SAMPLES = 1000
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
    shown = [(tree, list(_identified(tree))) for tree in fits]
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
        test, run = tree.attrs["test"], found[0][0]
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
    return any(True for _ in _identified(tree))


def _identified(tree):
    """Run, parameters and correlation of the successful fits."""
    for run, model, fit in fits_of(tree):
        if model != MODEL or not fit["success"].item():
            continue
        value = dict(zip(fit["parameter"].values.astype(str), fit["value"].values, strict=True))
        covariance = fit["covariance"].values[:2, :2]
        yield run, value, covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])


def _panel(ax, tree, found, block, debonding):
    names = MODELS[MODEL]
    (run, centre, _) = found[0]
    node = tree["pooled" if run == "pooled" else f"run_{run}"]
    time_s, theta = node["time"].values, node["theta"].values
    first = slice(
        np.append(np.flatnonzero(np.diff(time_s) < 0), len(time_s) - 1)[0] + 1
    )  # run of a joint fit
    time_s, theta = time_s[first], theta[first]
    kept = slice(None, None, max(1, len(time_s) // MOST_SAMPLES))
    time_s, theta = time_s[kept], theta[kept]
    share = np.exp(np.linspace(-SPAN, SPAN, CELLS))
    k, damping = centre[names[0]] * share, centre[names[1]] * share
    theta_model = np.empty((CELLS, CELLS, len(time_s)))
    # of a joint fit the first run's
    release = {name: centre[f"{name}_1"] for name in ("theta0", "t0") if f"{name}_1" in centre}
    known = {"theta0": theta[0]} | release | centre
    for row, one in enumerate(damping):
        for column, other in enumerate(k):
            values = known | dict(zip(names, (other, one), strict=True))
            modelled = simulate_fitted(MODEL, block, values, time_s, debonding=debonding, rtol=1e-4)
            theta_model[row, column] = modelled
    epsilon = np.array([[epsilon_theta(time_s, each, theta) for each in row] for row in theta_model])
    # √ε_θ is nearly linear on the slopes: smoother contours
    finer = np.exp(np.linspace(-SPAN, SPAN, FINER))
    lines = ax.contour(
        centre[names[0]] * finer,
        centre[names[1]] * finer,
        np.sqrt(100 * _finer(time_s, theta_model, theta)),
        levels=np.sqrt(LEVELS_PERCENT),
        colors="0.4",
        linewidths=scaled(0.7),
    )
    percent = {level: f"{level**2:.3g}" for level in lines.levels}
    small = 0.85 * matplotlib.rcParams["legend.fontsize"]
    labels = ax.clabel(lines, fmt=percent, fontsize=small, inline=False)
    identity = {key: tree.attrs[key] for key in ("test", "block", "foundation")}
    for run, value, _ in found:
        style = {"marker": "x", "color": "#d55e00"} if run == "pooled" else {"marker": "o", "color": "black"}
        ax.plot(value[names[0]], value[names[1]], linestyle="", markersize=scaled(4), **style)
    ax.set(xscale="log", yscale="log", xlim=(k[0], k[-1]), ylim=(damping[0], damping[-1]))
    ax.minorticks_off()
    for axis, values in ((ax.xaxis, k), (ax.yaxis, damping)):
        ticks = MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(values[0], values[-1])
        ticks = ticks[(values[0] < ticks) & (ticks < values[-1])]
        axis.set_ticks(ticks, [quantity(tick, digits=2) for tick in ticks])
    for text in labels:  # one under a marker cannot be read
        at = np.log(text.get_position()) - np.log([k[0], damping[0]])
        gaps = [np.hypot(*(at - np.log([v[names[0]] / k[0], v[names[1]] / damping[0]]))) for _, v, _ in found]
        text.set_visible(min(gaps) > 0.2 * SPAN)
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.3})
    grid = np.meshgrid(k, damping)
    yield pd.DataFrame(
        {
            **identity,
            "run": str(found[0][0]),
            "quantity": "grid",
            "k": grid[0].ravel(),
            "lambda": grid[1].ravel(),
            "epsilon_theta": epsilon.ravel(),
        }
    )
    yield pd.DataFrame(
        [
            {
                **identity,
                "run": str(run),
                "quantity": "identified",
                "k": value["k"],
                "lambda": value["lambda"],
            }
            | {"correlation": correlation}
            for run, value, correlation in found
        ]
    )


def _finer(time_s, theta_model, theta):
    """ε_θ on the finer grid, θ(t) interpolated between the cells: a valley may be narrower than they are."""
    step = np.gradient(time_s)
    weight = np.sqrt(step / (step @ np.nan_to_num(theta) ** 2))
    residual = np.nan_to_num(theta_model - theta) * weight
    between = CubicSpline(np.linspace(0, 1, CELLS), np.eye(CELLS))(np.linspace(0, 1, FINER))
    rows = (between @ np.tensordot(row, residual, 1) for row in between)
    return np.array([(row**2).sum(axis=1) for row in rows])
