"""Figure of the confusion atlas: who is named for whom, and how wrong the stiffness is then."""

import numpy as np
import pandas as pd
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from freerock.figures.style import Axes, Labels, headed, styled
from freerock.models.laws import CANDIDATES, LAWS, MODEL_LABELS, Candidate

FIGURE = {
    "caption": "Confusion atlas: which candidate is named for which truth, how often the truth is missed "
    "under each noise, and how wrong the stiffness is then. Truths that are always found are left out. All "
    "runs are simulated."
}

Truths = list[tuple[str, str, float]]
NOBODY = "none explains"  # also where one is named as the best of those that do not
SHARES = LinearSegmentedColormap.from_list("shares", ["white", "#0072b2"])
TRUTH = ["law", "kinematics", "width_fraction"]
WRONG = {  # what is wrong with the answer, and how it is printed
    "rigid": "rigid for compliant",
    "compliant": "compliant for rigid",
    "law": "another law",
    "kinematics": "other kinematics",
    "width": "width not freed",
    "larger": "larger than needed",
    "nobody": "none explains",
}


def confusion_summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Counts and errors of an atlas by truth, noise, number of runs and who was named.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock_bench.confusion.run`.

    Returns
    -------
    pandas.DataFrame
        law, kinematics, width_fraction, noise, n_runs, named (a candidate that explains the record), wrong,
        n, share (of the cases of that truth, noise and number of runs), held (how many of the n have the
        truth in their set), and of each parameter the median of the absolute error in per cent and in stated
        standard errors.
    """
    cell = [*TRUTH, "noise", "n_runs"]
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
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[list[Figure], pd.DataFrame]:
    """Who is named for which truth; how often the truth is named under each noise; errors of k where not."""
    frame = _confident(frame)
    truths = list(dict.fromkeys(frame[TRUTH].itertuples(index=False, name=None)))
    return [_who(frame, truths), _noises(frame, truths), _errors(frame)], confusion_summary(frame)


def _confident(frame: pd.DataFrame) -> pd.DataFrame:
    """The answers, with a name only where it is said to explain the record."""
    explained = frame["explained"].astype(bool)
    return frame.assign(
        named=frame["named"].where(explained, NOBODY),
        wrong=frame["wrong"].fillna("").where(explained, "nobody"),
        right=frame["right"] & explained,
        held=frame["held"] & explained,
    )


def _who(frame: pd.DataFrame, truths: Truths) -> Figure:
    """Matrix of truth and named candidate, all noises together, of truths that were not always named."""
    missed = frame[~frame["right"]].groupby(TRUTH).size()
    shown = [truth for truth in truths if truth in missed.index] or truths[:1]
    own = [Candidate(law, kinematics, width != 1).name for law, kinematics, width in shown]
    counts = frame.groupby([*TRUTH, "named"]).size()
    here = {name for *truth, name in counts.index if tuple(truth) in shown}
    named = [name for name in dict.fromkeys([*own, *CANDIDATES, NOBODY]) if name in {*own, *here}]
    matrix = np.array([[counts.get((*truth, name), 0) for name in named] for truth in shown], dtype=float)
    figure = Figure(figsize=(7.0, 1.9 + 0.2 * len(shown)))
    ax = figure.subplots()
    _matrix(ax, matrix / matrix.sum(axis=1, keepdims=True), shown, matrix.astype(int).astype(str))
    ax.set_xticks(
        range(len(named)), [MODEL_LABELS.get(name, name) for name in named], rotation=60, ha="right"
    )
    for row, name in enumerate(own):
        _frame(ax, named.index(name), row)
    others = f"; {len(truths) - len(shown)} other truths: all right" if len(shown) < len(truths) else ""
    ax.set_title(f"records by truth (row) and name; framed: right{others}", loc="left")
    headed(figure)
    return figure


def _noises(frame: pd.DataFrame, truths: Truths) -> Figure:
    """How often the truth is not named, and not in the set, by noise and number of runs."""
    by_runs = frame[["n_runs", "noise"]].sort_values("n_runs", kind="stable")
    columns = list(dict.fromkeys(by_runs.itertuples(index=False, name=None)))
    shares = frame.groupby([*TRUTH, "n_runs", "noise"])[["right", "held"]].mean()
    missed = shares[(shares < 1).any(axis=1)].index
    shown = [truth for truth in truths if any(truth == found[:3] for found in missed)] or truths[:1]
    columns = [where for where in columns if any(where == found[3:] for found in missed)] or columns[:1]
    figure = Figure(figsize=(7.0, 1.5 + 0.2 * len(shown)))
    axes = figure.subplots(1, 2, sharey=True)
    for ax, column, title in zip(
        axes, ("right", "held"), ("the truth is not named", "nor is it in the set"), strict=True
    ):
        own = shares[column]
        matrix = np.array([[1 - own.get((*truth, *where), 1.0) for where in columns] for truth in shown])
        text = np.where(matrix > 0, np.char.mod("%.0f", 100 * matrix), "")
        _matrix(ax, matrix, shown, text)
        ax.set_xticks(range(len(columns)), [f"{noise}, {n}" for n, noise in columns], rotation=60, ha="right")
        ax.set_title(f"{title} / % of the records", loc="left")
        ax.set_xlabel("noise, runs")
    headed(figure)
    return figure


def _matrix(ax: Axes, shares: np.ndarray, truths: Truths, text: np.ndarray) -> None:
    """Shares as shades of cells, with a text in each that is not empty."""
    ax.imshow(shares, cmap=SHARES, vmin=0, vmax=1, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        if share > 0 or text[row, column] not in ("", "0"):
            color = "white" if share > 0.6 else "black"
            ax.text(column, row, text[row, column], ha="center", va="center", color=color, fontsize=6)
    names = [
        f"{MODEL_LABELS[Candidate(law, kinematics).name]}, {width:g}" for law, kinematics, width in truths
    ]
    ax.set_yticks(range(len(truths)), names)
    ax.grid(False)
    ax.tick_params(length=0)


def _frame(ax: Axes, column: int, row: int) -> None:
    """A frame around a cell."""
    x, y = column - 0.5, row - 0.5
    ax.plot([x, x + 1, x + 1, x, x], [y, y, y + 1, y + 1, y], color="#d55e00", linewidth=1.0, clip_on=False)


def _errors(frame: pd.DataFrame) -> Figure:
    """Errors of the stiffness by what is wrong with the answer, and under the true law as in the paper."""
    figure = Figure(figsize=(7.0, 2.8))
    axes = figure.subplots(1, 2, sharey=True)
    compliant = frame[frame["law"].map(lambda law: LAWS[law].is_foundation)]
    kinds = {"": "right", **WRONG}
    rows = {label: compliant[compliant["wrong"] == wrong] for wrong, label in kinds.items()}
    rows["the law as in the paper"] = compliant
    for ax, unit, label in zip(axes, ("percent", "stderrs"), ("%", "stated standard errors"), strict=True):
        for y, (name, some) in enumerate(rows.items()):
            column = f"{'paper' if name.startswith('the law') else 'k'}_error_{unit}"
            values = some[column].abs().dropna().clip(lower=1e-3)
            spread = np.linspace(-0.3, 0.3, len(values)) if len(values) > 1 else np.zeros(len(values))
            ax.plot(values, y + spread, ".", color="0.55", markersize=2)
            if len(values):
                ax.plot(values.median(), y, "|", color="#d55e00", markersize=14, markeredgewidth=2)
        ax.set(xscale="log", xlabel=f"error of k / {label}")
        ax.set_yticks(range(len(rows)), [f"{name} ({len(some)})" for name, some in rows.items()])
    axes[0].invert_yaxis()
    axes[0].set_title("a point per record, a line at the median", loc="left")
    headed(figure)
    return figure
