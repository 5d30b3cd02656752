"""Figure of the confusion atlas: who is named for whom."""

import numpy as np
import pandas as pd
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from freerock.figures.style import Drawing, note_simulated, styled
from freerock.models.laws import CANDIDATES, MODEL_LABELS, Candidate

NOBODY = "none explains"  # also where one is named as the best of those that do not
DARK = 0.6  # shares above it have a white text
SHARES = LinearSegmentedColormap.from_list("shares", ["white", "#0072b2"])
TRUTH = ["law", "kinematics", "width_fraction"]


def confusion_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Counts and errors of an atlas by truth, noise and who was named.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock_bench.confusion.run`.

    Returns
    -------
    pandas.DataFrame
        law, kinematics, width_fraction, noise, named (a candidate that explains the run), wrong, n, share (of
        the cases of that truth and noise), held (how many of the n have the truth in their set), and of each
        parameter the median of the absolute error in per cent and in stated standard errors.
    """
    cell = [*TRUTH, "noise"]
    errors = [name for name in frame if name.endswith(("_error_percent", "_error_stderrs"))]
    frame = _confident(frame).assign(**frame[errors].abs())
    groups = frame.groupby([*cell, "named", "wrong"], sort=False, dropna=False)
    found = groups.agg(
        n=("held", "size"), held=("held", "sum"), **{name: (name, "median") for name in errors}
    )
    found = found.reset_index()
    found.insert(
        found.columns.get_loc("n") + 1, "share", found["n"] / found.groupby(cell)["n"].transform("sum")
    )
    return found


@styled()
def draw(frame: pd.DataFrame) -> Drawing:
    """Matrix of truth and named candidate, all noises together, of truths that were not always named."""
    frame = _confident(frame)
    truths = list(dict.fromkeys(frame[TRUTH].itertuples(index=False, name=None)))
    missed = frame[~frame["right"]].groupby(TRUTH).size()
    shown = [truth for truth in truths if truth in missed.index] or truths[:1]
    own = [Candidate(law, kinematics, width != 1).name for law, kinematics, width in shown]
    counts = frame.groupby([*TRUTH, "named"]).size()
    here = {name for *truth, name in counts.index if tuple(truth) in shown}
    named = [name for name in dict.fromkeys([*own, *CANDIDATES, NOBODY]) if name in {*own, *here}]
    matrix = np.array([[counts.get((*truth, name), 0) for name in named] for truth in shown])
    shares = matrix / matrix.sum(axis=1, keepdims=True)
    figure = Figure(figsize=(7.0, 1.9 + 0.2 * len(shown)))
    ax = figure.subplots()
    ax.imshow(shares, cmap=SHARES, vmin=0, vmax=1, aspect="auto")
    for (row, column), count in np.ndenumerate(matrix):
        if count:
            color = "white" if shares[row, column] > DARK else "black"
            ax.text(column, row, str(count), ha="center", va="center", color=color, fontsize=6)
    for row, name in enumerate(own):
        corner = named.index(name) - 0.5, row - 0.5
        ax.add_patch(Rectangle(corner, 1, 1, fill=False, edgecolor="#d55e00", linewidth=1.0, clip_on=False))
    names = [MODEL_LABELS.get(name, name) for name in named]
    ax.set_xticks(range(len(named)), names, rotation=60, ha="right")
    laws = [f"{MODEL_LABELS[Candidate(law, kinematics).name]}, {width:g}" for law, kinematics, width in shown]
    ax.set_yticks(range(len(shown)), laws)
    ax.grid(False)
    ax.tick_params(length=0)
    others = f"; {len(truths) - len(shown)} other truths: all right" if len(shown) < len(truths) else ""
    ax.set_title(f"records by truth (row) and name; framed: right{others}", loc="left")
    note_simulated(figure)
    return figure, confusion_summary(frame)


def _confident(frame: pd.DataFrame) -> pd.DataFrame:
    """The answers, with a name only where it is said to explain the record."""
    explained = frame["explained"].astype(bool)
    return frame.assign(
        named=frame["named"].where(explained, NOBODY),
        wrong=frame["wrong"].fillna("").where(explained, "nobody"),
        right=frame["right"] & explained,
        held=frame["held"] & explained,
    )
