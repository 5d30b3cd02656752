"""Figures of the Monte-Carlo studies of the identification."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from freerock.figures.style import MODEL_STYLES, headed, label, styled
from freerock.models.laws import MODEL_LABELS, SYMBOLS

OUTCOMES = {  # of a fit: how it is drawn
    "global minimum": {"color": "0.6", "marker": ".", "markersize": 2},
    "reported as failed": {"color": "#0072b2", "marker": "s", "markersize": 5},
    "missed": {"color": "#d55e00", "marker": "X", "markersize": 7},
}
NOISE_MARKERS = {"white": "o", "hum and drift": "^"}
IMPERFECTIONS = {
    "none": "none",
    "centre": "centre of mass\n0.3 mm off",
    "uneven": "uneven\nbase",
    "amplitude": "damping grows\nwith amplitude",
}
FAR, NEAR = 5.0, 1.0  # distances [σ] beyond which laws can, and below which they can't, be told apart


@styled()
def success(frame, labels=None):
    """Random truths and whether the fit from the automatic start ended in the global minimum.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.identification.success`.
    labels : mapping of str to str, optional
        Not used.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    figure = Figure(figsize=(7.0, 2.9))
    models = list(frame["model"].unique())
    for ax, model in zip(figure.subplots(1, len(models), squeeze=False)[0], models, strict=True):
        rows = frame[frame["model"] == model]
        outcome = np.select(
            [rows["reported"], ~rows["reached"]], ["reported as failed", "missed"], "global minimum"
        )
        if model == "housner":
            x, y = 1 - rows["r"], rows["sigma_deg"]
            ax.set(xlabel="1 − r", ylabel="noise $σ_θ$ / °")
        else:
            damping = "c" if model == "winkler" else "lambda"
            x, y = rows["k"], rows[damping] / rows["k"]
            unit = {"c": "s", "lambda": "(s/m)"}[damping]
            ax.set(xlabel="k / (N/m²)", ylabel=f"{SYMBOLS[damping]}/k / {unit}")
        for name, style in OUTCOMES.items():
            ax.plot(x[outcome == name], y[outcome == name], linestyle="", **style)
        missed = int(np.sum(outcome == "missed"))
        ax.set(xscale="log", yscale="log")
        ax.margins(0.05)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_minor_formatter(NullFormatter())
        ax.set_title(f"{MODEL_LABELS[model]}\n{missed} of {len(rows)} missed", loc="left")
    handles = [Line2D([], [], linestyle="", label=name, **style) for name, style in OUTCOMES.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    headed(figure)
    return figure, frame


def coverage_summary(frame) -> pd.DataFrame:
    """Scatter and coverage of each scene, law, noise and parameter.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.identification.coverage`.

    Returns
    -------
    pandas.DataFrame
        n fits that succeeded, failed, efficiency (standard deviation over the Cramér-Rao bound), bias (mean
        error in bounds) and covered, the share of the 95 % intervals that hold the truth.
    """
    rows = []
    keys = ["block", "foundation", "model", "noise", "parameter"]
    for key, group in frame.groupby(keys, sort=False):
        good = group[group["stderr"].notna()]
        error = (good["value"] - good["truth"]) / good["bound"]
        inside = (good["ci95_low"] <= good["truth"]) & (good["truth"] <= good["ci95_high"])
        rows.append(
            {
                **dict(zip(keys, key, strict=True)),
                "n": len(good),
                "failed": len(group) - len(good),
                "efficiency": error.std(),
                "bias": error.mean(),
                "covered": inside.mean(),
            }
        )
    return pd.DataFrame(rows)


@styled()
def coverage(frame, labels=None):
    """Scatter over the Cramér-Rao bound, and coverage of the 95 % intervals, scene by scene.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.identification.coverage`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

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
        for noise, marker in NOISE_MARKERS.items():
            rows = summary[
                (summary["model"] == model)
                & (summary["parameter"] == parameter)
                & (summary["noise"] == noise)
            ]
            x = [scenes.index(s) for s in zip(rows["block"], rows["foundation"], strict=True)]
            x = np.array(x, float) + (i - (len(quantities) - 1) / 2) * width
            style = {
                "color": MODEL_STYLES[model]["color"],
                "marker": marker,
                "linestyle": "",
                "markersize": 4,
                "markerfacecolor": "white" if parameter in ("c", "lambda") else None,
            }
            if noise == "white":
                error = rows["efficiency"] / np.sqrt(2 * rows["n"])
                upper.errorbar(x, rows["efficiency"], error, linewidth=0.8, **style)
            error = np.sqrt(0.95 * 0.05 / rows["n"])
            lower.errorbar(x, 100 * rows["covered"], 100 * error, linewidth=0.8, **style)
    upper.axhline(1.0, color="0.5", linewidth=0.8)
    upper.axhline(1.1, color="0.5", linewidth=0.8, linestyle=":")
    upper.set(ylabel="scatter / Cramér–Rao bound")
    for y, style in ((95, "-"), (93, ":"), (97, ":")):
        lower.axhline(y, color="0.5", linewidth=0.8, linestyle=style)
    names = [f"{label(labels, block)}\n{label(labels, foundation)}" for block, foundation in scenes]
    lower.set(ylabel="truth in the 95 % interval / %", xticks=range(len(scenes)))
    lower.set_xlim(-0.5, len(scenes) - 0.5)
    lower.set_xticklabels(names)
    handles = [
        Line2D(
            [],
            [],
            color=MODEL_STYLES[model]["color"],
            marker="o",
            linestyle="",
            markerfacecolor="white" if parameter in ("c", "lambda") else None,
            label=f"{MODEL_LABELS[model]} {SYMBOLS[parameter]}",
        )
        for model, parameter in quantities
    ]
    handles += [
        Line2D([], [], color="0.3", marker=marker, linestyle="", label=f"noise: {noise}")
        for noise, marker in NOISE_MARKERS.items()
        if noise in set(summary["noise"])
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    headed(figure)
    return figure, summary


@styled()
def model_error(frame, labels=None):
    """How wide the intervals become, and how far the parameters lie off, under a law that is not the truth.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.identification.model_error`.
    labels : mapping of str to str, optional
        Not used.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    figure = Figure(figsize=(7.0, 3.1))
    left, right = figure.subplots(1, 2)
    kinds = list(frame["imperfection"].unique())
    for j, parameter in enumerate(frame["parameter"].unique()):
        rows = frame[frame["parameter"] == parameter]
        x = np.array([kinds.index(kind) for kind in rows["imperfection"]]) + (j - 0.5) * 0.3
        x = x + np.linspace(-0.1, 0.1, len(rows))
        for told in (False, True):
            style = {
                "color": ("black", "#d55e00")[j],
                "marker": "os"[j],
                "linestyle": "",
                "markersize": 3.5,
                "markerfacecolor": None if told else "white",
            }
            chosen = (rows["told"] == told).values
            left.plot(x[chosen], rows["widened"][chosen], **style)
            right.plot(x[chosen], rows["error"].abs()[chosen], **style)
    left.set(yscale="log", ylabel="standard error / Cramér–Rao bound")
    right.set(yscale="log", ylabel="|error| / standard error")
    right.axhline(1.96, color="0.5", linewidth=0.8, linestyle=":")
    for ax in (left, right):
        ax.set_xticks(range(len(kinds)), [IMPERFECTIONS[kind] for kind in kinds])
        ax.set_xlim(-0.5, len(kinds) - 0.5)
    handles = [
        Line2D([], [], color=colour, marker=marker, linestyle="", label=SYMBOLS[parameter])
        for parameter, colour, marker in zip(
            frame["parameter"].unique(), ("black", "#d55e00"), "os", strict=False
        )
    ]
    handles.append(
        Line2D(
            [],
            [],
            color="0.3",
            marker="o",
            linestyle="",
            markerfacecolor="white",
            label="residual passes as noise",
        )
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    headed(figure)
    return figure, frame


@styled()
def choice(frame, labels=None):
    """The chosen models over the distance of the true law from its nearest rival.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.studies.identification.choice`.
    labels : mapping of str to str, optional
        Not used.

    Returns
    -------
    figure : matplotlib.figure.Figure
    data : pandas.DataFrame
        The rows drawn.
    """
    figure = Figure(figsize=(7.0, 2.9))
    models = list(frame["model"].unique())
    for ax, model in zip(figure.subplots(1, len(models), squeeze=False)[0], models, strict=True):
        rows = frame[frame["model"] == model]
        finite = rows["distance"].where(np.isfinite(rows["distance"]))
        edges = np.geomspace(0.1, 1e4, 11)
        position = np.digitize(finite.clip(0.11, 9e3).fillna(9e3), edges) - 1
        bottom = np.zeros(len(edges) - 1)
        for chosen, style in MODEL_STYLES.items():
            counts = np.bincount(position[rows["chosen"] == chosen], minlength=len(edges) - 1)[
                : len(edges) - 1
            ]
            ax.bar(
                edges[:-1],
                counts,
                np.diff(edges),
                bottom,
                align="edge",
                color=style["color"],
                edgecolor="white",
                linewidth=0.3,
                hatch="//" if chosen != model else None,
            )
            bottom += counts
        right = (rows["chosen"] == model) & (rows["distance"] >= FAR)
        ax.set_title(f"{MODEL_LABELS[model]}\n{right.sum()} of {(rows['distance'] >= FAR).sum()}", loc="left")
        for distance in (NEAR, FAR):
            ax.axvline(distance, color="0.5", linewidth=0.8, linestyle=":")
        ax.set(
            xscale="log", xlabel="distance / σ", ylabel="runs" if ax.get_subplotspec().is_first_col() else ""
        )
    handles = [Patch(color=style["color"], label=style["label"]) for style in MODEL_STYLES.values()]
    handles.append(Patch(facecolor="0.8", hatch="//", label="another law than the true one"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), title="chosen")
    headed(figure)
    return figure, frame
