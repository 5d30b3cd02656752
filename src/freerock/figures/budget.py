"""Uncertainty budget: what each input adds to the total uncertainty of k, the damping and r."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pandas as pd

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, printed
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS, MODELS
from freerock.rotation.u_total import OF_LAW
from freerock.tables.candidates import named_by
from freerock.tables.number_text import INPUT_LABELS

FIGURE = {
    "title": "Uncertainty budget of the identified parameters",
    "caption": "Share of each input in the square of the total standard uncertainty u of each mean (k = 1, "
    "in per cent of the mean at the right). Runs: scatter that the inputs do not explain.",
    "reads": ["budget", "choice"],
}

MOST_ROWS = 40
NARROWEST_IN = 1.8  # of a panel and of the names beside
OF_MEAN = ["level", "test", "block", "foundation"]
# Told apart in grey and by hatching; an input of the rows below keeps its look in all figures.
LOOKS: dict[str, Style] = {
    "runs": {"color": "0.25"},
    OF_LAW: {"color": "#d55e00", "hatch": "++++"},
    "width_m": {"color": "#56b4e9"},
    "position_m": {"color": "#e69f00", "hatch": "////"},
    "height_m": {"color": "#009e73", "hatch": "...."},
    "scale_fraction": {"color": "#cc79a7", "hatch": "\\\\\\\\"},
    "mass_kg": {"color": "#f0e442", "hatch": "oo"},
    "levelled_deg": {"color": "0.7", "hatch": "xxxx"},
    "contact_width_m": {"color": "#0072b2", "hatch": "||||"},
    "sampling_rate_fraction": {"color": "white", "hatch": "----"},
    "response_ms": {"color": "0.5", "hatch": "****"},
    "com_height_m": {"color": "#117733", "hatch": "||"},
    "inertia_kg_m2": {"color": "#882255", "hatch": "--"},
    "com_offset_m": {"color": "#999933", "hatch": "++"},
    "gravity_m_s2": {"color": "#88ccee", "hatch": "oooo"},
}
OTHERS: Style = {"color": "0.9"}
SHOWN = 1.0  # per cent of a square, from which an input is named


@printed
def draw(budget: pd.DataFrame, choice: pd.DataFrame, origin: str, labels: Labels = None) -> Drawing:
    """Share of each input in the square of the total uncertainty, for the law that most runs name.

    Parameters
    ----------
    budget, choice : pandas.DataFrame
        Tidy tables.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns of the table budget, and named_by.
    """
    counts = choice[choice["status"] == "selected"]["model"].value_counts()
    models = sorted(budget["model"].unique(), key=lambda model: -counts.get(model, 0))
    data = budget[(budget["level"] != "campaign") & (budget["model"] == (models[0] if models else ""))]
    data = data[data["parameter"].isin(MODELS[models[0]] if models else ())]
    if data.empty:
        return style.nothing_drawn("no mean has a budget", origin), data
    names = [name for name in MODELS[models[0]] if name in set(data["parameter"])]
    keys = [*data[OF_MEAN].fillna("").drop_duplicates().to_numpy()][:MOST_ROWS]
    shares = data.groupby([*OF_MEAN, "parameter", "input"], dropna=False)["share_percent"].sum()
    largest = shares.groupby("input").max()
    named = [name for name in LOOKS if largest.get(name, 0.0) >= SHOWN]
    beside = len(names) if style.size(1)[0] > NARROWEST_IN * (1 + len(names)) else 1
    high = 0.6 + 0.22 * max(3, len(keys))
    figure, axes = style.panels_in_rows(len(names), beside, high, 0.4, sharey=True, sharex=True)
    parts = []
    for i, (ax, name) in enumerate(zip(axes, names, strict=True)):
        ax.set_title(style.panel(i, len(names), f"{SYMBOLS[name]}, {MODEL_LABELS[models[0]]}"), loc="left")
        of_number = data[data["parameter"] == name]
        for place, key in enumerate(keys):
            parts.append(of_number[(of_number[OF_MEAN].fillna("") == key).all(axis=1)])
            _bar(ax, place, parts[-1], named)
        ax.grid(axis="y", visible=False)
        ax.set_xlim(0, 100)
    for ax in axes[-beside:]:
        ax.set_xlabel("share of u² / %")
    style.rows_down(axes[0], _names(labels, keys))
    style.finish(figure, origin)
    return figure, style.gathered(parts, budget.columns).assign(named_by=named_by(models[0], choice))


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Of which law the means are, and which inputs are defaults."""
    if data.empty:
        return "No mean has a budget."
    stated = data[~data["input"].isin(["runs", OF_LAW])].drop_duplicates("input")
    assumed = [INPUT_LABELS.get(row.input, row.input) for row in stated.itertuples() if not row.input_stated]
    told = f"Law: {MODEL_LABELS[data['model'].iloc[0]]}, named by {data['named_by'].iloc[0]}."
    return f"{told} Taken by default, not stated: {', '.join(assumed)}." if assumed else told


def _bar(ax: Axes, place: int, rows: pd.DataFrame, named: list[str]) -> None:
    """A stacked bar, and the total uncertainty beside it."""
    left = 0.0
    shares = rows.groupby("input", sort=False)["share_percent"].sum()
    parts = [(INPUT_LABELS.get(name, name), LOOKS[name], float(shares.get(name, 0.0))) for name in named]
    parts.append(("others", OTHERS, float(shares.drop(named, errors="ignore").sum())))
    edge = {"edgecolor": "black", "linewidth": 0.4}
    for text, look, share in parts:
        if share > 0:
            ax.barh(place, share, left=left, height=0.7, **look | edge, label=text)
            left += share
    if len(rows):
        relative = 100 * float(rows["u_total"].iloc[0] / rows["mean"].iloc[0])
        if np.isfinite(relative):
            style.beside_row(ax, place, f"u = {relative:.2g} %")


def _names(labels: Labels, keys: Sequence[Sequence[str]]) -> list[str]:
    """What the rows are of; with the name of the record where a block has several on a foundation."""
    records = Counter((block, foundation) for level, _, block, foundation in keys if level == "record")
    names = []
    for level, test, block, foundation in keys:
        if level == "foundation":
            names.append(f"{style.label(labels, foundation)}, all records")
        else:
            name = style.label(labels, block, foundation)
            names.append(f"{name}: {style.as_text(test)}" if records[block, foundation] > 1 else name)
    return names
