"""Energy during a run, and its loss at each impact."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from freerock.figures import style
from freerock.figures.by_block import foundation_looks, laws_told
from freerock.figures.style import Axes, Drawing, Labels, printed
from freerock.models.block import Block
from freerock.tables.swings import first_runs, named_swings

FIGURE = {
    "title": "Energy during a run, and its loss at each impact",
    "caption": "Left: energy above rest before each impact, as of a rigid block at the peak of |θ| "
    "(Housner 1963). Right: share lost at the impact, 1 − r²; bars: total standard uncertainty. Symbols: the "
    "record; lines: the named model, otherwise the one with the least ε_θ.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}


@printed
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """Energy between impacts over time, and its loss by each impact, of the first run on each foundation.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name; a row of panels each.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`; source is "experiment" or the model of `named_models`.
    """
    data = first_runs(named_swings(runs, restitution, epsilon, blocks))
    above, looks = list(dict.fromkeys(runs["block"])), foundation_looks(runs)
    figure = Figure(figsize=style.size(0.5 + 2.0 * len(above)))
    axes = figure.subplots(len(above), 2, squeeze=False, sharex="col")
    for i, block in enumerate(above):
        for foundation, look in looks.items():
            scene = style.of_scene(data, block, foundation)
            name = style.label(labels, foundation)
            _curves(axes[i], scene, look, name, str(style.recorded(origin)["label"]))
        style.entitle(axes[i, 0], i, len(above), style.label(labels, block), 0.45)
        axes[i, 0].set(yscale="log", ylabel="energy / J")
        axes[i, 1].set_ylabel("loss 1 − r² / %")
        axes[i, 1].xaxis.set_major_locator(MaxNLocator(6, integer=True))
        for ax in axes[i]:
            ax.margins(x=0.03)
    axes[-1, 0].set_xlabel("time since release / s")
    axes[-1, 1].set_xlabel("number of the impact")
    style.finish(figure, origin)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Which runs are drawn, and the model beside each."""
    told, laws = style.drawn_runs(data), laws_told(data)
    return f"{told} Model: {laws}." if laws else told


def _curves(axes: Axes, scene: pd.DataFrame, look: dict[str, object], name: str, record: str) -> None:
    """Energy and loss of a run and its model, in the look of its foundation."""
    seen, modelled = (scene[(scene["source"] == "experiment") == own] for own in (True, False))
    points = style.sized(look | {"linestyle": "", "markersize": 4, "markerfacecolor": "none"})
    if len(modelled):
        line = style.sized(look | {"marker": "", "linewidth": 0.9})
        axes[0].plot(modelled["time_s"], modelled["energy_j"], drawstyle="steps-pre", **line)
        axes[1].plot(modelled["impact"], 100 * modelled["loss"], **line, label=f"{name}, model")
    if len(seen):
        axes[0].plot(seen["time_s"], seen["energy_j"], **points)
        bars = {"yerr": 100 * seen["loss_u"], "elinewidth": style.scaled(0.8)}
        axes[1].errorbar(seen["impact"], 100 * seen["loss"], **bars, **points, label=f"{name}, {record}")
