"""The figure of the first screen: a run as measured and as modelled, and residuals over the noise, as SVG."""

import io
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from freerock.arrays import Floats, extremes
from freerock.figures import style
from freerock.figures.looks import MEASURED, MODEL_STYLES, on_screen
from freerock.models.laws import CANDIDATES, PAPER_MODELS
from freerock.products.groups import runs_of
from freerock.tables.candidates import answers
from freerock.tables.number_text import quantity

SIZE_IN = (5.0, 4.2)
BINS = 300  # of a curve, with its lowest and highest value drawn in each
UNNAMED = dict.fromkeys(("Creator", "Date", "Format", "Type"))  # metadata
OPENS = (
    '<svg class="key" role="img" aria-label="Rotation as recorded and as modelled over time, and residuals '
)
OPENS += 'over the noise" '


def key_run(
    runs: pd.DataFrame, choice: pd.DataFrame, published: Mapping[str, Collection[str]]
) -> tuple[str, str] | None:
    """The run that is drawn: the first one without a warning that was fitted, of a published scene if any is.

    Parameters
    ----------
    runs, choice : pandas.DataFrame
        Tidy tables.
    published : mapping of str to collection of str
        Foundations with published values, by block.

    Returns
    -------
    (str, str) or None
        Test and number of the run; None where no run was fitted.
    """
    fitted = set(choice[["test", "run"]].astype(str).itertuples(index=False, name=None))
    ranked = [
        (row.verdict != "ok", row.foundation not in published.get(row.block, ()), i, (row.test, str(row.run)))
        for i, row in enumerate(runs.itertuples())
        if (row.test, str(row.run)) in fitted
    ]
    return min(ranked)[-1] if ranked else None


def key_figure(
    tables: Mapping[str, pd.DataFrame],
    opened: Callable[[str, bool], tuple[xr.DataTree, xr.DataTree]],
    published: Mapping[str, Collection[str]],
) -> dict[str, Any] | None:
    """The run that `key_run` names, drawn.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame
        runs and choice.
    opened : callable
        As for `freerock.report.page.write_report`.
    published : mapping of str to collection of str
        Foundations with published values, by block.

    Returns
    -------
    dict or None
        test, run, sigma_deg (as text), drawing (SVG), keys (of the lines: label, colour, dash), chosen (label
        of the law that the choice names); None where no run was fitted.
    """
    named = key_run(tables["runs"], tables["choice"], published)
    if named is None:
        return None
    test, number = named
    record, fits = opened(test, True)
    fitted = runs_of(fits)[int(number)]
    sigma = record.children[f"run_{number}"].dataset["sigma_theta"].item()
    chosen = next(each.model for each in answers(tables["choice"]) if (each.test, each.run) == named)
    models = [m for m in CANDIDATES if m in fitted.children and m in (*PAPER_MODELS, chosen)]
    looks = on_screen()
    return {
        "test": test,
        "run": number,
        "sigma_deg": quantity(math.degrees(sigma), digits=2),
        "chosen": looks[chosen]["label"] if chosen else "",
        "drawing": _drawing(fitted, models, sigma),
        "keys": [looks["measured"], *(looks[model] for model in models)],
    }


@style.styled({"svg.hashsalt": "freerock", "svg.fonttype": "none"})  # the same bytes each time
def _drawing(fitted: xr.DataTree, models: Sequence[str], sigma: float) -> Markup:
    """Rotation over time above, residuals over σ below, as SVG."""
    figure = Figure(figsize=SIZE_IN)
    motion, residual = figure.subplots(2, sharex=True)
    time_s, measured = (fitted.dataset[name].values for name in ("time", "theta"))
    own = {model: fitted.children[model].dataset for model in models}
    over_noise = {model: fit["residual"].values / sigma for model, fit in own.items()}
    furthest = {model: float(np.nanmax(np.abs(values))) for model, values in over_noise.items()}

    def draw(ax: style.Axes, values: Floats, look: style.Style) -> None:
        drawn = extremes(values, BINS)
        ax.plot(time_s[drawn], values[drawn], **look)

    draw(motion, np.degrees(measured), MEASURED)
    for model, fit in own.items():
        draw(motion, np.degrees(fit["theta_model"].values), MODEL_STYLES[model])
    for model in sorted(models, key=furthest.__getitem__):  # what is noise lies below
        draw(residual, over_noise[model], MODEL_STYLES[model])
    style.scale_by_noise(residual, max(furthest.values(), default=0.0))
    motion.set(ylabel="θ / °", xlim=(0, None))
    residual.set(ylabel="residual / σ", xlabel="time since release / s")
    with io.StringIO() as written:
        FigureCanvasSVG(figure).print_svg(written, metadata=UNNAMED)
        return Markup(OPENS + written.getvalue().partition("<svg ")[2])
