"""Figure of the study of the choice: does it name the law that made a run?"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from freerock.figures.style import MODEL_STYLES, Labels, headed, panel_per_model, styled
from freerock.models.laws import LAWS, MODEL_LABELS

FAR, NEAR = 5.0, 1.0  # distances [σ] beyond which laws are distinguished, and below which they can't be


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """The chosen models over the distance of the true law from its nearest rival."""
    figure = Figure(figsize=(7.0, 2.9))
    for ax, model, rows in panel_per_model(figure, frame):
        finite = rows["distance"].where(np.isfinite(rows["distance"]))
        edges = np.geomspace(0.1, 1e4, 11)
        position = np.digitize(finite.clip(0.11, 9e3).fillna(9e3), edges) - 1
        bottom = np.zeros(len(edges) - 1)
        for chosen in LAWS:
            counts = np.bincount(position[rows["chosen"] == chosen], minlength=len(edges) - 1)[
                : len(edges) - 1
            ]
            ax.bar(
                edges[:-1],
                counts,
                np.diff(edges),
                bottom,
                align="edge",
                color=MODEL_STYLES[chosen]["color"],
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
    handles = [Patch(color=MODEL_STYLES[law]["color"], label=MODEL_LABELS[law]) for law in LAWS]
    handles.append(Patch(facecolor="0.8", hatch="//", label="another law than the true one"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), title="chosen")
    headed(figure)
    return figure, frame
