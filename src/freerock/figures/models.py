"""Recorded against modelled θ(t): Spanos et al. 2017, figure 3 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, styled
from freerock.models.laws import MODEL_LABELS
from freerock.products.choices import explained_in, named_in
from freerock.products.groups import runs_of
from freerock.tables.number_text import between, quantity

FIGURE = {
    "title": "{Measured} rotation and the law selected for it",
    "caption": "Rotation θ of all runs of a record and the law selected for each, as in figure 3 of Spanos "
    "et al. 2017; below, modelled minus recorded rotation Δθ over σ, the standard deviation of one "
    "sample of θ at rest. 95 % of white noise lies between the yellow lines, ±1.96 σ. "
    "The scale is linear up to ±3 σ and logarithmic beyond. Of each run, about 1000 samples are drawn.",
    "reading": "The black line hides in the grey record if the law follows the motion. Look at the lower "
    "panel: of a law that explains a run, all but one sample in 20 lie between the lines, from release "
    "to rest. A wave there that grows or keeps time with the impacts shows what the law lacks.",
    "reads": ["fits", "runs"],
}

OF_FITS = ("time", "theta", "theta_model", "epsilon_theta", "success")  # shown
COLUMNS = ["test", "run", "source", "time_s", "theta_deg", "residual_deg", "residual_over_sigma"]
SIGMA = ["test", "run", "sigma_theta_deg"]


@styled()
def draw(fits: Sequence[xr.DataTree], runs: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """θ(t) of all fitted runs of each dataset and the law that the choice names, residuals over σ below.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets, one of each block and foundation.
    runs : pandas.DataFrame
        Tidy table, for the noise of each run.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns test, run, source ("measured" or a model), time_s (since the release), theta_deg, residual_deg
        (model minus measured) and residual_over_sigma.
    """
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    sigma_deg = {(test, str(run)): sigma for test, run, sigma in runs[SIGMA].itertuples(index=False)}
    figure, panels = style.panels_per_scene(scenes, labels, 2.3, (1.5, 1.0))
    parts: list[pd.DataFrame] = []
    for scene, tree in zip(scenes, fits, strict=True):
        motion, residual = panels[scene]
        if motion.get_subplotspec().is_first_col():
            motion.set_ylabel("θ / °")
            residual.set_ylabel("Δθ / σ")
        residual.set_xlabel("time since release / s")
        fitted = runs_of(tree)
        if not fitted:
            motion.text(0.5, 0.5, "no fitted run", transform=motion.transAxes, ha="center")
            continue
        test = tree.attrs["test"]
        curves = {
            number: _curves(run, sigma_deg[test, str(number)]).assign(test=test, run=number)
            for number, run in fitted.items()
        }
        parts += curves.values()
        for number, own in curves.items():
            _plot(motion, residual, own, named_in(fitted[number]), origin)
        right = {"transform": motion.transAxes, "ha": "right", "va": "top", "fontsize": "small"}
        motion.text(0.99, 0.99, "\n".join(_laws(fitted)), **right)
        furthest = max(own["residual_over_sigma"].abs().max() for own in curves.values())
        style.scale_by_noise(residual, furthest)
        motion.set_xlim(left=0)
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)[COLUMNS]


caption = style.drawn_runs


def _laws(fitted: Mapping[int, xr.DataTree]) -> list[str]:
    """The range of ε_θ of each named law; its name where there are several; whether it is rejected."""
    found: dict[str, list[tuple[float, bool]]] = {}
    for run in fitted.values():
        if model := named_in(run):
            epsilon = 100 * run.children[model].dataset["epsilon_theta"].item()
            found.setdefault(model, []).append((epsilon, explained_in(run)))
    told = []
    for model, each in found.items():
        low, high = (end(epsilon for epsilon, _ in each) for end in (min, max))
        alike = quantity(low, digits=2)
        span = alike if alike == quantity(high, digits=2) else between(low, high, digits=2, apart=False)
        name = f"{MODEL_LABELS[model]}: " if len(found) > 1 else ""
        rejected = "" if all(explains for _, explains in each) else ", rejected"
        told.append(f"{name}$ε_θ$ = {span} %{rejected}")
    return told


def _plot(motion: Axes, residual: Axes, own: pd.DataFrame, model: str, origin: str) -> None:
    """A run and its law."""
    measured, modelled = (own[own["source"] == source] for source in ("measured", model))
    motion.plot(measured["time_s"], measured["theta_deg"], **style.recorded(origin))
    if len(modelled):
        look = looks.MODEL_STYLES[model]
        motion.plot(modelled["time_s"], modelled["theta_deg"], **look | {"linewidth": 0.8})
        thin = {"linewidth": 0.4, "linestyle": "-", "color": look["color"]}
        residual.plot(modelled["time_s"], modelled["residual_over_sigma"], **thin)


def _curves(run: xr.DataTree, sigma_deg: float) -> pd.DataFrame:
    """A run and its law."""
    drawn = style.thin(run.sizes["time"])
    time_s, measured = (run.dataset[name].values[drawn] for name in ("time", "theta"))
    sources = {"measured": measured}
    if model := named_in(run):
        sources[model] = run.children[model].dataset["theta_model"].values[drawn]
    parts = []
    for source, theta in sources.items():
        residual_deg = np.degrees(theta - measured)
        own = {"time_s": time_s, "theta_deg": np.degrees(theta), "residual_deg": residual_deg}
        own["residual_over_sigma"] = residual_deg / sigma_deg
        parts.append(pd.DataFrame({"source": source, **own}))
    return pd.concat(parts)
