"""Figure of the cost of the models: what each reaches, and how long a run of it takes."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from freerock.figures.style import MODEL_STYLES, Labels, Style, headed, label, styled
from freerock.models.laws import MODEL_LABELS


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """The three models on the same axes: ε_θ of the fitted model over the time of one run."""
    figure = Figure(figsize=(7.0, 3.4))
    ax = figure.subplots()
    ax.set(xscale="log", yscale="log")
    markers = dict(zip(frame.groupby(["block", "foundation"], sort=False).groups, "osD^v<>PX", strict=False))
    for scene, rows in frame.groupby(["block", "foundation"], sort=False):
        rows = rows.sort_values("epsilon_theta", ascending=False)
        ax.plot(1e3 * rows["time_s"], 100 * rows["epsilon_theta"], color="0.75", linewidth=0.7, zorder=1)
        for _, row in rows.iterrows():
            colour = MODEL_STYLES[row["model"]]["color"]
            style = {
                "color": colour,
                "markerfacecolor": colour if row["success"] else "white",
                "markersize": 5,
            }
            ax.plot(1e3 * row["time_s"], 100 * row["epsilon_theta"], markers[scene], **style)
    noise = 100 * frame["noise_epsilon"]
    ax.axhspan(noise.min(), noise.max(), color="0.9", linewidth=0, zorder=0)
    ax.margins(x=0.05)
    ax.xaxis.set_minor_formatter("{x:g}")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("time of a run / ms")
    ax.set_ylabel("$ε_θ$ of the fitted model / %")
    figure.legend(handles=_legend(frame, markers, labels), loc="outside right upper")
    headed(figure)
    return figure, frame


def _legend(
    frame: pd.DataFrame, markers: Mapping[tuple[str, str], str], labels: Labels
) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = []
    counts = frame.drop_duplicates("model").set_index("model")["n_parameters"]
    for model, n in counts.items():
        text = f"{MODEL_LABELS[model]}, {n} parameter{'s' * (n > 1)}"
        handles.append(Patch(color=MODEL_STYLES[model]["color"], label=text))
    handles.append(Patch(color="0.9", label="noise of the record"))
    grey: Style = {"color": "0.3", "linestyle": ""}
    if not frame["success"].all():
        handles.append(
            Line2D([], [], **grey, markerfacecolor="white", marker="o", label="fit not to be used")
        )
    for (block, foundation), marker in markers.items():
        text = f"{label(labels, block)}, {label(labels, foundation)}"
        handles.append(Line2D([], [], **grey, marker=marker, label=text))
    return handles
