"""Figure of the study of runs that scatter: how often the intervals of mean, next run and τ hold."""

import math

import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, headed, styled
from freerock.models.laws import SYMBOLS

HELD = {"inside": "mean", "next_inside": "next run", "tau_inside": "τ"}
STYLES = {
    "inside": {"color": "black", "fmt": "o"},
    "next_inside": {"color": "#0072b2", "fmt": "s"},
    "tau_inside": {"color": "#d55e00", "fmt": "D"},
}


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Share of the records whose intervals hold, with its 95 % limits: a panel per parameter.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        n_runs, spread, parameter, n_records; of mean, next_run and tau the share inside [%]; rms_ratio, the
        root-mean-square error of the mean over that of the mean of the runs' own truths, where these differ.
    """
    data = summary(frame)
    parameters = data["parameter"].unique()
    figure = Figure(figsize=(7.0, 2.8))
    axes = figure.subplots(1, len(parameters), squeeze=False, sharey=True)[0]
    for ax, parameter in zip(axes, parameters, strict=True):
        rows = data[data["parameter"] == parameter]
        for k, (column, text) in enumerate(HELD.items()):
            share = rows[f"{column}_percent"]
            limits = 196 * ((share / 100) * (1 - share / 100) / rows["n_records"]).map(math.sqrt)
            places = [i + 0.2 * (k - 1) for i in range(len(rows))]
            ax.errorbar(places, share, yerr=limits, label=text, **STYLES[column])
        ax.axhline(95, color="0.5", linestyle=":")
        names = [f"{row.n_runs} runs\n± {100 * row.spread:g} %" for row in rows.itertuples()]
        ax.set_xticks(range(len(rows)), names)
        ax.set_xlim(-0.5, len(rows) - 0.5)
        ax.set_title(f"Hunt–Crossley {SYMBOLS[parameter]}", loc="left")
    axes[0].set_ylabel("intervals that hold / %")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(HELD))
    headed(figure)
    return figure, data


def summary(frame: pd.DataFrame) -> pd.DataFrame:
    """The columns that `draw` returns."""
    rows = []
    for (n_runs, spread, parameter), own in frame.groupby(["n_runs", "spread", "parameter"], sort=False):
        of_truths = math.sqrt((own["error_of_truths"] ** 2).mean())
        rows.append(
            {
                "n_runs": n_runs,
                "spread": spread,
                "parameter": parameter,
                "n_records": len(own),
                **{f"{name}_percent": 100 * own[name].mean() for name in HELD},
                "rms_ratio": math.sqrt((own["error"] ** 2).mean()) / of_truths if spread else math.nan,
            }
        )
    return pd.DataFrame(rows)
