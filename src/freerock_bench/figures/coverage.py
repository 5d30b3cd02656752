"""Figure of the study of coverage: scatter against the Cramér-Rao bound, and honest intervals."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from freerock.figures.style import MODEL_STYLES, Axes, Labels, Style, headed, label, styled
from freerock.models.laws import MODEL_LABELS, PARAMETERS, SYMBOLS

DAMPINGS = {name for name, parameter in PARAMETERS.items() if parameter.ratio_unit}
NOISE_MARKERS = {
    "white": "o",
    "mains and drift": "^",
    "2 ms": "v",
    "20 ms": "<",
    "200 ms": ">",
    "white and slow": "D",
    "mains": "s",
    "step 0.5 σ": "1",
    "step 2 σ": "2",
    "step 5 σ": "3",
}


def coverage_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Scatter and coverage of each scene, law, noise and parameter.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock_bench.coverage.run`.

    Returns
    -------
    pandas.DataFrame
        n fits that succeeded, failed, efficiency (standard deviation over the Cramér-Rao bound), bias (mean
        error in bounds), claimed (root mean square of the standard errors over that of the errors) and
        covered, the share of the 95 % intervals that hold the truth.
    """
    rows = []
    keys = ["block", "foundation", "model", "noise", "parameter"]
    for key, group in frame.groupby(keys, sort=False):
        good = group[group["stderr"].notna()]
        squares = np.mean(good["stderr"] ** 2) / np.mean((good["value"] - good["truth"]) ** 2)
        error = (good["value"] - good["truth"]) / good["bound"]
        inside = (good["ci95_low"] <= good["truth"]) & (good["truth"] <= good["ci95_high"])
        rows.append(
            {
                **dict(zip(keys, key, strict=True)),
                "n": len(good),
                "failed": len(group) - len(good),
                "efficiency": error.std(),
                "bias": error.mean(),
                "claimed": np.sqrt(squares),
                "covered": inside.mean(),
            }
        )
    return pd.DataFrame(rows)


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """Scatter over the Cramér-Rao bound, and coverage of the 95 % intervals, scene by scene.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        `coverage_summary`.
    """
    summary = coverage_summary(frame)
    figure = Figure(figsize=(7.0, 4.4))
    upper, lower = figure.subplots(2, 1, sharex=True)
    scenes = list(dict.fromkeys(zip(summary["block"], summary["foundation"], strict=True)))
    quantities = list(dict.fromkeys(zip(summary["model"], summary["parameter"], strict=True)))
    width = 0.8 / len(quantities)
    for i, (model, parameter) in enumerate(quantities):
        own = summary[(summary["model"] == model) & (summary["parameter"] == parameter)]
        for noise, marker in NOISE_MARKERS.items():
            rows = own[own["noise"] == noise]
            levels = [scenes.index(s) for s in zip(rows["block"], rows["foundation"], strict=True)]
            x = np.array(levels, float) + (i - (len(quantities) - 1) / 2) * width
            style = _style(model, parameter) | {"marker": marker, "markersize": 4}
            if noise == "white":
                error = rows["efficiency"] / np.sqrt(2 * rows["n"])
                upper.errorbar(x, rows["efficiency"], error, linewidth=0.8, **style)
            error = np.sqrt(0.95 * 0.05 / rows["n"])
            lower.errorbar(x, 100 * rows["covered"], 100 * error, linewidth=0.8, **style)
    _frame(upper, lower)
    names = [f"{label(labels, block)}\n{label(labels, foundation)}" for block, foundation in scenes]
    lower.set(xticks=range(len(scenes)))
    lower.set_xlim(-0.5, len(scenes) - 0.5)
    lower.set_xticklabels(names)
    figure.legend(handles=_legend(quantities, set(summary["noise"])), loc="outside lower center", ncols=4)
    headed(figure)
    return figure, summary


def _frame(upper: Axes, lower: Axes) -> None:
    """What is aimed at, and within what."""
    upper.axhline(1.0, color="0.5", linewidth=0.8)
    upper.axhline(1.1, color="0.5", linewidth=0.8, linestyle=":")
    upper.set(ylabel="scatter / Cramér–Rao bound")
    for y, style in ((95, "-"), (93, ":"), (97, ":")):
        lower.axhline(y, color="0.5", linewidth=0.8, linestyle=style)
    lower.set(ylabel="truth in the 95 % interval / %")


def _style(model: str, parameter: str) -> Style:
    filled = {"markerfacecolor": "white" if parameter in DAMPINGS else None}
    return {"color": MODEL_STYLES[model]["color"], "linestyle": "", **filled}


def _legend(quantities: list[tuple[str, str]], noises: set[str]) -> list[Line2D]:
    handles = [
        Line2D(
            [],
            [],
            marker="o",
            label=f"{MODEL_LABELS[model]} {SYMBOLS[parameter]}",
            **_style(model, parameter),
        )
        for model, parameter in quantities
    ]
    handles += [
        Line2D([], [], color="0.3", marker=marker, linestyle="", label=f"noise: {noise}")
        for noise, marker in NOISE_MARKERS.items()
        if noise in noises
    ]
    return handles
