"""Measured against modelled θ(t): Spanos et al. 2017, figure 3 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from freerock.figures import style
from freerock.figures.style import Labels, printed
from freerock.models.laws import LAWS
from freerock.products.groups import runs_of
from freerock.tables.text import quantity


@printed
def draw(fits: Sequence[xr.DataTree], origin: str, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """θ(t) of the first fitted run of each dataset beside the laws fitted to it, residuals below.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets, as a rule those of one block.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns test, run, source ("measured" or a model), time_s (since the release), theta_deg, residual_deg
        (model minus measured).
    """
    drawn = [(tree, *next(iter(runs_of(tree).items()), (None, None))) for tree in fits]
    figure = Figure(figsize=style.size(0.5 + 3.0 * len(fits)))
    axes = figure.subplots(2 * len(fits), squeeze=False, height_ratios=[2.2, 1] * len(fits))[:, 0]
    parts = []
    for i, (tree, number, run) in enumerate(drawn):
        motion, residual = axes[2 * i : 2 * i + 2]
        residual.sharex(motion)
        motion.tick_params(labelbottom=False)
        names = [style.label(labels, tree.attrs[key]) for key in ("block", "foundation")]
        shown = "" if run is None else f": {style.of_run(tree.attrs['test'], number)}"
        title = style.panel(i, len(drawn), ", ".join(names) + shown)
        motion.set_title(style.wrapped(title, 0.9), loc="left")
        motion.set_ylabel("θ / °")
        residual.set_ylabel("residual / °")
        residual.set_xlabel("time since release / s")
        if run is None:
            motion.text(0.5, 0.5, "no fitted run", transform=motion.transAxes, ha="center")
            continue
        curves = _curves(tree, number, run)
        parts.append(curves)
        measured = curves[curves["source"] == "measured"]
        thick = style.MEASURED | {"linewidth": style.scaled(style.MEASURED["linewidth"])}
        motion.plot(measured["time_s"], measured["theta_deg"], **thick)
        for model in LAWS:
            own = curves[curves["source"] == model]
            if len(own):
                look = style.MODEL_STYLES[model]
                fit = run.children[model].dataset
                epsilon = quantity(100 * fit["epsilon_theta"].item())
                failed = "" if fit["success"].item() else " (failed fit)"
                named = look | {"label": f"{look['label']}, $ε_θ$ = {epsilon} %{failed}"}
                motion.plot(own["time_s"], own["theta_deg"], **named)
                residual.plot(own["time_s"], own["residual_deg"], **look)
        motion.set_xlim(left=0)
        style.legend_above(motion)
    figure.align_ylabels(axes)
    style.footer(figure, origin)
    columns = ["test", "run", "source", "time_s", "theta_deg", "residual_deg"]
    return figure, style.gathered(parts, columns)


def _curves(tree: xr.DataTree, number: int, run: xr.DataTree) -> pd.DataFrame:
    drawn = style.thin(run.sizes["time"])
    measured = run.dataset["theta"].values[drawn]
    sources = {"measured": measured}
    sources |= {
        model: run.children[model].dataset["theta_model"].values[drawn]
        for model in LAWS
        if model in run.children
    }
    return pd.concat(
        pd.DataFrame(
            {
                "test": tree.attrs["test"],
                "run": number,
                "source": source,
                "time_s": run.dataset["time"].values[drawn],
                "theta_deg": np.degrees(theta),
                "residual_deg": np.degrees(theta - measured),
            }
        )
        for source, theta in sources.items()
    )
