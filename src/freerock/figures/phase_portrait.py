"""Phase portrait: angular rate against rotation, of a record and of the model that stands for it."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Drawing, Labels, printed
from freerock.products.groups import runs_of
from freerock.runs.angular_rate import angular_rate
from freerock.tables.swings import named_models

FIGURE = {
    "title": "Phase portrait",
    "caption": "Angular rate against rotation, from parabolas over 0.02 s, of the record and of the model "
    "that the choice names, or else of the fit with the least ε_θ. At most about 2000 evenly "
    "spaced samples of a run are drawn.",
    "reads": ["fits", "epsilon"],
}

OF_FITS = ("time", "theta", "theta_model")  # shown
COLUMNS = ["test", "run", "source", "time_s", "theta_deg", "rate_deg_s"]


@printed
def draw(fits: Sequence[xr.DataTree], epsilon: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """θ̇ against θ of the first fitted run of each dataset, one panel per block and foundation.

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets.
    epsilon : pandas.DataFrame
        Tidy table.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: source is "measured" or a model, time_s since the release.
    """
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    figure, panels = style.panel_per_scene(scenes, labels, 2.3)
    named = named_models(epsilon)
    parts = []
    for scene, tree in zip(scenes, fits, strict=True):
        number, run = next(iter(runs_of(tree).items()), (None, None))
        if run is None:
            panels[scene].text(0.5, 0.5, "no fitted run", transform=panels[scene].transAxes, ha="center")
            continue
        time_s = run.dataset["time"].values
        curves = {"measured": run.dataset["theta"].values}
        model = named.get((tree.attrs["test"], str(number)), "")
        if model in run.children:
            curves[model] = run.children[model].dataset["theta_model"].values
        for source, theta in curves.items():
            own = _curve(time_s, theta).assign(test=tree.attrs["test"], run=number, source=source)
            look = style.recorded(origin) if source == "measured" else looks.MODEL_STYLES[source]
            width = {"linewidth": style.scaled(2.2 if source == "measured" else 0.8)}
            panels[scene].plot(own["theta_deg"], own["rate_deg_s"], **look | width)
            parts.append(own[COLUMNS])
    for ax in panels.values():
        ax.margins(x=0.03)
    style.outer_labels(panels, "θ / °", "angular rate / (°/s)")
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)


caption = style.drawn_runs


def _curve(time_s: Floats, theta: Floats) -> pd.DataFrame:
    """Rotation and angular rate of some samples."""
    kept = style.thin(len(time_s), 2000)
    rate = np.degrees(angular_rate(time_s, theta))
    shown = {"theta_deg": np.degrees(theta[kept]), "rate_deg_s": rate[kept]}
    return pd.DataFrame({"time_s": time_s[kept], **shown})
