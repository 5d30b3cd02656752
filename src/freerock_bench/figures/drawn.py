"""Figure of the study of drawn inputs: their pulls against the normal law, and what is named."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import norm

from freerock.figures.style import Labels, headed, styled
from freerock_bench.drawn import OUTCOMES, pulls_of, told

FIGURE = {
    "caption": "Pulls of inputs that are drawn from their stated uncertainty, against the normal law, and "
    "how often the true candidate is named. All runs are simulated.",
}

SHADES = ("0.75", "0.6", "0.4", "tab:orange", "tab:red")
FARTHEST = 4.0  # pull at the ends of the histogram


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Left the pulls of all inputs, right a bar of outcomes per part, instruments and kinematics."""
    figure = Figure(figsize=(7.0, 3.6))
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.3])
    pulls = pulls_of(frame)
    bins = np.linspace(-FARTHEST, FARTHEST, 33)
    left.hist(np.clip(pulls, -FARTHEST, FARTHEST), bins, color="0.75")
    grid = np.linspace(-FARTHEST, FARTHEST, 201)
    left.plot(grid, len(pulls) * (bins[1] - bins[0]) * norm.pdf(grid), color="0.2")
    beyond = f"{100 * np.mean(np.abs(pulls) > 2):.1f} % beyond 2" if len(pulls) else "no pulls"
    left.set_title(f"{len(pulls)} pulls: s.d. {np.std(pulls) if len(pulls) else 0:.2f}, {beyond}", loc="left")
    left.set(xlabel="pull", ylabel="inputs of runs")
    table = told(frame)
    names = [f"{row.part}, {row.instruments}, {row.kinematics}" for row in table.itertuples()]
    start = np.zeros(len(table))
    for outcome, shade in zip(OUTCOMES, SHADES, strict=True):
        right.barh(names, 100 * table[outcome], left=start, color=shade, label=outcome)
        start += 100 * table[outcome].to_numpy(float)
    right.invert_yaxis()
    right.set(xlabel="records / %", xlim=(0, 100))
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    headed(figure)
    return figure, table
