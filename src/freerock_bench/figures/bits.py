"""Figure of the study of converters: clean runs that are ok, σ that is right, k that is inside."""

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled
from freerock_bench.bits import told

FIGURE = {
    "caption": "Clean records through converters of 8 to 24 bits over ±10.5 V, under noise of 1, 2 and 5 mV: "
    "runs that are ok, σ within 5 %, and k within 1.96 standard errors. All records are simulated.",
}

SHOWN = {"ok": "run is ok", "sigma": "σ within 5 %", "k": "k within 1.96 stderr"}
STYLES = {"ok": ("black", "o"), "sigma": ("#0072b2", "s"), "k": ("#d55e00", "D")}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Shares of the records over the bits of the converter: a panel per noise.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        As of `bits.told`.
    """
    data = told(frame)
    sigmas = data["sigma_mv"].unique()
    figure = Figure(figsize=(7.0, 2.8))
    axes = figure.subplots(1, len(sigmas), squeeze=False, sharey=True)[0]
    for ax, sigma_mv in zip(axes, sigmas, strict=True):
        rows = data[data["sigma_mv"] == sigma_mv]
        for column, text in SHOWN.items():
            color, marker = STYLES[column]
            ax.plot(range(len(rows)), rows[column], color=color, marker=marker, label=text)
        ax.axhline(95, color="0.5", linestyle=":")
        ax.set_xticks(range(len(rows)), [f"{bits:g}" for bits in rows["bits"]])
        ax.set_xlabel("bits over ±10.5 V")
        ax.set_title(f"noise of {sigma_mv:g} mV", loc="left")
    axes[0].set_ylabel("records / %")
    axes[0].set_ylim(0, 105)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(SHOWN))
    headed(figure)
    return figure, data
