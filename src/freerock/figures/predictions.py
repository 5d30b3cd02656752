"""How well parameters identified on other runs and blocks predict a run."""

from collections.abc import Mapping

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.lines import Line2D

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.models.laws import MODEL_LABELS, MODELS

OWN = "fitted to the run itself"
OTHER_RUNS = "other runs"  # the basis, as in the table
ANOTHER = "another block"  # whichever it is
MARKERS: dict[str, Style] = {
    OWN: {"marker": "|", "color": "black", "markersize": 7, "label": OWN},
    OTHER_RUNS: {"marker": "o", "color": "#0072b2", "markersize": 4, "markerfacecolor": "none"}
    | {"label": "predicted from the other runs"},
    ANOTHER: {"marker": "x", "color": "#d55e00", "markersize": 4, "label": "predicted from another block"},
}
SCENE = ["block", "foundation", "model"]
NARROWEST_IN = 2.2  # of a panel


@styled()
def draw(predictions: pd.DataFrame, epsilon: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """ε_θ of each run with its own parameters, those of the record's other runs, and those of other blocks.

    Parameters
    ----------
    predictions : pandas.DataFrame
        From `freerock.populations.predict.predictions`.
    epsilon : pandas.DataFrame
        Tidy table epsilon.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of `predictions`, with a row per fit of a run, basis `OWN`.
    """
    named = epsilon[epsilon["selected"]] if epsilon["selected"].any() else epsilon
    epsilon, predictions = (table.merge(named[SCENE].drop_duplicates()) for table in (epsilon, predictions))
    laws = set(epsilon["model"])
    own = epsilon[epsilon["success"]].assign(basis=OWN, n_runs=1)[predictions.columns]
    data = style.gathered([each for each in (own, predictions) if len(each)], predictions.columns)
    if data.empty:
        return style.nothing_drawn("nothing to predict: no run has a fit that may be used", origin), data
    shown = [model for model in MODELS if model in laws]
    scenes = list(dict.fromkeys(zip(epsilon["block"], epsilon["foundation"], strict=True)))
    beside, high = style.fit_beside(len(shown), NARROWEST_IN), 0.8 + 0.33 * max(5, len(scenes))
    figure, axes = style.panels_in_rows(len(shown), beside, high, sharex=True, sharey=True)
    kinds = {kind: look for kind, look in MARKERS.items() if kind in set(data["basis"].map(_kind))}
    for i, (ax, model) in enumerate(zip(axes, shown, strict=True)):
        ax.set_title(style.panel(i, len(shown), MODEL_LABELS[model]), loc="left")
        _panel(ax, data[data["model"] == model], scenes, kinds)
        _mark_failed(ax, epsilon[epsilon["model"] == model], scenes)
        ax.tick_params(labelbottom=True)  # also above an empty place
    axes[0].set(xscale="log", ylim=(max(1, len(scenes)) - 0.5, -0.5))
    axes[0].set_yticks(range(len(scenes)), [style.label(labels, *scene) for scene in scenes])
    for ax in axes[-beside:]:
        ax.set_xlabel("$ε_θ$ / %")
    handles = [Line2D([], [], linestyle="", **look) for look in kinds.values()]
    style.finish_with(figure, origin, handles)
    return figure, data


caption = style.runs_counted


def _panel(ax: Axes, data: pd.DataFrame, scenes: list[tuple[str, str]], kinds: Mapping[str, Style]) -> None:
    ax.margins(x=0.05)
    for basis, look in kinds.items():
        rows = data[data["basis"].map(_kind) == basis]
        level = [scenes.index(scene) for scene in zip(rows["block"], rows["foundation"], strict=True)]
        shift = 0.22 * (list(MARKERS).index(basis) - 1)
        places = np.array(level, float) + shift
        ax.plot(100 * rows["epsilon_theta"], places, linestyle="", **look)


def _mark_failed(ax: Axes, fits: pd.DataFrame, scenes: list[tuple[str, str]]) -> None:
    for scene, own in fits.groupby(["block", "foundation"], sort=False):
        if n := int((~own["success"]).sum()):
            text = "failed fit" if n == 1 else f"{n} failed fits"
            look = {"fontsize": 0.85 * matplotlib.rcParams["legend.fontsize"], "color": style.FAILED}
            at = ax.get_yaxis_transform()
            ax.text(0.01, scenes.index(scene) + 0.3, text, transform=at, va="center", **look)


def _kind(basis: str) -> str:
    return basis if basis in MARKERS else ANOTHER
