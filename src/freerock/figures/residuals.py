"""Residuals of the selected law against the noise at rest: the decision whether it explains a run."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Drawing, Labels, Style, styled
from freerock.identification.against_noise import noise_of, octave_limits
from freerock.noise.spectrum import Noise, averaged, expected_power, frequencies, tapered_power
from freerock.products.choices import named_in
from freerock.products.groups import runs_of
from freerock.products.runs import OVER_TIME, measured_in
from freerock.runs.motion import Motion

COLUMNS = ["test", "run", "source", "frequency_hz", "density_deg2_hz", "over_rest"]
REST, CHANCE = "noise at rest", "within chance"
OF_FITS = ("time", "theta", "residual")  # shown
OF_REST: Style = {"color": "0.55", "linewidth": 1.2, "linestyle": "-", "label": REST, "zorder": 1}
LEAST, MOST = 0.5, 20.0  # that an axis shows: two powers of ten have their numbers


@styled()
def draw(
    fits: Sequence[xr.DataTree], records: Sequence[xr.DataTree], origin: str, labels: Labels = None
) -> Drawing:
    """Power of the residual of all fitted runs of each dataset over that of the noise at rest, by octave.

    Parameters
    ----------
    fits, records : sequence of xarray.DataTree
        Datasets; a panel for each of the former, empty where its record is not there.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: source is a model, "noise at rest" or "within chance", the limit of which is that
        of the first run; the density is of one side, over_rest is it over that at rest.
    """
    by_test = {tree.attrs["test"]: tree for tree in records}
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    figure, panels = style.panel_per_scene(scenes, labels, 1.9, sharex=True)
    parts = []
    for scene, tree in zip(scenes, fits, strict=True):
        ax, record = panels[scene], by_test.get(tree.attrs["test"])
        own = _of_record(record, runs_of(tree)) if record is not None else pd.DataFrame()
        if own.empty:
            ax.text(0.5, 0.5, "no fitted run", transform=ax.transAxes, ha="center")
            continue
        parts.append(own.assign(test=tree.attrs["test"]))
        seen = own["over_rest"][np.isfinite(own["over_rest"])]
        ends = min(LEAST, 0.8 * seen[seen > 0].min()), max(MOST, 1.25 * seen.max())
        for (source, _), rows in own.groupby(["source", "run"], sort=False):
            drawn = rows["frequency_hz"], rows["over_rest"]
            if source == CHANCE:
                ax.fill_between(*drawn, ends[0], color="0.9", linewidth=0, label=CHANCE)
            else:
                look = looks.MODEL_STYLES.get(source, {}) | {"linewidth": 0.6, "linestyle": "-"}
                look |= {"marker": ".", "markersize": 4}
                ax.plot(*drawn, **OF_REST if source == REST else look)
        ax.set(xscale="log", yscale="log", ylim=ends, xmargin=0.03)
        style.whole_decades(ax.yaxis)
    style.outer_labels(panels, "frequency / Hz", "power / noise")
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)[COLUMNS]


caption = style.drawn_runs


def _of_record(record: xr.DataTree, runs: dict[int, xr.DataTree]) -> pd.DataFrame:
    """Residuals of all runs by octave; the noise at rest, and the limit of chance, of the first."""
    samples = {name: record.dataset[name].values for name in OVER_TIME if name in record.dataset}
    motions: dict[int, Motion] = measured_in(record, samples)
    parts: list[pd.DataFrame] = []
    for number, run in runs.items():
        model = named_in(run)
        if not model or number not in motions:
            continue
        noise = noise_of(motions[number])
        residual = averaged(_residual(run, model), noise.averaged)
        at, at_rest = frequencies(len(residual)), expected_power(noise, len(residual))
        own = {model: tapered_power(residual - residual.mean()) / at_rest}
        if not parts:
            own[CHANCE], own[REST] = octave_limits(noise, len(residual))[noise.band(at)], np.ones(len(at))
        for source, over_rest in own.items():
            parts.append(_by_octave(over_rest, noise, at, at_rest).assign(source=source, run=number))
    return style.gathered(parts, COLUMNS[1:])


def _residual(run: xr.DataTree, model: str) -> Floats:
    """The residual of a model [rad], between its samples where one is missing."""
    residual = run.children[model].dataset["residual"].values
    found = np.isfinite(residual)
    places = np.arange(len(residual))
    return np.asarray(np.interp(places, places[found], residual[found]))


def _by_octave(over_rest: Floats, noise: Noise, at: Floats, at_rest: Floats) -> pd.DataFrame:
    """Means over each octave of a power over that at rest; the density of one side is in proportion."""
    octave = noise.band(at)
    count = np.bincount(octave)
    some = count > 0
    frequency, power, over = (
        np.bincount(octave, values)[some] / count[some] for values in (at, at_rest, over_rest)
    )
    rate_hz = noise.rate_hz * noise.averaged
    density = 2 * np.degrees(1.0) ** 2 * power / rate_hz
    return pd.DataFrame(
        {"frequency_hz": frequency * noise.rate_hz, "density_deg2_hz": over * density, "over_rest": over}
    )
