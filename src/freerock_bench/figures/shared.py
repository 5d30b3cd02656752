"""Figure of the study of shared foundations: how large a difference between blocks must be to be seen."""

from itertools import cycle

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Drawing, note_simulated, styled

FIGURE = {
    "caption": "How often blocks that differ in k and λ are told apart, by the number of blocks and runs. "
    "All runs are simulated."
}

MARKERS = "osD^v<"


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """Power over the difference of one block from the others by the runs of each block; false alarms of all
    cases without a difference, and of the test that takes all spreads for the same."""
    figure = Figure(figsize=(7.2, 3.4))
    power, alarms = figure.subplots(1, 2, width_ratios=(3, 2))
    curves = frame.groupby("runs", sort=False).filter(lambda rows: rows["difference"].any())
    alike = curves[(curves["unlike"] == "none") & (curves["correlation"] > 0)]
    for marker, (runs, rows) in zip(cycle(MARKERS), alike.groupby("runs", sort=False), strict=False):
        power.plot(rows["difference"], 100 * rows["seen"], marker=marker, label=f"{runs} runs")
    power.axhline(5, color="0.6", linewidth=0.8, linestyle=":")
    power.set(xlabel="difference of k and λ / spread between runs", ylabel="seen / %", ylim=(0, 102))
    power.legend(loc="lower right")

    none = frame[frame["difference"] == 0]
    pooled = alarms.scatter(none["spread_ratio"], 100 * none["seen_pooled"], marker="x", color="0.5")
    own = alarms.scatter(none["spread_ratio"], 100 * none["seen"], marker="o", color="C0")
    alarms.axhline(7, color="0.6", linewidth=0.8, linestyle=":")
    alarms.set(xlabel="spread of one block / others'", ylabel="false alarms / %", xticks=(1, 2, 4))
    alarms.set(ylim=(0, None), xlim=(0.5, 4.5))
    alarms.legend([own, pooled], ["own spreads", "one spread"], loc="upper left")
    note_simulated(figure)
    return figure, frame
