"""Residuals of the selected law against the noise at rest, octave by octave."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.ticker import NullLocator
from scipy.special import chdtri

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, styled
from freerock.products.contents import runs_of, selected_fit

COLUMNS = ["test", "run", "source", "frequency_hz", "density_deg2_hz", "over_rest"]
READS = {"fits": ("time", "residual"), "records": ("frequency", "noise_density")}
CHANCE = "noise: 999 of 1000 runs"
LEAST, MOST = 0.5, 20.0  # that an axis shows: two powers of ten have their numbers
APART = 1.5  # frequencies of a Hann window's periodogram per independent value


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
        Columns `COLUMNS`: source is a candidate or `CHANCE`, the limit of which is that of the first run; the
        density is of one side, over_rest is it over that at rest.
    """
    by_test = {tree.attrs["test"]: tree for tree in records}
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    figure, panels = style.panel_per_scene(scenes, labels, 1.9, sharex=True)
    parts = []
    for scene, tree in zip(scenes, fits, strict=True):
        record = by_test.get(tree.attrs["test"])
        own = _of_record(record, tree) if record is not None else pd.DataFrame()
        if own.empty:
            panels[scene].text(0.5, 0.5, "no fitted run", transform=panels[scene].transAxes, ha="center")
            continue
        _panel(panels[scene], own)
        parts.append(own.assign(test=tree.attrs["test"]))
    style.outer_labels(panels.values(), "frequency / Hz", "power / noise")
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)[COLUMNS]


caption = style.drawn_runs


def _panel(ax: Axes, own: pd.DataFrame) -> None:
    """A scene: the limit of chance, and the residual of each run."""
    seen = own["over_rest"][own["over_rest"] > 0]
    ends = min(LEAST, 0.8 * seen.min()), max(MOST, 1.25 * seen.max())
    for (source, _), rows in own.groupby(["source", "run"], sort=False):
        drawn = rows["frequency_hz"], rows["over_rest"]
        if source == CHANCE:
            ax.fill_between(*drawn, ends[0], color="0.9", linewidth=0, label=CHANCE)
        else:
            look = looks.MODEL_STYLES[str(source)] | {"linewidth": 0.6}
            ax.plot(*drawn, **look | {"marker": ".", "markersize": 4})
    ax.axhline(1.0, color="0.55", linewidth=1.2, zorder=1, label="noise at rest")
    ax.set(xscale="log", yscale="log", ylim=ends, xmargin=0.03)
    for axis in (ax.xaxis, ax.yaxis):  # plain numbers at powers of ten: formulas and small ticks take time
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def _of_record(record: xr.DataTree, fits: xr.DataTree) -> pd.DataFrame:
    """Residuals of all runs by octave, and the limit of chance of the first."""
    parts: list[pd.DataFrame] = []
    if "noise_density" not in record.dataset:
        return pd.DataFrame()
    middle, at_rest = (record.dataset[name].values for name in ("frequency", "noise_density"))
    for number, run in runs_of(fits).items():
        if (selected := selected_fit(run)) is None:
            continue
        density, n = octaves(run.dataset["time"].values, selected[1]["residual"].values, middle)
        found = {selected[0]: density / at_rest}
        if not parts:
            dof = np.maximum(2 * n / APART, 1.0)
            found[CHANCE] = chdtri(dof, 1e-3 / len(middle)) / dof
        for source, over_rest in found.items():
            of_source = {"frequency_hz": middle, "over_rest": over_rest, "source": source, "run": number}
            known = pd.DataFrame(of_source).assign(density_deg2_hz=np.degrees(1) ** 2 * over_rest * at_rest)
            parts.append(known[n > 0])
    return style.gathered(parts, COLUMNS[1:])


def octaves(time_s: Floats, residual: Floats, middle_hz: Floats) -> tuple[Floats, Floats]:
    """Mean one-sided spectral density of a residual [rad²/Hz] over octaves, and frequencies in each.

    Samples that are missing lie between their neighbours. Shape (n_octaves,) each.
    """
    found = np.isfinite(residual)
    whole = np.interp(time_s, time_s[found], residual[found])
    n_all, step_s = len(whole), float(np.median(np.diff(time_s)))
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n_all) / n_all)
    at = np.fft.rfftfreq(n_all, step_s)
    density = 2 * step_s * np.abs(np.fft.rfft(hann * (whole - whole.mean()))) ** 2 / (hann @ hann)
    edges = np.append(middle_hz / np.sqrt(2), middle_hz[-1] * np.sqrt(2))
    octave = np.digitize(at, edges) - 1
    inside = (octave >= 0) & (octave < len(middle_hz))
    n = np.bincount(octave[inside], minlength=len(middle_hz))
    total = np.bincount(octave[inside], density[inside], len(middle_hz))
    return total / np.maximum(n, 1), n.astype(float)
