"""Figure of the study of mishaps: what becomes of each, from its right name to a wrong number under ok."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures.style import Labels, styled

FIGURE = {
    "caption": "Mishaps of a laboratory, on simulated records: how often each is warned of by its name, "
    "noted and repaired, or left under an ok, with k within four standard errors of the truth or "
    "not.",
}

FAR = 4.0  # standard errors of k, from which a number under an ok is wrong
OUTCOMES = {
    "warned, by its name": "#0072b2",
    "warned, otherwise": "#56b4e9",
    "noted and repaired": "#009e73",
    "ok, k right": "0.8",
    "ok, k wrong": "#d55e00",
}


def outcomes(frame: pd.DataFrame) -> pd.DataFrame:
    """Shares of what became of the records of each mishap.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock_bench.mishaps.run`.

    Returns
    -------
    pandas.DataFrame
        mishap, records, and a column per outcome: its share. Under an ok k is right within `FAR` standard
        errors; a record whose candidate has no k is wrong.
    """
    warned, named = frame["level"] != "ok", frame["named"].astype(bool)
    right, noted = frame["k_error_stderrs"].abs() <= FAR, frame["names"].fillna("") != ""
    which = np.select(
        [warned & named, warned, right & noted, right], list(OUTCOMES)[:4], default=list(OUTCOMES)[4]
    )
    rows = []
    for mishap, some in pd.Series(which, index=frame.index).groupby(frame["mishap"], sort=False):
        shares = {name: float((some == name).mean()) for name in OUTCOMES}
        rows.append({"mishap": mishap, "records": len(some), **shares})
    return pd.DataFrame(rows, columns=["mishap", "records", *OUTCOMES])


@styled()
def draw(frame: pd.DataFrame, labels: Labels = None) -> tuple[Figure, pd.DataFrame]:
    """A bar per mishap, stacked from warned by its name to ok over a wrong number."""
    found = outcomes(frame)
    figure = Figure(figsize=(6.3, 1.3 + 0.2 * len(found)))
    ax = figure.subplots()
    left = np.zeros(len(found))
    for name, color in OUTCOMES.items():
        share = 100 * found[name].to_numpy()
        ax.barh(
            range(len(found)), share, 0.75, left, color=color, edgecolor="white", linewidth=0.3, label=name
        )
        left += share
    ax.set_yticks(range(len(found)), [_called(some) for _, some in frame.groupby("mishap", sort=False)])
    ax.set_ylim(-0.6, len(found) - 0.4)
    ax.invert_yaxis()
    ax.set(xlim=(0, 100), xlabel="records [%]")
    ax.grid(False, axis="y")
    ax.set_title("what becomes of a mishap (records); simulated", loc="left")
    figure.legend(loc="outside lower center", ncols=3)
    return figure, found


def _called(rows: pd.DataFrame) -> str:
    """A mishap with what is set, in its unit, and how many records it has."""
    first = rows.iloc[0]
    name, _, size = str(first["mishap"]).partition(", ")
    unit = str(first["quantity"]).partition("[")[2].rstrip("]")
    what = f"{first['value']:g} {unit}" if unit else size
    return f"{name}, {what} ({len(rows)})" if what else f"{name} ({len(rows)})"
