"""Recorded against modelled θ(t): Spanos et al. 2017, figure 3 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from freerock.figures import style
from freerock.figures.style import Labels, printed
from freerock.models.laws import CANDIDATES, LAWS
from freerock.products.choices import GROUP
from freerock.products.groups import runs_of
from freerock.tables.text import fixed, quantity

FIGURE = {
    "title": "{Measured} rotation of {block} and the models fitted to it",
    "caption": "Rotation θ and the models fitted to it, as in figure 3 of Spanos et al. 2017; below, "
    "modelled minus recorded rotation over σ, the standard deviation of one sample of θ at rest. "
    "The grey band is ±1.96 σ: a model that leaves nothing but white noise is inside it for 95 % "
    "of the samples. The scale is linear up to ±3 σ and logarithmic beyond. ε_θ is the relative "
    "mean square discrepancy.",
    "reads": ["fits", "runs"],
}

OF_FITS = ("time", "theta", "theta_model", "epsilon_theta", "success")  # shown
COLUMNS = ["test", "run", "source", "time_s", "theta_deg", "residual_deg", "residual_over_sigma"]
SIGMA = ["test", "run", "sigma_theta_deg"]
LINEAR = 3.0  # σ up to which the scale of the residuals is linear
INSIDE = 1.96  # σ, between which 95 % of white noise lies


@printed
def draw(
    fits: Sequence[xr.DataTree], runs: pd.DataFrame, origin: str, labels: Labels = None
) -> tuple[Figure, pd.DataFrame]:
    """θ(t) of the first fitted run of each dataset beside its models, residuals over σ below.

    The models are the laws, and the candidate that the choice names for the run.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets, as a rule those of one block.
    runs : pandas.DataFrame
        Tidy table, for the noise of each run.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns test, run, source ("measured" or a model), time_s (since the release), theta_deg, residual_deg
        (model minus measured) and residual_over_sigma.
    """
    drawn = [(tree, *next(iter(runs_of(tree).items()), (None, None))) for tree in fits]
    sigma_deg = {(test, str(run)): sigma for test, run, sigma in runs[SIGMA].itertuples(index=False)}
    figure = Figure(figsize=style.size(0.5 + 3.0 * len(fits)))
    axes = figure.subplots(2 * len(fits), squeeze=False, height_ratios=[1.9, 1.2] * len(fits))[:, 0]
    parts = []
    for i, (tree, number, run) in enumerate(drawn):
        motion, residual = axes[2 * i : 2 * i + 2]
        residual.sharex(motion)
        motion.tick_params(labelbottom=False)
        names = [style.label(labels, tree.attrs[key]) for key in ("block", "foundation")]
        title = style.panel(i, len(drawn), ", ".join(names))
        motion.set_title(style.wrapped(title, 0.9), loc="left")
        motion.set_ylabel("θ / °")
        residual.set_ylabel("residual / σ")
        residual.set_xlabel("time since release / s")
        if run is None:
            motion.text(0.5, 0.5, "no fitted run", transform=motion.transAxes, ha="center")
            continue
        curves = _curves(tree, number, run, sigma_deg[tree.attrs["test"], str(number)])
        parts.append(curves)
        measured = curves[curves["source"] == "measured"]
        motion.plot(measured["time_s"], measured["theta_deg"], **style.recorded(origin))
        residual.axhspan(-INSIDE, INSIDE, color="0.85", linewidth=0)
        for model in _models(run):
            own = curves[curves["source"] == model]
            if len(own):
                look = style.MODEL_STYLES[model]
                fit = run.children[model].dataset
                epsilon = quantity(100 * fit["epsilon_theta"].item())
                failed = (
                    ""
                    if fit["success"].item()
                    else " (stops rocking)"
                    if "in_phase_r" in fit.attrs
                    else " (failed fit)"
                )
                named = look | {"label": f"{look['label']}, $ε_θ$ = {epsilon} %{failed}"}
                motion.plot(own["time_s"], own["theta_deg"], **named)
                thin = look | {"linewidth": style.scaled(0.7)}
                residual.plot(own["time_s"], own["residual_over_sigma"], **thin)
        motion.set_xlim(left=0)
        residual.set_yscale("symlog", linthresh=LINEAR)
        furthest = curves["residual_over_sigma"].abs().max()
        decades = [10.0**power for power in range(1, 7) if 10**power < furthest]
        ticks = [-each for each in decades[::-1]] + [0.0] + decades
        residual.set_yticks(ticks, [fixed(tick, 0) for tick in ticks])
        residual.minorticks_off()
        style.legend_above(motion)
    figure.align_ylabels(axes)
    style.footer(figure, origin)
    return figure, style.gathered(parts, COLUMNS)


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Which runs are drawn."""
    return style.drawn_runs(data)


def _models(run: xr.DataTree) -> list[str]:
    """The laws that were fitted to a run, and the candidate named for it."""
    named = str(run.children[GROUP].attrs["selected"]) if GROUP in run.children else ""
    return [model for model in CANDIDATES if model in run.children and (model in LAWS or model == named)]


def _curves(tree: xr.DataTree, number: int, run: xr.DataTree, sigma_deg: float) -> pd.DataFrame:
    drawn = style.thin(run.sizes["time"])
    measured = run.dataset["theta"].values[drawn]
    sources = {"measured": measured}
    sources |= {model: run.children[model].dataset["theta_model"].values[drawn] for model in _models(run)}
    return pd.concat(
        pd.DataFrame(
            {
                "test": tree.attrs["test"],
                "run": number,
                "source": source,
                "time_s": run.dataset["time"].values[drawn],
                "theta_deg": np.degrees(theta),
                "residual_deg": np.degrees(theta - measured),
                "residual_over_sigma": np.degrees(theta - measured) / sigma_deg,
            }
        )
        for source, theta in sources.items()
    )
