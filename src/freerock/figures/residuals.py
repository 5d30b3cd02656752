"""Residuals of the selected law against the noise at rest: the decision whether it explains a run."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.figures import looks, style
from freerock.figures.style import Drawing, Labels, Style, printed
from freerock.products.choices import named_in
from freerock.products.groups import runs_of
from freerock.products.runs import OVER_TIME, measured_in
from freerock.rotation.tapers import frequencies, tapered_power
from freerock.runs.noise_spectrum import averaged, expected_power, samples_averaged

FIGURE = {
    "title": "Residuals against the noise at rest",
    "caption": "Power spectral density of modelled minus recorded rotation, of the law selected for each "
    "run, with sine tapers, means over a sixth of an octave; grey, that of the noise at rest of the "
    "same record. A law explains a run if its residual exceeds the noise in no octave by more than chance. "
    "At frequencies lower than a rest resolves, the noise is extrapolated.",
    "reading": "Follow each line from left to right against the grey one. A law is rejected where its line "
    "stands well above the noise, most often near the rocking frequency. Lines that scatter "
    "about the grey one, at low frequencies by a factor of several, are noise.",
    "reads": ["fits", "records"],
}

PER_OCTAVE = 6  # means of the spectrum
COLUMNS = ["test", "run", "source", "frequency_hz", "density_deg2_hz"]
REST = "noise at rest"
OF_FITS = ("time", "theta", "residual")  # shown
OF_REST: Style = {"color": "0.72", "linewidth": 2.6, "linestyle": "-", "label": REST, "zorder": 1}


@printed
def draw(
    fits: Sequence[xr.DataTree], records: Sequence[xr.DataTree], origin: str, labels: Labels = None
) -> Drawing:
    """Spectrum of the residual of all fitted runs of each dataset, and of the noise at rest.

    Parameters
    ----------
    fits, records : sequence of xarray.DataTree
        Datasets; a panel for each of the former, with the noise at rest where its record is there.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: source is a model or "noise at rest", the density is of one side.
    """
    by_test = {tree.attrs["test"]: tree for tree in records}
    scenes = [(tree.attrs["block"], tree.attrs["foundation"]) for tree in fits]
    figure, panels = style.panel_per_scene(scenes, labels, 1.9, sharex=True)
    parts = []
    for scene, tree in zip(scenes, fits, strict=True):
        ax, runs = panels[scene], runs_of(tree)
        if not runs:
            ax.text(0.5, 0.5, "no fitted run", transform=ax.transAxes, ha="center")
            continue
        own = _of_record(by_test.get(tree.attrs["test"]), runs).assign(test=tree.attrs["test"])
        parts.append(own)
        for (source, _), rows in own.groupby(["source", "run"], sort=False):
            of_law = {"linewidth": 0.8, "linestyle": "-"}
            look = OF_REST if source == REST else looks.MODEL_STYLES[source] | of_law
            ax.plot(rows["frequency_hz"], rows["density_deg2_hz"], **style.sized(look))
        ax.set(xscale="log", yscale="log")
        style.whole_decades(ax.yaxis)
    style.outer_labels(panels, "frequency / Hz", "density / (deg²/Hz)")
    style.finish(figure, origin)
    return figure, style.gathered(parts, COLUMNS)[COLUMNS]


caption = style.drawn_runs


def _of_record(record: xr.DataTree | None, runs: dict[int, xr.DataTree]) -> pd.DataFrame:
    """Spectra of the residuals of all runs, and of the noise at rest of the first."""
    motions = {}
    if record is not None:
        samples = {name: record.dataset[name].values for name in OVER_TIME if name in record.dataset}
        motions = measured_in(record, samples).with_noise()
    parts: list[pd.DataFrame] = []
    for number, run in runs.items():
        motion, rate_hz = motions.get(number), _rate_hz(run)
        noise = motion.noise if motion else None
        m = noise.averaged if noise else samples_averaged(rate_hz)
        n = len(averaged(np.asarray(run.dataset["theta"].values), m))
        if noise and not parts:
            at, power = frequencies(n) * noise.rate_hz, expected_power(noise, n)
            parts.append(_spectrum(REST, number, at, power, rate_hz))
        if model := named_in(run):
            residual = averaged(_residual(run, model), m)
            at = frequencies(len(residual)) * rate_hz / m
            parts.append(_spectrum(model, number, at, tapered_power(residual), rate_hz))
    return style.gathered(parts, COLUMNS[1:])


def _residual(run: xr.DataTree, model: str) -> Floats:
    """The residual of a model [rad], between its samples where one is missing."""
    residual = run.children[model].dataset["residual"].values
    found = np.isfinite(residual)
    places = np.arange(len(residual))
    return np.asarray(np.interp(places, places[found], residual[found]))


def _rate_hz(run: xr.DataTree) -> float:
    time_s = run.dataset["time"].values
    return (len(time_s) - 1) / float(np.ptp(time_s))


def _spectrum(source: str, run: int, at: Floats, power: Floats, rate_hz: float) -> pd.DataFrame:
    """Density of one side of the power of samples [rad²], whose sum is their variance; means over parts of
    an octave."""
    density = 2 * np.degrees(1.0) ** 2 * power / rate_hz
    part = np.floor(PER_OCTAVE * np.log2(at / at[0])).astype(int)
    count = np.bincount(part)
    some = count > 0
    means = {
        name: np.bincount(part, values)[some] / count[some]
        for name, values in (("frequency_hz", at), ("density_deg2_hz", density))
    }
    return pd.DataFrame({"source": source, "run": run, **means})
