"""Period against amplitude, measured and modelled."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import (
    MODEL_MARKERS,
    MODEL_STYLES,
    Axes,
    Labels,
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
from freerock.models.housner import housner_swings
from freerock.models.laws import LAWS, law_of
from freerock.tables.swings import first_runs, law_swings

FIGURE = {
    "title": "Period against amplitude",
    "caption": "Twice the time between two impacts against the largest |θ| between them. Dotted: a rigid "
    "block (Housner 1963), whose period does not depend on r and goes to zero with its amplitude.",
    "reads": ["runs", "restitution", "epsilon", "blocks"],
}

# Housner's period depends on no number.
FOUNDATIONS = [model for model in LAWS if law_of(model).is_foundation]


@printed
def draw(
    runs: pd.DataFrame,
    restitution: pd.DataFrame,
    epsilon: pd.DataFrame,
    blocks: Mapping[str, Block],
    origin: str,
    labels: Labels = None,
) -> tuple[Figure, pd.DataFrame]:
    """Twice the time between impacts against the peak between them: all runs; laws fitted to the first.

    Parameters
    ----------
    runs, restitution, epsilon : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `freerock.tables.swings.swings`, rows with a period.
    """
    data = law_swings(runs, restitution, epsilon, blocks)
    data = data[data["period_s"].notna() & data["source"].isin(["experiment", *FOUNDATIONS])]
    modelled = first_runs(data)
    modelled = modelled[modelled["source"] != "experiment"]
    data = pd.concat([data[data["source"] == "experiment"], modelled], ignore_index=True)
    figure, panels = panel_per_scene(scenes_in(runs), labels, 2.0, sharex="row", sharey="row")
    for (block, foundation), ax in panels.items():
        scene = of_scene(data, block, foundation)
        _panel(ax, scene, blocks[block], str(recorded(origin)["label"]))
        ax.margins(x=0.04)
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    outer_labels(panels, "peak |θ| between two impacts / °", "period / s")
    legend_on_top(figure)
    footer(figure, origin)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many runs are drawn, and of which run the models are."""
    seen = data[data["source"] == "experiment"][["test", "run"]].drop_duplicates()
    return f"{number_of(len(seen), 'run').capitalize()}; models fitted to the first of each panel."


def _panel(ax: Axes, scene: pd.DataFrame, block: Block, name: str) -> None:
    seen = scene[scene["source"] == "experiment"]
    ax.plot(
        seen["peak_before_deg"],
        seen["period_s"],
        "o",
        color="0.45",
        markerfacecolor="none",
        markersize=scaled(4.5),
        label=name,
    )
    highest = scene["peak_before_deg"].max() if len(scene) else 0.0
    if 0 < highest < np.degrees(block.theta_cr):
        amplitude = np.linspace(0.002, 1, 60) * highest
        period = [
            4 * housner_swings(block, 1.0, each, max_impacts=1).impact_time[0]
            for each in np.radians(amplitude)
        ]
        ax.plot(amplitude, period, color="0.3", linestyle=":", label="rigid block, any r")
    for model in FOUNDATIONS:
        own = scene[scene["source"] == model]
        if len(own):
            look = MODEL_STYLES[model] | {"marker": MODEL_MARKERS[model], "markersize": scaled(2.5)}
            ax.plot(own["peak_before_deg"], own["period_s"], **look)
