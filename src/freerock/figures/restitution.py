"""Restitution per impact, the comparison Spanos et al. 2017 mention and leave out for want of space."""

from matplotlib.figure import Figure

from freerock.figures.style import MODEL_STYLES, footer, label, styled
from freerock.models import MODELS

MARKERS = {"housner": "", "winkler": "s", "hunt_crossley": "^", "general": "v"}


@styled()
def restitution(runs, impacts, blocks, labels=None):
    """Restitution of each impact against the peak before it, one panel per block and foundation.

    Parameters
    ----------
    runs, impacts : pandas.DataFrame
        Tidy tables runs and restitution, see `freerock.tables`; failed and excluded runs are left out.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        Columns of the table restitution.
    """
    usable = runs[(runs["verdict"] != "fail") & ~runs["excluded"]]
    data = impacts.merge(usable[["test", "run"]])
    rows, columns = (list(dict.fromkeys(runs[key])) for key in ("block", "foundation"))

    figure = Figure(figsize=(max(3.5 * len(columns), 4.5), 0.5 + 2.0 * len(rows)))
    axes = figure.subplots(len(rows), len(columns), squeeze=False, sharex="row", sharey="row")
    for i, block in enumerate(rows):
        for j, foundation in enumerate(columns):
            scene = data[(data["block"] == block) & (data["foundation"] == foundation)]
            _panel(axes[i, j], scene, blocks[block].restitution_housner)
            axes[i, j].set_title(f"{label(labels, block)}, {label(labels, foundation)}", loc="left")
        axes[i, 0].set_ylabel("restitution r")
    for ax in axes[-1]:
        ax.set_xlabel("peak |θ| before the impact / °")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    footer(figure, runs["origin"].iloc[0])
    return figure, data


def _panel(ax, scene, r_housner):
    ax.margins(x=0.05)
    ax.axhline(r_housner, color="0.45", linestyle=":", label="1 − 1.5 sin²θ$_{cr}$ (rigid)")
    for model in MODELS:
        style = MODEL_STYLES[model] | {"marker": MARKERS[model], "markersize": 2.5, "linewidth": 0.8}
        for k, (_, run) in enumerate(scene[scene["source"] == model].groupby(["test", "run"], sort=False)):
            ax.plot(run["peak_before_deg"], run["r"], **style | ({"label": "_"} if k else {}))
    measured = scene[scene["source"] == "experiment"]
    ax.errorbar(
        measured["peak_before_deg"],
        measured["r"],
        yerr=measured["r_stderr"],
        fmt="o",
        color="0.45",
        markerfacecolor="none",
        markersize=5,
        elinewidth=0.8,
        label="measured",
    )
