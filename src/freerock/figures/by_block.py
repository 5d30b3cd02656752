"""A panel for each block, in it the impacts of its runs and of the law selected for them, by foundation."""

from collections.abc import Callable, Mapping
from itertools import cycle
from typing import NamedTuple

import pandas as pd

from freerock.arrays import Floats
from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS
from freerock.tables.swings import named_swings

MARKERS = "osD^v"  # of the foundations
NARROWEST_IN = 2.1  # of a panel
HIGH_IN = 2.3


class Shown(NamedTuple):
    """What is drawn: two columns and their names, the uncertainty, and the curve of a rigid block."""

    x: str
    y: str
    x_label: str
    y_label: str
    rigid: Callable[[Block, pd.DataFrame], tuple[Floats, Floats]]
    y_u: str = ""


def foundation_looks(table: pd.DataFrame) -> dict[str, Style]:
    """Colour, line and marker of each foundation of a table."""
    looks = zip(cycle(style.FOUNDATION_STYLES), cycle(MARKERS))
    names = dict.fromkeys(table["foundation"])
    return {name: {**look, "marker": marker} for name, (look, marker) in zip(names, looks, strict=False)}


def by_block(
    shown: Shown,
    rows: Callable[[pd.DataFrame], pd.DataFrame] = lambda swings: swings,
    finish: Callable[[Axes, pd.DataFrame], object] = lambda ax, own: None,
) -> Callable[..., Drawing]:
    """The function `draw` of a figure of impacts: all runs, and the law of the first of each scene.

    Parameters
    ----------
    shown : Shown
    rows : callable
        The swings (`freerock.tables.swings.named_swings`) that are drawn, which become the figure's numbers.
    finish : callable
        Sets limits and scales of a panel, by its axes and numbers.
    """

    @styled()
    def draw(
        runs: pd.DataFrame,
        restitution: pd.DataFrame,
        epsilon: pd.DataFrame,
        blocks: Mapping[str, Block],
        origin: str,
        labels: Labels = None,
    ) -> Drawing:
        """All runs, and the law selected for the first run of each scene, in a panel for each block.

        Parameters
        ----------
        runs, restitution, epsilon : pandas.DataFrame
            Tidy tables.
        blocks : mapping of str to freerock.models.block.Block
            The blocks by name.

        Returns
        -------
        figure, data : Figure, pandas.DataFrame
            Columns of `freerock.tables.swings.swings`, and what the figure adds.
        """
        data = rows(named_swings(runs, restitution, epsilon, blocks))
        names = list(dict.fromkeys(runs["block"]))
        beside = style.fit_beside(len(names), NARROWEST_IN)
        figure, axes = style.panels_in_rows(len(names), beside, HIGH_IN, 0.5)
        panels = dict(zip(names, axes, strict=True))
        for i, (name, ax) in enumerate(panels.items()):
            own = data[data["block"] == name]
            x, y = shown.rigid(blocks[name], own[own["source"] == "experiment"])
            ax.plot(x, y, color="0.45", linestyle=":", label="rigid block (Housner 1963)")
            for foundation, look in foundation_looks(runs).items():
                scene = style.of_scene(own, name, foundation)
                _draw(ax, shown, scene, look, style.label(labels, foundation), origin)
            style.entitle(ax, i, len(names), style.label(labels, name), 0.8 / beside)
            ax.margins(x=0.04)
            finish(ax, own)
        style.outer_labels(panels, shown.x_label, shown.y_label, 0.9)
        style.finish(figure, origin)
        return figure, data

    return draw


def caption_of(point: str) -> Callable[..., str]:
    """The function `caption` of such a figure, whose points are impacts or what `point` says."""

    def caption(data: pd.DataFrame, labels: Labels = None) -> str:
        """How many points and runs are drawn, and the law of each line, which is of the first run alone."""
        seen = data[data["source"] == "experiment"]
        n = len(seen[["test", "run"]].drop_duplicates())
        told = f"{style.number_of(len(seen), point).capitalize()} of {style.number_of(n, 'run')}."
        laws = laws_told(data)
        return f"{told} Lines: the law fitted to the first run, {laws}." if laws else told

    return caption


def laws_told(data: pd.DataFrame) -> str:
    """The laws among some swings, each with its records where there are several laws."""
    models = data[data["source"] != "experiment"].drop_duplicates("test")
    of_law = {MODEL_LABELS[model]: ", ".join(own["test"]) for model, own in models.groupby("source")}
    return "; ".join(law if len(of_law) == 1 else f"{law} ({tests})" for law, tests in of_law.items())


def _draw(ax: Axes, shown: Shown, scene: pd.DataFrame, look: Style, name: str, origin: str) -> None:
    """A foundation: signs of what was recorded, a line of the law."""
    seen, law = (scene[(scene["source"] == "experiment") == own] for own in (True, False))
    if len(seen):
        points = {"linestyle": "", "markerfacecolor": "none", "markersize": 3.5, "markeredgewidth": 0.8}
        recorded = f"{name}, {style.recorded(origin)['label']}"
        ax.plot(seen[shown.x], seen[shown.y], **look | points, label=recorded)
        if shown.y_u:
            bars = {"fmt": "none", "ecolor": look["color"], "elinewidth": 0.8}
            ax.errorbar(seen[shown.x], seen[shown.y], yerr=seen[shown.y_u], **bars)
    if len(law):
        line = look | {"marker": "", "linewidth": 1.1}
        ax.plot(law[shown.x], law[shown.y], **line, label=f"{name}, law of the first run")
