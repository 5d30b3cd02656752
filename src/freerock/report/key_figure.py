"""The figure of the first screen: a run as measured and as modelled, and residuals over the noise, as SVG."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats, extremes
from freerock.figures.looks import on_screen
from freerock.models.laws import CANDIDATES, PAPER_MODELS
from freerock.products.groups import runs_of
from freerock.tables.candidates import answers
from freerock.tables.number_text import quantity

WIDTH, LEFT, RIGHT = 480.0, 46.0, 8.0  # of the drawing [px at its own scale]
PANELS = ((12.0, 178.0), (206.0, 364.0))  # top and bottom of the rotation and of the residuals
HEIGHT = 400.0
BINS = 300  # of a curve, with its lowest and highest value drawn in each
NOISE = 1.96  # standard deviations that are shaded: 95 % of white noise
LINEAR = 3.0  # standard deviations up to which the scale is linear


class Curve(NamedTuple):
    """A curve of a panel: its source, "measured" or a model, time [s] and values."""

    source: str
    time_s: Floats
    values: Floats


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
        test, run, sigma_deg (as text), drawing, keys (of the lines: source, label, colour, dash), chosen
        (label of the law that the choice names); None where no run was fitted.
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
    time, measured = (fitted.dataset[name].values for name in ("time", "theta"))
    theta, residuals = [_curve("measured", time, np.degrees(measured))], []
    for model in models:
        own = fitted.children[model].dataset
        theta.append(_curve(model, time, np.degrees(own["theta_model"].values)))
        residuals.append(_curve(model, time, own["residual"].values / sigma))
    residuals.sort(key=lambda each: float(np.nanmax(np.abs(each.values))))  # what is noise lies below
    looks = on_screen()
    return {
        "test": test,
        "run": number,
        "sigma_deg": quantity(math.degrees(sigma), digits=2),
        "chosen": looks[chosen]["label"] if chosen else "",
        "drawing": drawing(theta, residuals),
        "keys": [looks["measured"], *(looks[model] for model in models)],
    }


def drawing(theta: Sequence[Curve], residuals: Sequence[Curve]) -> dict[str, Any]:
    """Rotation over time above, residuals over σ below: what key_figure.svg.j2 draws.

    Parameters
    ----------
    theta : sequence of Curve
        Rotations [degree].
    residuals : sequence of Curve
        Model minus measured over the standard deviation of the noise.
    """
    end = max(each.time_s[-1] for each in theta)
    top = max(float(np.nanmax(np.abs(each.values))) for each in theta) * 1.05
    panels = [_panel(PANELS[0], theta, end, top, _steps(top), "θ / °")]
    if residuals:
        bent = [each._replace(values=_bend(each.values)) for each in residuals]
        most = max(1.5, *(float(np.nanmax(np.abs(each.values))) for each in bent)) * 1.05
        marks = [0.0, *(s * size for size in (LINEAR, 10.0, 100.0, 1000.0, 1e4) for s in (1, -1))]
        ticks = {float(_bend(np.array(mark))): _tick(mark) for mark in marks}
        shaded = tuple(float(each) for each in _bend(np.array([NOISE, -NOISE])))
        panels.append(_panel(PANELS[1], bent, end, most, ticks, "residual / σ", shaded))
    instants = [
        (LEFT + value / end * (WIDTH - LEFT - RIGHT), text)
        for value, text in _steps(end).items()
        if value >= 0
    ]
    sizes = {"width": WIDTH, "height": HEIGHT, "left": LEFT, "right": WIDTH - RIGHT}
    return {**sizes, "panels": panels, "instants": instants, "places": PANELS}


def _bend(values: Floats) -> Floats:
    """1 at `LINEAR`, linear up to there; a unit more for each power of ten beyond."""
    size = np.abs(values) / LINEAR
    return np.where(size <= 1, values / LINEAR, np.sign(values) * (1 + np.log10(np.maximum(size, 1.0))))


def _curve(source: str, time: Floats, values: Floats) -> Curve:
    drawn = extremes(values, BINS)
    return Curve(source, time[drawn], values[drawn])


def _panel(
    place: tuple[float, float],
    curves: Sequence[Curve],
    end: float,
    most: float,
    ticks: Mapping[float, str],
    label: str,
    shaded: tuple[float, ...] = (),
) -> dict[str, Any]:
    """A panel's place and label, ticks, shaded band and curves on the drawing."""
    top, bottom = place

    def y(value: Any) -> Any:
        return bottom - (value + most) / (most + most) * (bottom - top)

    lines = []
    for source, time_s, values in curves:
        x = LEFT + time_s / end * (WIDTH - LEFT - RIGHT)
        points = zip(x, y(values), strict=True)
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points if math.isfinite(b))
        lines.append({"points": path, **on_screen()[source]})
    known = {y(value): text for value, text in ticks.items() if -most <= value <= most}
    shade = [y(value) for value in shaded]
    return {"top": top, "bottom": bottom, "label": label, "ticks": known, "shade": shade, "lines": lines}


def _steps(most: float) -> dict[float, str]:
    """Round values between -most and most."""
    power = 10.0 ** math.floor(math.log10(most / 2))
    step = next(n * power for n in (1, 2, 5, 10) if most / (n * power) <= 4)
    n = int(most / step)
    return {i * step: _tick(i * step) for i in range(-n, n + 1)}


def _tick(value: float) -> str:
    return f"{value:g}".replace("-", "−")
