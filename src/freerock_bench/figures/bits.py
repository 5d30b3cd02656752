"""Figure of the study of converters: verdicts, noise and k against the step of the converter."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Drawing, note_simulated, styled
from freerock_bench.bits import told

FIGURE = {
    "caption": "Clean records through converters of 8 to 24 bits over ±10.5 V, against a step of the "
    "converter over the standard deviation of the noise: shares with the verdict ok, with σ within 5 %, and "
    "with k inside its 95 % interval. All records are simulated."
}

PANELS = {"ok": "verdict ok / %", "sigma": "σ within 5 % / %", "k": "k inside / %"}
LOOKS = (("o", "-"), ("s", "--"), ("^", "-."))
NOMINAL = {"k": 95}  # of its interval


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """A panel per share, a line per noise."""
    shares = told(frame)
    figure = Figure(figsize=(7.2, 2.8))
    for ax, (name, label) in zip(figure.subplots(1, len(PANELS), sharex=True), PANELS.items(), strict=True):
        for (marker, line), (sigma_mv, own) in zip(LOOKS, shares.groupby("sigma_mv"), strict=False):
            ax.plot(own["steps"], own[name], marker=marker, linestyle=line, label=f"{sigma_mv:g} mV")
        if name in NOMINAL:
            ax.axhline(NOMINAL[name], color="0.6", linewidth=0.8, linestyle=":")
        ax.set(xscale="log", xlabel="step of the converter / σ", ylabel=label, ylim=(0, 104))
        ax.margins(x=0.05)
    ax.legend(title="noise", loc="lower left", alignment="left")
    note_simulated(figure)
    return figure, shares
