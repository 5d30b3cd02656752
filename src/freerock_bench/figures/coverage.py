"""Figure of any study on the harness: how often nominal 95 % intervals hold the truth."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from scipy.stats import binom

from freerock.figures.style import Drawing, note_simulated, styled
from freerock.models.free_parameters import SYMBOLS
from freerock_bench.harness import coverage

FIGURE = {
    "caption": "How often nominal 95 % intervals hold the truth, in per cent, by case and number: of the "
    "standard error by noise, and of the total uncertainty. Framed: a miss, so few as chance gives in less "
    "than one of 100 cells. All runs are simulated."
}

INTERVALS = {"inside_stderr": "standard error", "inside": "total uncertainty"}
NOMINAL, CHANCE = 0.95, 0.01
DARKEST, DARK = 60, 78  # per cent; below, text is white


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """A heat map for the interval of the standard error and one for the total, misses framed."""
    rows = coverage(frame)
    figure = Figure(figsize=(7.0, 1.0 + 0.17 * rows["case"].nunique()))
    axes = figure.subplots(1, len(INTERVALS), squeeze=False, sharey=True)[0]
    for ax, (column, label) in zip(axes, INTERVALS.items(), strict=True):
        _panel(ax, rows, column)
        ax.set_title(label, loc="left")
    note_simulated(figure)
    return figure, rows


def _panel(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    """Shares by case and number; a cell without runs stays blank."""
    cases, numbers = list(rows["case"].unique()), list(rows["parameter"].unique())
    shares = np.full((len(cases), len(numbers)), np.nan)
    for row in rows.itertuples():
        y, x = cases.index(row.case), numbers.index(row.parameter)
        share = shares[y, x] = getattr(row, column)
        dark = "white" if share < DARK else "black"
        ax.text(x, y, f"{share:.0f}", ha="center", va="center", fontsize=6, color=dark)
        if binom.cdf(round(share / 100 * row.n), row.n, NOMINAL) < CHANCE:
            frame = Rectangle((x - 0.47, y - 0.45), 0.94, 0.9, fill=False, edgecolor="#d55e00", linewidth=1.2)
            ax.add_patch(frame)
    ax.imshow(shares, cmap="Blues_r", vmin=DARKEST, vmax=100, aspect="auto")
    ax.grid(False)
    ax.set_xticks(range(len(numbers)), [SYMBOLS.get(name, name.replace("_", " ")) for name in numbers])
    ax.set_yticks(range(len(cases)), cases, fontsize=6)
    ax.tick_params(length=0)
