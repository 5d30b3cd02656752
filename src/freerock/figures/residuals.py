"""Residuals against the noise at rest: their spectrum and autocorrelation."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from scipy.fft import irfft, rfft

from freerock.arrays import Floats
from freerock.figures.style import (
    MODEL_STYLES,
    Axes,
    Labels,
    Style,
    drawn_runs,
    footer,
    gathered,
    label,
    legend_on_top,
    panel,
    printed,
    scaled,
    size,
    wrapped,
)
from freerock.models.laws import LAWS, MODELS
from freerock.products.groups import runs_of
from freerock.products.runs import OVER_TIME, measured_in
from freerock.rotation.tapers import frequencies, tapered_power
from freerock.runs.noise import Noise, averaged, expected_power, samples_averaged

FIGURE = {
    "title": "Residuals of {block} against the noise at rest",
    "caption": "Left, power spectral density of modelled minus recorded rotation, with sine tapers, means "
    "over a sixth of an octave, and of the noise at rest of the same record. Right, "
    "autocorrelation of the residual; the band holds 95 % of that of white noise.",
    "reads": ["fits", "records"],
}

PER_OCTAVE = 6  # means of the spectrum
LONGEST_S = 0.5  # lag
COLUMNS = ["test", "run", "source", "quantity", "at", "value"]
REST = "noise at rest"


@printed
def draw(
    fits: Sequence[xr.DataTree], records: Sequence[xr.DataTree], origin: str, labels: Labels = None
) -> tuple[Figure, pd.DataFrame]:
    """Spectrum and autocorrelation of the residuals of the first fitted run of each dataset.

    Parameters
    ----------
    fits, records : sequence of xarray.DataTree
        Datasets; a row of panels for each of the former, with the noise at rest where its record is there.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`: source is a model or "noise at rest"; at is a frequency [Hz] where quantity is
        "density_deg2_hz" (of one side), a lag [s] where it is "autocorrelation".
    """
    by_test = {tree.attrs["test"]: tree for tree in records}
    figure = Figure(figsize=size(0.6 + 2.0 * len(fits)))
    axes = figure.subplots(len(fits), 2, squeeze=False, sharex="col")
    parts = []
    for i, tree in enumerate(fits):
        names = [label(labels, tree.attrs[key]) for key in ("block", "foundation")]
        axes[i, 0].set_title(wrapped(panel(i, len(fits), ", ".join(names)), 0.45), loc="left")
        axes[i, 0].set_ylabel("density / (deg²/Hz)")
        axes[i, 1].set_ylabel("autocorrelation / 1")
        number, run = next(iter(runs_of(tree).items()), (None, None))
        if run is None or number is None:
            axes[i, 0].text(0.5, 0.5, "no fitted run", transform=axes[i, 0].transAxes, ha="center")
            continue
        own, n = _of_run(by_test.get(tree.attrs["test"]), number, run)
        parts.append(own.assign(test=tree.attrs["test"], run=number)[COLUMNS])
        for source in [*LAWS, REST]:
            _plot(axes[i], own[own["source"] == source], source)
        inside = 1.96 / np.sqrt(n)
        axes[i, 1].axhspan(-inside, inside, color="0.85", linewidth=0)
    for left, right in axes:
        left.set(xscale="log", yscale="log")
        right.set_ylim(-1.05, 1.05)
    axes[-1, 0].set_xlabel("frequency / Hz")
    axes[-1, 1].set_xlabel("lag / s")
    legend_on_top(figure)
    footer(figure, origin)
    return figure, gathered(parts, COLUMNS)


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Which runs are drawn."""
    return drawn_runs(data)


def _plot(axes: Sequence[Axes], rows: pd.DataFrame, source: str) -> None:
    rest: Style = {"color": "0.6", "linewidth": 2.6, "linestyle": "-", "label": REST, "zorder": 1}
    look = rest if source == REST else MODEL_STYLES[source] | {"linewidth": 0.9}
    look = look | {"linewidth": scaled(look["linewidth"])}
    for ax, quantity in zip(axes, ("density_deg2_hz", "autocorrelation"), strict=True):
        own = rows[rows["quantity"] == quantity]
        if len(own):
            ax.plot(own["at"], own["value"], **look)


def _of_run(record: xr.DataTree | None, number: int, run: xr.DataTree) -> tuple[pd.DataFrame, int]:
    """Spectra and autocorrelations of a run, and how many averaged samples they are of."""
    motion = None
    if record is not None:
        samples = {name: record.dataset[name].values for name in OVER_TIME if name in record.dataset}
        motion = measured_in(record, samples).with_noise().get(number)
    noise = motion.noise if motion else None
    rate_hz = _rate_hz(run)
    m = noise.averaged if noise else samples_averaged(rate_hz)
    parts = []
    for model in MODELS:
        if model in LAWS and model in run.children:
            residual = averaged(_samples(run, model), m)
            at = frequencies(len(residual)) * rate_hz / m
            parts.append(
                _series(model, "density_deg2_hz", *_means(at, _density(tapered_power(residual), rate_hz)))
            )
            parts.append(_series(model, "autocorrelation", *_autocorrelation(residual, rate_hz / m)))
    n = len(averaged(_samples(run), m))
    if noise:
        parts.append(_series(REST, "density_deg2_hz", *_means(*_at_rest(noise, n, rate_hz))))
    return gathered(parts, COLUMNS[2:]), n


def _at_rest(noise: Noise, n: int, rate_hz: float) -> tuple[Floats, Floats]:
    return frequencies(n) * noise.rate_hz, _density(expected_power(noise, n), rate_hz)


def _density(power: Floats, rate_hz: float) -> Floats:
    """Density of one side [deg²/Hz] of the power of samples [rad²], whose sum is their variance."""
    return np.asarray(2 * np.degrees(1.0) ** 2 * power / rate_hz)


def _samples(run: xr.DataTree, model: str = "") -> Floats:
    """The residual of a model [rad], between its samples where one is missing; else the rotation."""
    if not model:
        return np.asarray(run.dataset["theta"].values)
    residual = run.children[model].dataset["residual"].values
    found = np.isfinite(residual)
    places = np.arange(len(residual))
    return np.asarray(np.interp(places, places[found], residual[found]))


def _rate_hz(run: xr.DataTree) -> float:
    time_s = run.dataset["time"].values
    return (len(time_s) - 1) / float(np.ptp(time_s))


def _means(at: Floats, power: Floats) -> tuple[Floats, Floats]:
    """Means over parts of an octave."""
    part = np.floor(PER_OCTAVE * np.log2(at / at[0])).astype(int)
    count = np.bincount(part)
    some = count > 0
    return tuple(np.bincount(part, values)[some] / count[some] for values in (at, power))  # type: ignore[return-value]


def _autocorrelation(residual: Floats, rate_hz: float) -> tuple[Floats, Floats]:
    """At lags up to `LONGEST_S`; of samples about zero, each sum over all products."""
    n = len(residual)
    power = np.abs(rfft(residual, 2 * n)) ** 2
    lags = min(n, round(LONGEST_S * rate_hz) + 1)
    sums = irfft(power, 2 * n)[:lags]
    return np.arange(lags) / rate_hz, np.asarray(sums / sums[0])


def _series(source: str, quantity: str, at: Floats, value: Floats) -> pd.DataFrame:
    return pd.DataFrame({"source": source, "quantity": quantity, "at": at, "value": value})
