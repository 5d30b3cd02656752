"""Figure of any study on the harness: how often nominal 95 % intervals hold the truth."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled
from freerock.models.laws import SYMBOLS
from freerock_bench.harness import coverage

FIGURE = {
    "caption": "How often nominal 95 % intervals hold the truth, by case and number: of the standard error "
    "by noise, and of the total uncertainty. All runs are simulated.",
}

INTERVALS = {"inside_stderr": ("standard error", "white"), "inside": ("total uncertainty", "black")}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """A panel per number, a row per case: shares of the standard error's and the total interval."""
    rows = coverage(frame)
    numbers, cases = list(rows["parameter"].unique()), list(rows["case"].unique())
    figure = Figure(figsize=(7.0, 1.2 + 0.24 * len(cases)))
    axes = figure.subplots(1, len(numbers), squeeze=False, sharey=True)[0]
    for ax, name in zip(axes, numbers, strict=True):
        own = rows[rows["parameter"] == name]
        at = [cases.index(case) for case in own["case"]]
        for column, (label, face) in INTERVALS.items():
            ax.plot(own[column], at, "o", color="black", markerfacecolor=face, label=label)
        ax.axvline(95, color="0.6", linewidth=0.8, linestyle=":")
        ax.set_title(SYMBOLS.get(name, name.replace("_", " ")), loc="left")
        ax.set(xlim=(-4, 104), xlabel="inside / %")
    axes[0].set_yticks(range(len(cases)), cases)
    axes[0].set_ylim(len(cases) - 0.5, -0.5)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    headed(figure)
    return figure, rows
