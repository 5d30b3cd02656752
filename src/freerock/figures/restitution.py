"""Restitution per impact, the comparison Spanos et al. 2017 mention and leave out for want of space."""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import (
    MODEL_MARKERS,
    MODEL_STYLES,
    Axes,
    Labels,
    columns,
    footer,
    label,
    panel,
    printed,
    scaled,
    size,
    wrapped,
)
from freerock.models.block import Block
from freerock.models.laws import LAWS, MODEL_LABELS
from freerock.tables.tidy import usable_rows

NARROWEST_IN = 1.7  # of a panel: with more foundations the figure grows wider than its target


@printed
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> tuple[Figure, pd.DataFrame]:
    """Restitution of each impact against the peak before it, one panel per block and foundation.

    Parameters
    ----------
    runs, restitution : pandas.DataFrame
        Tidy tables runs and restitution, see `freerock.tables.tidy`; failed and excluded runs are left out.
    epsilon : pandas.DataFrame
        Tidy table epsilon; impacts of a model whose fit failed are left out.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of the table restitution.
    """
    shown = restitution[restitution["source"].isin(["experiment", *LAWS])]
    data = shown.merge(usable_rows(runs)[["test", "run"]])
    failed = set(_fits(epsilon[~epsilon["success"]], "model"))
    data = data[np.array([fit not in failed for fit in _fits(data, "source")], dtype=bool)]
    above, under = (list(dict.fromkeys(runs[key])) for key in ("block", "foundation"))

    width, height = size(0.5 + 2.0 * len(above))
    figure = Figure(figsize=(max(width, NARROWEST_IN * len(under)), height))
    axes = figure.subplots(len(above), len(under), squeeze=False, sharex="row", sharey="row")
    for i, block in enumerate(above):
        for j, foundation in enumerate(under):
            scene = data[(data["block"] == block) & (data["foundation"] == foundation)]
            _panel(axes[i, j], scene, blocks[block].restitution_housner)
            names = f"{label(labels, block)}, {label(labels, foundation)}"
            title = panel(i * len(under) + j, axes.size, names)
            axes[i, j].set_title(wrapped(title, 0.8 / len(under)), loc="left")
        axes[i, 0].set_ylabel("restitution r")
    for ax in axes[-1]:
        ax.set_xlabel(wrapped("peak |θ| before the impact / °", 0.8 / len(under)))
    found = [ax.get_legend_handles_labels() for ax in axes.flat]
    handles = {name: handle for each in found for handle, name in zip(*each, strict=True)}
    figure.legend(handles.values(), handles, loc="outside upper center", ncols=columns(list(handles)))
    footer(figure, origin)
    return figure, data


def _fits(table: pd.DataFrame, model: str) -> Iterator[tuple[str, str, str]]:
    """What fit each row is of."""
    return zip(table["test"], table["run"].astype(str), table[model], strict=True)


def _panel(ax: Axes, scene: pd.DataFrame, r_housner: float) -> None:
    ax.margins(x=0.05)
    ax.axhline(r_housner, color="0.45", linestyle=":", label="rigid block, theory")
    for model in LAWS:
        thin = {"markersize": scaled(2.5), "linewidth": scaled(0.8)}
        own = {"marker": MODEL_MARKERS[model], "label": f"{MODEL_LABELS[model]}, fitted"}
        style = MODEL_STYLES[model] | thin | own
        for k, (_, run) in enumerate(scene[scene["source"] == model].groupby(["test", "run"], sort=False)):
            ax.plot(run["peak_before_deg"], run["r"], **style | ({"label": "_"} if k else {}))
    measured = scene[scene["source"] == "experiment"]
    ax.errorbar(
        measured["peak_before_deg"],
        measured["r"],
        yerr=measured["r_stderr"],
        fmt="o",
        color="0.45",
        markerfacecolor="none",
        markersize=scaled(5),
        markeredgewidth=scaled(1),
        elinewidth=scaled(0.8),
        label="measured",
    )
