"""Restitution per impact, the comparison Spanos et al. 2017 mention and leave out for want of space."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import (
    FAILED,
    MODEL_MARKERS,
    MODEL_STYLES,
    Axes,
    Labels,
    Style,
    footer,
    legend_on_top,
    number_of,
    of_scene,
    outer_labels,
    panel_per_scene,
    printed,
    recorded,
    scaled,
    scenes_in,
)
from freerock.models.block import Block
from freerock.models.laws import LAWS, MODEL_LABELS
from freerock.tables.restitution_law import PEAKS, restitution_law
from freerock.tables.swings import law_swings, local_band

FIGURE = {
    "title": "Restitution of each impact",
    "caption": "Restitution r of each impact, from the peaks before and after it, against the impact speed, "
    "that of the far corner of a rigid block that falls from the peak before it. Bars: one "
    "standard error. Shaded: where 95 % of the recorded impacts of like speed lie, by a local "
    "line and the scatter about it. Dashed, where r is not a constant with 95 % certainty: the "
    "mean of the straight lines through the recorded impacts of each run. Dotted: a rigid block "
    "on a rigid base (Housner 1963). Impacts of failed fits are left out.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}

BAND = "0.86"


@printed
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> tuple[Figure, pd.DataFrame]:
    """Restitution of each impact against its speed, one panel per block and foundation.

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
        Columns of `freerock.tables.swings.swings`.
    """
    data = law_swings(runs, restitution, epsilon, blocks)
    laws = restitution_law(data, epsilon)
    laws = laws[(laws["quantity"] == PEAKS) & laws["trend"]]
    figure, panels = panel_per_scene(scenes_in(runs), labels, 2.0, sharex="row", sharey="row")
    for (block, foundation), ax in panels.items():
        scene, law = (of_scene(each, block, foundation) for each in (data, laws))
        _panel(ax, scene, law, blocks[block].restitution_housner, recorded(origin)["label"])
        _tell_failed(ax, of_scene(epsilon, block, foundation))
    for block, ax in {block: ax for (block, _), ax in panels.items()}.items():
        seen = data[(data["block"] == block) & (data["source"] == "experiment")]["rigid_speed_m_s"]
        if len(seen):  # models rock on below what is seen
            room = 0.05 * (seen.max() - seen.min()) + 0.01 * seen.max()
            ax.set_xlim(seen.min() - room, seen.max() + room)
    outer_labels(panels, "impact speed / (m/s)", "restitution r")
    legend_on_top(figure)
    footer(figure, origin)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many impacts and runs are drawn."""
    seen = data[data["source"] == "experiment"]
    n_runs = len(seen[["test", "run"]].drop_duplicates())
    return f"{number_of(len(seen), 'recorded impact').capitalize()} of {number_of(n_runs, 'run')}."


def _tell_failed(ax: Axes, fits: pd.DataFrame) -> None:
    """The laws of which no fit may be used: none of their impacts is drawn."""
    usable = fits.groupby("model", sort=False)["success"].any()
    if lost := [MODEL_LABELS[model] for model in LAWS if not usable.get(model, True)]:
        text = f"{', '.join(lost)}: no fit that may be used"
        style: Style = {"fontsize": "small", "color": FAILED, "zorder": 4}
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1}
        ax.text(0.02, 0.03, text, transform=ax.transAxes, bbox=box, **style)


def _panel(ax: Axes, scene: pd.DataFrame, law: pd.DataFrame, r_housner: float, name: str) -> None:
    ax.margins(x=0.05)
    ax.axhline(r_housner, color="0.3", linestyle=":", label="rigid block, theory")
    seen = scene[scene["source"] == "experiment"]
    band = local_band(seen["rigid_speed_m_s"], seen["r"])
    if len(band):
        ax.fill_between(*band.to_numpy(float).T, color=BAND, linewidth=0, label="95 % of the impacts")
    for line in law.itertuples():
        ends = pd.Series([line.speed_low_m_s, line.speed_high_m_s])
        on_line = line.r + line.slope_s_m * (ends - line.speed_m_s)
        ax.plot(ends, on_line, color="black", linestyle=(0, (6, 2)), label="line through the impacts")
    for model in LAWS:
        thin = {"markersize": scaled(2.5), "linewidth": scaled(0.8)}
        own = {"marker": MODEL_MARKERS[model], "label": f"{MODEL_LABELS[model]}, fitted"}
        style = MODEL_STYLES[model] | thin | own
        for k, (_, run) in enumerate(scene[scene["source"] == model].groupby(["test", "run"], sort=False)):
            ax.plot(run["rigid_speed_m_s"], run["r"], **style | ({"label": "_"} if k else {}))
    ax.errorbar(
        seen["rigid_speed_m_s"],
        seen["r"],
        yerr=seen["r_stderr"],
        fmt="o",
        color="0.45",
        markerfacecolor="none",
        markersize=scaled(5),
        markeredgewidth=scaled(1),
        elinewidth=scaled(0.8),
        label=name,
    )
