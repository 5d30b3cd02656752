"""Recorded θ(t) against the three laws: Spanos et al. 2017, figure 3 (doi:10.1016/j.proeng.2017.09.024)."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from freerock.figures import looks, style
from freerock.figures.style import LINEAR, Axes, Drawing, Labels, styled
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS, law_of
from freerock.products.contents import paper_fits, runs_of, selected_fit
from freerock.tables.number_text import percent

COLUMNS = ["test", "run", "block", "foundation", "source", "time_s", "theta_deg"]
COLUMNS += ["residual_over_theta0", "residual_over_sigma"]
READS = {"fits": ("time", "theta", "theta_model", "residual", "epsilon_theta")}
HEIGHT_IN, RATIOS = 2.08, (2.8, 0.9, 0.8)  # of a block's row, and of its panels
HEADROOM = 0.25  # above the curves, for ε_θ


@styled()
def draw(fits: Sequence[xr.DataTree], runs: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """θ(t) of a typical run on each foundation, the three laws by the paper's procedure, residuals.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets, one of each block and foundation.
    runs : pandas.DataFrame
        Tidy table, for the noise of each run.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: source is "measured", a law, or "selected"; residuals are modelled minus measured.
    """
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    sigma_deg = {
        (row.test, str(row.run)): row.sigma_theta_deg for row in runs.itertuples() if pd.notna(row.run)
    }
    figure, panels = style.panels_per_scene(scenes, labels, HEIGHT_IN, RATIOS)
    typical, parts = [_typical(runs_of(tree)) for tree in fits], []
    laws = {_selected(run) for _, run in typical if run is not None} - {""}
    told = f"Δθ/σ: {laws.pop() if len(laws) == 1 else 'selected law'}"
    for scene, tree, (number, run) in zip(scenes, fits, typical, strict=True):
        motion = panels[scene][0]
        if run is None:
            motion.text(0.5, 0.5, "no fitted run", transform=motion.transAxes, ha="center")
            continue
        own = _curves(run, sigma_deg[tree.attrs["test"], str(number)])
        _plot(panels[scene], own, origin, told)
        _tell(motion, number, run)
        parts.append(own.assign(test=tree.attrs["test"], run=number, block=scene[0], foundation=scene[1]))
    data = style.gathered(parts, COLUMNS).reindex(columns=COLUMNS)
    furthest = _furthest(data)
    tick = float(f"{0.7 * furthest:.0e}")
    for _, over_release, _ in panels.values():
        over_release.set_ylim(-furthest, furthest)
        over_release.set_yticks([-tick, 0, tick], [f"−{tick:g}", "", f"{tick:g}"])
    for axes, y in zip(zip(*panels.values(), strict=True), ("θ / °", "Δθ / α", "Δθ / σ"), strict=True):
        style.outer_labels(axes, "time since release / s" * y.endswith("σ"), y)
    style.finish(figure, origin)
    return figure, data


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """What Δθ over σ is where it is drawn; the runs drawn, or that there are none."""
    below = f"Below, Δθ over the noise σ of the selected law, impacts free; logarithmic beyond ±{LINEAR:g}. "
    return below * bool((data["source"] == "selected").any()) + style.drawn_runs(data)


def _selected(run: xr.DataTree) -> str:
    """Name of the candidate selected for a run; "" where none is."""
    return next((MODEL_LABELS[law] for law, _ in filter(None, [selected_fit(run)])), "")


def _typical(runs: Mapping[int, xr.DataTree]) -> tuple[int, xr.DataTree | None]:
    """The run whose ε_θ under the three laws are nearest their medians, and its number."""
    if not runs:
        return 0, None
    epsilon = pd.DataFrame(
        {
            number: {law: fit["epsilon_theta"].item() for law, fit in paper_fits(run).items()}
            for number, run in runs.items()
        }
    ).T
    off = np.log(epsilon / epsilon.median()).abs().sum(axis=1)
    number = int(off.idxmin())
    return number, runs[number]


def _furthest(data: pd.DataFrame) -> float:
    """Where the scale of Δθ/α ends: a rigid base does not rule it, whose law may lie far off."""
    sizes = data.assign(size=data["residual_over_theta0"].astype(float).abs()).groupby("source")["size"].max()
    sizes = sizes[[source in PAPER_MODELS for source in sizes.index]].dropna()
    soft = sizes[[law_of(law).is_foundation for law in sizes.index]]
    known = soft if len(soft) else sizes
    return 1.05 * float(known.max()) if len(known) and known.max() else 1.0


def _curves(run: xr.DataTree, sigma_deg: float) -> pd.DataFrame:
    """A run, the laws by the paper's own procedure, and the residual of the selected law."""
    drawn = style.thin(run.sizes["time"])
    time_s, measured = (run.dataset[name].values[drawn] for name in ("time", "theta"))
    release = abs(np.degrees(run.dataset["theta"].values[0]))
    parts = [pd.DataFrame({"source": "measured", "time_s": time_s, "theta_deg": np.degrees(measured)})]
    for law, fit in paper_fits(run).items():
        if fit.attrs["success"]:
            theta_deg = np.degrees(fit["theta_model"].values[drawn])
            of_release = (theta_deg - np.degrees(measured)) / release
            own = {"time_s": time_s, "theta_deg": theta_deg, "residual_over_theta0": of_release}
            parts.append(pd.DataFrame({"source": law, **own}))
    if selected := selected_fit(run):
        residual_deg = np.degrees(selected[1]["residual"].values[drawn])
        own = {"time_s": time_s, "residual_over_sigma": residual_deg / sigma_deg}
        parts.append(pd.DataFrame({"source": "selected", **own}))
    return pd.concat(parts, ignore_index=True)


def _plot(axes: Sequence[Axes], own: pd.DataFrame, origin: str, told: str) -> None:
    """A run and its laws, the residuals of these below."""
    motion, over_release, over_noise = axes
    for source, rows in own.groupby("source", sort=False):
        if source == "measured":
            motion.plot(rows["time_s"], rows["theta_deg"], **style.recorded(origin))
        elif source == "selected":
            look = {"color": "black", "linewidth": 0.4, "label": told}
            over_noise.plot(rows["time_s"], rows["residual_over_sigma"], **look)
            style.scale_by_noise(over_noise, float(rows["residual_over_sigma"].abs().max()), few=True)
        else:
            look = looks.line_of(str(source))
            motion.plot(rows["time_s"], rows["theta_deg"], **look)
            over_release.plot(rows["time_s"], rows["residual_over_theta0"], **look | {"label": None})
    motion.set_xlim(left=0)


def _tell(motion: Axes, number: int, run: xr.DataTree) -> None:
    """The run and ε_θ of each law above the curves, and what stands for it where its fit failed."""
    fits = paper_fits(run).values()
    epsilon = [percent(fit["epsilon_theta"].item()) if fit.attrs["success"] else "failed" for fit in fits]
    low, high = motion.get_ylim()
    motion.set_ylim(low, high + HEADROOM * (high - low))
    told = f"run {number}; $ε_θ$: {', '.join(epsilon)} %"
    motion.text(0.99, 0.97, told, ha="right", va="top", transform=motion.transAxes)
