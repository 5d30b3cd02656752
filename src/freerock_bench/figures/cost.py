"""Figure of the cost of a law against what it explains: a line per block, and the law that is named."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Drawing, Style, note_simulated, styled
from freerock.models.laws import MODEL_LABELS

FIGURE = {
    "caption": "Discrepancy of every candidate over that of the noise, by its number of parameters; a line "
    "joins the best of each number. Shaded: no more than noise. Ringed: the law that is named; further "
    "parameters explain no more. All runs are simulated."
}

NOISE = 1.15  # of the noise at rest, to which the residual of the true law may reach
LEAST = 0.5
LOOKS: tuple[Style, ...] = (
    {"color": "black", "marker": "o", "linestyle": "-"},
    {"color": "#0072b2", "marker": "s", "linestyle": "--"},
    {"color": "#d55e00", "marker": "^", "linestyle": "-."},
)
APART = 0.06  # between the marks of two blocks


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """ε_θ over that of the noise against the number of parameters, a line per block."""
    figure = Figure(figsize=(4.6, 3.6))
    ax = figure.subplots()
    ax.axhspan(LEAST, NOISE, color="0.9", linewidth=0)
    ax.text(0.99, 0.01, "noise of the sensor", transform=ax.transAxes, ha="right", va="bottom", fontsize=7)
    for i, ((block, truth), rows) in enumerate(frame.groupby(["block", "truth"], sort=False)):
        look, shift = LOOKS[i % len(LOOKS)], APART * (i - 1)
        places = rows["n_parameters"] + shift
        ax.plot(places, rows["over_noise"], **(look | {"linestyle": "", "alpha": 0.25, "markersize": 4}))
        best = rows[rows["least"]].drop_duplicates("n_parameters").sort_values("n_parameters")
        name = f"{block}: {MODEL_LABELS[str(truth)]}"
        ax.plot(best["n_parameters"] + shift, best["over_noise"], **look, markersize=5, label=name)
        ring = rows[rows["named"]]
        ax.plot(
            ring["n_parameters"] + shift,
            ring["over_noise"],
            "o",
            color=look["color"],
            markersize=12,
            markerfacecolor="none",
            markeredgewidth=1.2,
        )
    ax.set(yscale="log", xlabel="parameters of the law", ylim=(LEAST, None))
    ax.set_ylabel("$ε_θ$ of the fit / $ε_θ$ of the noise")
    counts = sorted(frame["n_parameters"].unique())
    ax.set_xticks(counts)
    ax.set_xlim(counts[0] - 0.2, counts[-1] + 0.2)
    ax.legend(title="block: law that moved it", loc="upper right", alignment="left")
    note_simulated(figure)
    return figure, frame
