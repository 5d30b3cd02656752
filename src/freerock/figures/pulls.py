"""Pulls and impacts: shift of each input by the fits, and its effect on the parameters."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, printed
from freerock.models.free_parameters import SYMBOLS
from freerock.tables.candidates import of_selected
from freerock.tables.number_text import INPUT_LABELS

FIGURE = {
    "title": "Pulls of the inputs, and their impacts on the parameters",
    "caption": "Left: shift of each input by the fit of the selected law, over its standard uncertainty u; "
    "bars: u after the fit. Open: the run does not depend on the input. Shaded: ±1 and ±2. Right: "
    "shift of each parameter if the input is one remaining uncertainty higher and all else is "
    "fitted again, in per cent; medians of the runs.",
    "reads": ["pulls", "choice"],
}

OF_INPUT = ["input_owner", "input"]
MOST_ROWS = 40
SPREAD = 0.6  # of a row, over which its runs are drawn
PANELS = {"inputs": "shift by the fit / u of the input", "impacts": "impact on the parameter / %"}
SHADES = ((2.0, "0.94"), (1.0, "0.86"))


@printed
def draw(pulls: pd.DataFrame, choice: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Shift of each input by the fit of each run, and the shift of the parameters by what remains of it.

    Parameters
    ----------
    pulls, choice : pandas.DataFrame
        Tidy tables. Of each run the fit that the choice names, where it moved its inputs.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of the table pulls, inputs with the largest impact first.
    """
    data = of_selected(pulls, choice)
    if data.empty:
        return style.nothing_drawn("no run moved its inputs", origin), data
    names = [name for name in looks.HATCHES if _impact(name) in data and data[_impact(name)].notna().any()]
    largest = data[[_impact(name) for name in names]].abs().max(axis=1)
    order = largest.groupby([data[name] for name in OF_INPUT]).max().sort_values(ascending=False)
    of_input = dict(iter(data.groupby(OF_INPUT)))
    rows = {row: of_input[row] for row in order.index[:MOST_ROWS]}
    figure = Figure(figsize=style.size(0.9 + 0.26 * max(3, len(rows))))
    left, right = figure.subplots(1, 2, sharey=True)
    for place, own in enumerate(rows.values()):
        _pulls(left, place, own)
        _impacts(right, place, own, names)
    for limit, grey in SHADES:
        left.axvspan(-limit, limit, color=grey, zorder=0)
    for i, (ax, (title, x)) in enumerate(zip((left, right), PANELS.items(), strict=True)):
        ax.axvline(0.0, color="0.4", linewidth=0.6)
        ax.set_title(style.panel(i, 2, title), loc="left")
        ax.set_xlabel(x)
        ax.grid(axis="y", visible=False)
    right.locator_params(axis="x", nbins=5)
    style.rows_down(left, [_name(row, labels) for row in rows])
    style.finish(figure, origin)
    return figure, pd.concat(rows.values(), ignore_index=True)


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """How many runs there are, how many inputs were defaults, and the largest pull."""
    if data.empty:
        return "No run has a fit of its selected law that moved its inputs."
    n_runs = len(data[["test", "run"]].drop_duplicates())
    inputs = data.drop_duplicates(OF_INPUT)
    told = f"Fits of {n_runs} run{'s' * (n_runs != 1)}; {len(inputs)} inputs"
    assumed = int((~inputs["input_stated"].astype(bool)).sum())
    told += f", {assumed} of them with a default uncertainty." if assumed else "."
    if data["input_pull"].isna().all():
        return told
    most = data.loc[data["input_pull"].abs().idxmax()]
    name = INPUT_LABELS.get(most["input"], most["input"])
    return f"{told} Largest pull: {most['input_pull']:+.1f}, of the {name} of {most['input_owner']}."


def _pulls(ax: Axes, place: int, rows: pd.DataFrame) -> None:
    """Shift of an input by each run, with what remains of its uncertainty."""
    at = place + np.linspace(-SPREAD / 2, SPREAD / 2, len(rows)) * (len(rows) > 1)
    known = rows["input_pull"].notna().to_numpy()
    for which, face, text in ((known, "black", "run"), (~known, "white", "run that does not see the input")):
        if which.any():
            own = rows[which]
            dots = {"fmt": "o", "markersize": 3, "color": "black", "markerfacecolor": face}
            bars = {"xerr": own["input_remaining"], "elinewidth": 0.7}
            ax.errorbar(own["input_moved"], at[which], **bars, **dots, label=text)


def _impacts(ax: Axes, place: int, rows: pd.DataFrame, names: list[str]) -> None:
    """Median impact of an input over the runs, a bar for each parameter, with its sign."""
    height = 0.8 / len(names)
    for i, name in enumerate(names):
        median = float(rows[_impact(name)].median())
        if np.isfinite(median):
            middle = place + (i - (len(names) - 1) / 2) * height
            look = {"color": f"{0.35 + 0.15 * i:.2f}", "hatch": looks.HATCHES[name], "edgecolor": "black"}
            ax.barh(middle, median, height=0.9 * height, linewidth=0.4, label=SYMBOLS[name], **look)


def _impact(name: str) -> str:
    return f"impact_{name}_percent"


def _name(row: tuple[str, str], labels: Labels) -> str:
    """The input, and the block, laser or foundation that has it."""
    owner, name = row
    return f"{INPUT_LABELS.get(name, name)}, {style.label(labels, owner)}"
