"""Figure of the study of the choice: is the truth named, and do the intervals hold it?"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from freerock.figures.style import Axes, Labels, headed, styled
from freerock.models.laws import CANDIDATES, LAWS, SYMBOLS

FAR, NEAR = 5.0, 1.0  # distances [σ] beyond which candidates are to be told apart, and below which they can't
EDGES = np.geomspace(0.1, 1e4, 11)
ANSWERS = {"named": "#0072b2", "in the set": "#56b4e9", "not in the set": "#d55e00"}
NAMED_AIM, COVERED_AIM = 0.97, (0.92, 0.98)


def choice_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """How often the truth is named and held by its intervals, family by family.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock_bench.choice.run`.

    Returns
    -------
    pandas.DataFrame
        family, quantity ("named", "in the set", or a parameter: the 95 % interval of the named candidate
        holds the truth), n (runs; of a parameter those whose truth is named), share.
    """
    rows = []
    for family, some in frame.groupby("family", sort=False):
        for quantity, column in (("named", "right"), ("in the set", "held")):
            rows.append((family, quantity, len(some), some[column].mean()))
        named = some[some["right"]]
        for name in SYMBOLS:
            inside = named.get(f"{name}_inside", pd.Series(dtype=float)).dropna()
            if len(inside):
                rows.append((family, name, len(inside), inside.astype(float).mean()))
    return pd.DataFrame(rows, columns=["family", "quantity", "n", "share"])


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """The answers over the distance from the nearest rival; shares named and held, family by family."""
    return [_distances(frame), _shares(choice_summary(frame))], choice_summary(frame)


def _distances(frame: pd.DataFrame) -> Figure:
    """Answers over the distance from the nearest rival, a panel per family and law."""
    known = frame[frame["rival"].notna() & (frame["rival"] != "")]
    law = known["model"].map(lambda model: LAWS[CANDIDATES[model].law].label)
    groups = list(known.groupby([known["family"], law.rename("law")], sort=False))
    figure = Figure(figsize=(7.0, 2.9))
    axes = figure.subplots(1, max(1, len(groups)), squeeze=False, sharey=True)[0]
    for ax, ((family, name), rows) in zip(axes, groups, strict=False):
        _answers(ax, rows)
        far = rows[rows["distance"] >= FAR]
        ax.set_title(f"{name},\n{family}: {far['right'].sum()} of {len(far)}", loc="left")
    axes[0].set_ylabel("runs")
    handles = [Patch(color=color, label=f"the truth is {name}") for name, color in ANSWERS.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    headed(figure)
    return figure


def _answers(ax: Axes, rows: pd.DataFrame) -> None:
    """Stacked bars of the answers over the distance."""
    finite = rows["distance"].clip(EDGES[0] * 1.1, EDGES[-1] * 0.9)
    position = np.digitize(finite, EDGES) - 1
    answer = np.where(rows["right"], "named", np.where(rows["held"], "in the set", "not in the set"))
    bottom = np.zeros(len(EDGES) - 1)
    for name, color in ANSWERS.items():
        counts = np.bincount(position[answer == name], minlength=len(EDGES) - 1)[: len(EDGES) - 1]
        ax.bar(
            EDGES[:-1],
            counts,
            np.diff(EDGES),
            bottom,
            align="edge",
            color=color,
            edgecolor="white",
            linewidth=0.3,
        )
        bottom += counts
    for distance in (NEAR, FAR):
        ax.axvline(distance, color="0.5", linewidth=0.8, linestyle=":")
    ax.set(xscale="log", xlabel="distance / σ")


def _shares(summary: pd.DataFrame) -> Figure:
    """Shares with their standard errors, beside what is aimed at."""
    families = list(summary["family"].unique())
    figure = Figure(figsize=(7.0, 1.2 + 0.28 * len(families)))
    axes = figure.subplots(1, 2, sharey=True)
    named = summary["quantity"].isin(["named", "in the set"])
    for ax, rows, title in zip(
        axes, (summary[named], summary[~named]), ("the truth is", "held by its interval"), strict=True
    ):
        quantities = list(rows["quantity"].unique())
        for j, quantity in enumerate(quantities):
            some = rows[rows["quantity"] == quantity]
            y = [families.index(family) + 0.12 * (j - (len(quantities) - 1) / 2) for family in some["family"]]
            error = np.sqrt(some["share"] * (1 - some["share"]) / some["n"])
            ax.errorbar(
                100 * some["share"],
                y,
                xerr=100 * error,
                fmt="os^Dv"[j % 5],
                markersize=4,
                label=SYMBOLS.get(quantity, quantity),
            )
        ax.set_title(title, loc="left")
        ax.set_xlabel("share of the runs / %")
        ax.set_xlim(right=101)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=len(quantities))
    axes[0].axvline(100 * NAMED_AIM, color="0.5", linewidth=0.8, linestyle=":")
    for aim in COVERED_AIM:
        axes[1].axvline(100 * aim, color="0.5", linewidth=0.8, linestyle=":")
    axes[0].set_yticks(range(len(families)), families)
    axes[0].invert_yaxis()
    headed(figure)
    return figure
