"""Figure of the study of shared foundations: how large a difference between blocks must be to be seen."""

from itertools import cycle

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled

MARKERS = "osD^v"


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Power over the difference of one block from the others, by the number of blocks and runs."""
    figure = Figure(figsize=(5.0, 3.4))
    ax = figure.subplots()
    alike = frame[frame["spreads"] == "alike"]
    for marker, ((blocks, runs), rows) in zip(
        cycle(MARKERS), alike.groupby(["n_blocks", "n_runs"], sort=False), strict=False
    ):
        ax.plot(
            rows["difference"], 100 * rows["seen"], marker=marker, label=f"{blocks} blocks, {runs} runs each"
        )
    ax.axhline(5, color="0.6", linewidth=0.8, linestyle=":")
    ax.set(xlabel="difference of k and λ / spread between runs", ylabel="seen / %", ylim=(0, 102))
    ax.legend(loc="lower right")
    headed(figure)
    return figure, frame
