"""Figure of coverage: quantiles of the errors over their u against those of a normal number."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.special import ndtri

from freerock.figures import style
from freerock.figures.style import Drawing, styled

GROUPS = {"k, c, λ and r of runs": ("k", "c", "lambda", "r"), "r of each impact": ("r of an impact",)}
SIGNS = (("o", "black"), ("s", "#0072b2"), ("^", "#d55e00"), ("D", "0.5"))  # of the cases
FARTHEST = 4.0


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """A panel per group of numbers, a line per case; right intervals lie on the diagonal.

    Parameters
    ----------
    frame : pandas.DataFrame
        A row per case and number, as `freerock_bench.campaigns.graded` gives them.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns group, case, normal and error_over_u.
    """
    figure, parts = Figure(figsize=(style.WIDTH_IN, 3.2)), []
    axes = figure.subplots(1, len(GROUPS), squeeze=False, sharey=True)[0]
    for ax, (group, names) in zip(axes, GROUPS.items(), strict=True):
        own = frame[frame["parameter"].isin(names) & (frame["u"] > 0)]
        ax.plot([-3, 3], [-3, 3], color="0.6", linewidth=0.8)
        for (case, rows), (marker, shade) in zip(own.groupby("case", sort=False), SIGNS, strict=False):
            over_u = np.sort((rows["value"] - rows["truth"]) / rows["u"])
            normal = ndtri((np.arange(len(over_u)) + 0.5) / len(over_u))
            look = {"color": shade, "marker": marker, "markersize": 3, "linewidth": 0.5}
            ax.plot(
                normal, np.clip(over_u, -FARTHEST, FARTHEST), label=str(case).replace("σ_r", "$σ_r$"), **look
            )
            told = {"group": group, "case": case, "normal": normal, "error_over_u": over_u}
            parts.append(pd.DataFrame(told))
        ax.set(xlabel="normal quantile", ylim=(-1.05 * FARTHEST, 1.05 * FARTHEST))
        ax.set_title(group, loc="left")
    axes[0].set_ylabel("error / u")
    style.finish(figure, "")
    return figure, pd.concat(parts, ignore_index=True)
