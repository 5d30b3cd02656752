"""Contact of the selected law over the first swings: depth of the corners, and force."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, printed
from freerock.models.block import Block
from freerock.models.corners import corners_over_time
from freerock.models.laws import CANDIDATES, MODEL_LABELS, law_of
from freerock.populations.estimate import Estimate
from freerock.products.choices import named_in
from freerock.products.estimates import ESTIMATED, estimates_in
from freerock.products.groups import runs_of
from freerock.products.runs import sensors_view
from freerock.rotation.as_measured import as_released

FIGURE = {
    "title": "Contact over the first swings",
    "caption": "Depth of the two corners below the ground, and the contact force over the block's weight, of "
    "the law selected for the first run. The force is that of the law, since no sensor measured it.",
    "reading": "The corner that is down sinks deepest between two impacts and hands over to the other one. "
    "The peak of the force at an impact, in weights of the block, grows with the stiffness of "
    "the base. Both are computed from the fitted law, so they are as good as that law.",
    "reads": ["fits", "runs", "blocks", "debonding"],
}

OF_FITS = (*ESTIMATED, "impact_time")  # shown
SWINGS, N_SAMPLES = 3, 1500
LONGEST_S = 2.0
OF_ESTIMATE = ["test", "run", "block", "foundation", "model"]
COLUMNS = [*OF_ESTIMATE, "time_s", "left_mm", "right_mm", "force_over_weight"]


@printed
def draw(
    fits: Sequence[xr.DataTree],
    runs: pd.DataFrame,
    blocks: Mapping[str, Block],
    debonding: str,
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """Depth of the corners and force over weight up to the third impact, of the first run of each scene.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets.
    runs : pandas.DataFrame
        Tidy table, for the release angles of fits that free none.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`; scenes whose named law has no foundation are left out.
    """
    found = [(tree, estimate) for tree in fits if (estimate := _first(tree))]
    if not found:
        why = "no law of a compliant foundation is selected"
        return style.nothing_drawn(why, origin), pd.DataFrame(columns=COLUMNS)
    scenes = [(estimate.block, estimate.foundation) for _, estimate in found]
    figure, panels = style.panels_per_scene(scenes, labels, 2.1, (1.0, 1.0))
    angles = runs[["test", "run", "theta0_deg"]].itertuples(index=False)
    theta0 = {(test, str(run)): math.radians(angle) for test, run, angle in angles}
    parts = []
    for scene, (tree, estimate) in zip(scenes, found, strict=True):
        values = {"theta0": theta0[estimate.test, str(estimate.run)], **estimate.values}
        own = _over_time(tree, replace(estimate, values=values), blocks[scene[0]], debonding)
        parts.append(own)
        depth, force = panels[scene]
        _draw(depth, force, own)
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Which runs and laws are drawn."""
    named = [MODEL_LABELS[model] for model in CANDIDATES if model in set(data["model"])]
    return f"{style.drawn_runs(data)} {'Law' if len(named) == 1 else 'Laws'}: {'; '.join(named) or 'none'}."


def _first(tree: xr.DataTree) -> Estimate | None:
    """The fit of the law selected for the first run of a dataset that names one of a foundation."""
    named = {number: named_in(run) for number, run in runs_of(tree).items()}
    of_law = (each for each in estimates_in(tree) if each.model == named[each.run])
    return next((each for each in of_law if law_of(each.model).is_foundation), None)


def _over_time(tree: xr.DataTree, estimate: Estimate, block: Block, debonding: str) -> pd.DataFrame:
    fit = runs_of(tree)[estimate.run].children[estimate.model].dataset
    impacts = fit["impact_time"].values if "impact_time" in fit else np.empty(0)
    end = impacts[min(SWINGS, len(impacts)) - 1] if len(impacts) else LONGEST_S
    time_s = np.linspace(0.0, 1.03 * end, N_SAMPLES)
    view, turning = estimate.view_of(sensors_view(tree.attrs), block), estimate.block_of(block)
    values = as_released(CANDIDATES[estimate.model].law, turning, estimate.values, view)
    left, right, force = corners_over_time(estimate.model, turning, values, time_s, debonding)
    columns = {name: getattr(estimate, name) for name in OF_ESTIMATE} | {
        "time_s": time_s,
        "left_mm": 1e3 * left,
        "right_mm": 1e3 * right,
        "force_over_weight": force / turning.weight,
    }
    return pd.DataFrame(columns)


def _draw(depth: Axes, force: Axes, own: pd.DataFrame) -> None:
    sides = (("left_mm", "left corner", "#b34700", "--"), ("right_mm", "right corner", "#0a5bd3", "-"))
    for column, name, color, line in sides:
        below = own[column].clip(lower=0.0)
        depth.plot(own["time_s"], below, color=color, linestyle=line, label=name, linewidth=style.scaled(1.0))
    force.plot(own["time_s"], own["force_over_weight"], color="black", linewidth=style.scaled(0.8))
    force.axhline(1.0, color="0.45", linestyle=":", label="weight")
    for ax, text in ((depth, "depth / mm"), (force, "force / weight")):
        ax.set_ylim(bottom=0)
        if ax.get_subplotspec().is_first_col():
            ax.set_ylabel(text)
    force.set_xlabel("time since release / s")
