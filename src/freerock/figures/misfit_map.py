"""Figure of the misfit maps: how far ε_θ rises around the parameters identified on each record."""

from collections.abc import Iterator, Sequence

import matplotlib
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.lines import Line2D

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, printed
from freerock.models.laws import MODEL_LABELS, MODELS
from freerock.products.misfit_maps import open_misfit_maps
from freerock.tables.candidates import accepted_fits

FIGURE = {
    "title": "Misfit maps around the identified parameters",
    "caption": "Discrepancy ε_θ of the law selected for each record, in per cent, around the parameters "
    "identified on its first run. Full dot: these parameters; open dots: those identified on its other "
    "runs. Law rejected: no law with two parameters explains the first run; the parameters describe the "
    "fit, not the foundation.",
    "reads": ["maps", "choice"],
}

NARROWEST_IN = 2.5  # of a panel
LEVELS_PERCENT = (2.0, 5.0, 10.0, 30.0)
OF_DRAWN: Style = {"marker": "o", "color": "black", "linestyle": "", "markersize": 4}
OF_OTHERS: Style = OF_DRAWN | {"markerfacecolor": "white"}
COLUMNS = ["test", "block", "foundation", "run", "quantity", "k", "lambda", "epsilon_theta", "correlation"]
COLUMNS += ["model", "c"]

read = open_misfit_maps


@printed
def draw(maps: Sequence[xr.Dataset], choice: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Contours of ε_θ over stiffness and damping of the first run of each record, and what all runs gave.

    Angle and instant of release are those identified on the run; their own part is in the covariances of the
    fit datasets.

    Parameters
    ----------
    maps : sequence of xarray.Dataset
        As `open_misfit_maps` gives them.
    choice : pandas.DataFrame
        Tidy table: where it rejects the law for the run of the contours, the panel states it.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: the contours' grid, the identified values (quantity "identified") with the
        correlation of ln k and ln λ; SI units.
    """
    accepted = accepted_fits(choice)
    beside = style.fit_beside(min(2, len(maps)), NARROWEST_IN)
    figure, axes = style.panels_in_rows(len(maps), beside, 2.5, 0.4)
    for i, (ax, each) in enumerate(zip(axes, maps, strict=True)):
        _panel(ax, each)
        model = each.attrs["model"]
        if (each.attrs["test"], str(each["identified_run"].values[0]), model) not in accepted:
            look: Style = {"fontsize": "small", "color": style.FAILED, "zorder": 4, "ha": "right"}
            box = {"facecolor": "white", "edgecolor": "none", "pad": 1}
            ax.text(0.98, 0.03, "law rejected", transform=ax.transAxes, bbox=box, **look)
        scene = style.label(labels, each.attrs["block"], each.attrs["foundation"])
        style.entitle(ax, i, len(maps), f"{scene}: {MODEL_LABELS[model]}", 0.8 / beside)
        first, second = MODELS[model]
        ax.set(xlabel=style.axis_of(first), ylabel=style.axis_of(second))
    style.finish_with(figure, origin if maps else "", _handles(maps))
    return figure, style.gathered((part for each in maps for part in _numbers(each)), COLUMNS)


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Which runs the contours are of."""
    return style.drawn_runs(data[data["quantity"] == "grid"])


def _handles(maps: Sequence[xr.Dataset]) -> list[Line2D]:
    looks = [{"color": "0.4", "linewidth": 0.8, "label": "$ε_θ$ / %"}]
    looks += [OF_DRAWN | {"label": "identified on that run: the minimum"}]
    if any(each.sizes["identified"] > 1 for each in maps):
        looks += [OF_OTHERS | {"label": "on the other runs"}]
    return [Line2D([], [], **style.sized(look)) for look in looks]


def _panel(ax: Axes, record: xr.Dataset) -> None:
    """Contours, markers and ticks of one record."""
    names = MODELS[record.attrs["model"]]
    k, damping = (record[name].values for name in names)
    identified = np.column_stack([record[f"identified_{name}"].values for name in names])
    # √ε_θ is nearly linear on the slopes: smoother contours
    finer = (record[f"{name}_finer"].values for name in names)
    slopes = (*finer, np.sqrt(100 * record["epsilon_finer"].values))
    look: Style = {"colors": "0.4", "linewidths": style.scaled(0.7)}
    lines = ax.contour(*slopes, levels=np.sqrt(LEVELS_PERCENT), **look)
    percent = {level: f"{level**2:.3g}" for level in lines.levels}
    texts = ax.clabel(lines, fmt=percent, fontsize=matplotlib.rcParams["legend.fontsize"], inline=False)
    for look, found in ((OF_OTHERS, identified[1:]), (OF_DRAWN, identified[:1])):
        for each in found:
            ax.plot(*each, zorder=3, **style.sized(look))
    ax.set(xscale="log", yscale="log", xlim=(k[0], k[-1]), ylim=(damping[0], damping[-1]))
    ax.minorticks_off()
    for axis, values in ((ax.xaxis, k), (ax.yaxis, damping)):
        style.number_ticks(axis, values[0], values[-1])
    for text in texts:  # one under a marker cannot be read
        at = np.log(text.get_position()) - np.log([k[0], damping[0]])
        gaps = [np.hypot(*(at - np.log(each / [k[0], damping[0]]))) for each in identified]
        text.set_visible(min(gaps) > 0.1 * np.log(k[-1] / k[0]))
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.3})


def _numbers(record: xr.Dataset) -> Iterator[pd.DataFrame]:
    """The grid and the identified values of one record."""
    first, second = MODELS[record.attrs["model"]]
    axes = [each.ravel() for each in np.meshgrid(record[first].values, record[second].values)]
    grid = {first: axes[0], second: axes[1], "epsilon_theta": record["epsilon_theta"].values.ravel()}
    runs = record["identified_run"].values
    yield pd.DataFrame({**record.attrs, "run": runs[0], "quantity": "grid", **grid}, columns=COLUMNS)
    found = {name: record[f"identified_{name}"].values for name in (first, second)}
    found |= {"run": runs, "correlation": record["correlation"].values}
    # reindexed, columns without values stay numbers
    yield pd.DataFrame({**record.attrs, "quantity": "identified", **found}).reindex(columns=COLUMNS)
