"""Parameters run by run, with the mean of each record and of each foundation, and where the next will lie."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.models.laws import CANDIDATES, MODEL_LABELS, MODELS, law_of
from freerock.tables.candidates import named_by
from freerock.tables.printed_tables import spread

FIGURE = {
    "title": "Identified parameters, run by run",
    "caption": "Each run with its 95 % interval from noise (within the symbol if none is visible; open "
    "if the law is rejected for that run). Diamond and square: mean of a "
    "record, and of the records of a foundation, with the 95 % interval of its total uncertainty. Shaded: "
    "95 % prediction interval of the next run at the estimated τ, small or zero where < stands, and of the "
    "next record over all likely τ. τ: standard deviation between them without their noise, in per cent of "
    "the mean; not seen where noise explains all of it.",
    "reading": "Read each panel from the runs down to the square, which is the value to quote. Diamonds "
    "that agree within their bars show that blocks share the foundation. A shaded bar much "
    "wider than the bar of a run means that runs differ by more than their noise.",
    "reads": ["parameters", "populations", "choice"],
}

NARROWEST_IN = 1.8  # of a panel and of the names beside
MOST_ROWS = 60  # with more there are no rows of runs
MOST_RECORDS = 36  # without rows of runs, evenly taken of each foundation: they stand on a page
COLUMNS = ["level", "model", "test", "run", "block", "foundation", "parameter", "value", "low", "high"]
COLUMNS += ["next_low", "next_high", "tau_text", "rejected", "named_by"]
OF_RUN: Style = {"fmt": "o", "color": "0.45", "markersize": 3}
LOOKS: dict[str, tuple[Style, str]] = {
    "run": (OF_RUN, "run"),
    "rejected": (OF_RUN | {"markerfacecolor": "white"}, "run, law rejected"),
    "record": ({"fmt": "D", "color": "0.15", "markersize": 4}, "mean of a record"),
    "foundation": ({"fmt": "s", "color": "#0a5bd3", "markersize": 5}, "mean of the records"),
}
NEXT = {"record": "95 % of next runs", "foundation": "95 % of next records"}
HIGH = {"record": 5, "foundation": 9}  # of the bar of the next [points]


@styled()
def draw(
    parameters: pd.DataFrame,
    populations: pd.DataFrame,
    choice: pd.DataFrame,
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """Parameters of the law that most runs of a foundation name: a row for each run, record and foundation.

    Parameters
    ----------
    parameters, populations, choice : pandas.DataFrame
        Tidy tables.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`; SI units.
    """
    laws = _laws(parameters, choice)
    if not laws:
        return style.nothing_drawn("no run has a fit that may be used", origin), pd.DataFrame(columns=COLUMNS)
    rows = _rows(parameters, populations, choice, laws, labels)
    groups = [pd.concat([each.assign(place=place) for place, each in enumerate(own)]) for own in rows]
    names = [
        [name for name in MODELS[own["model"].iloc[0]] if name in set(own["parameter"])] for own in groups
    ]
    beside = max(map(len, names))
    beside = beside if style.size(1)[0] > NARROWEST_IN * (1 + beside) else 1
    panels = [
        (own, names[i][k : k + beside])
        for k in range(0, max(map(len, names)), beside)
        for i, own in enumerate(groups)
        if names[i][k : k + beside]
    ]
    room = [own["place"].nunique() + 2.0 for own, _ in panels]
    figure = Figure(figsize=style.size(0.8 + 0.17 * sum(room)))
    axes = figure.subplots(len(panels), beside, squeeze=False, sharey="row", height_ratios=room)
    for line, (own, shown) in zip(axes, panels, strict=True):
        for ax, name in zip(line, shown, strict=False):
            _panel(ax, own, name, 0.5 / beside)
            ax.set_xlabel(style.axis_of(name) if name != "r" else "restitution r")
            ax.text(1.02, 1.0, "τ", transform=ax.transAxes, va="bottom", fontsize="small")
        for ax in line[len(shown) :]:
            ax.set_axis_off()
        named = own.drop_duplicates("place")
        style.rows_down(line[0], named["row"])
        for text, level in zip(line[0].get_yticklabels(), named["level"], strict=True):
            text.set_fontweight("normal" if level == "run" else "bold")
    style.finish(figure, origin)
    data = style.gathered((each[COLUMNS] for own in rows for each in own), COLUMNS)
    chosen = _of_laws(choice, laws)
    by = {law: named_by(law, chosen[chosen["model"] == law]) for law in set(laws.values())}
    return figure, data.assign(named_by=data["model"].map(by))


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Of which laws the parameters are, and how many runs and records are drawn."""
    if data.empty:
        return "No run has a fit that may be used."
    known, told = labels or {}, list[str]()
    for (model, named), own in data.groupby(["model", "named_by"], sort=False):
        on = ", ".join(known.get(each, each) for each in own["foundation"].unique())
        several = data["model"].nunique() > 1
        told.append(f"{MODEL_LABELS[model]}{f' ({on})' * several}, named by {named}")
    runs, records = (data[data["level"] == level] for level in ("run", "record"))
    drawn = style.number_of(records["test"].nunique(), "record")
    means = f"Drawn: means of {drawn}." if runs.empty else f"Runs of {drawn}."
    return f"Law{'s' * (len(told) > 1)}: {'; '.join(told)}. {means}"


def _laws(parameters: pd.DataFrame, choice: pd.DataFrame) -> dict[str, str]:
    """By foundation the law that most of its runs name; else one of a foundation that was fitted."""
    found = {}
    for foundation, own in parameters[parameters["success"].astype(bool)].groupby("foundation", sort=False):
        here = choice[(choice["foundation"] == foundation) & (choice["status"] == "selected")]
        named = here["model"].value_counts()
        ranks = {
            model: (-named.get(model, 0), not law_of(model).is_foundation)
            for model in CANDIDATES
            if model in set(own["model"])
        }
        found[str(foundation)] = min(ranks, key=ranks.__getitem__)
    return found


def _rows(
    parameters: pd.DataFrame,
    populations: pd.DataFrame,
    choice: pd.DataFrame,
    laws: Mapping[str, str],
    labels: Labels,
) -> list[list[pd.DataFrame]]:
    """Rows downwards, by foundation: the records that name its law, each below its runs where there are
    several, and last the foundation; a line for each parameter, and the name of the row."""
    chosen, runs, found = (_of_laws(table, laws) for table in (choice, parameters, populations))
    rejected = chosen[chosen["status"] == "rejected"]
    no = set(zip(rejected["test"], rejected["run"].astype(str), strict=True))
    tests = set(chosen[chosen["status"] == "selected"]["test"]) or set(found["test"])
    runs = runs[runs["success"].astype(bool) & runs["test"].isin(tests)]
    is_rejected = [each in no for each in zip(runs["test"], runs["run"].astype(str), strict=True)]
    runs = runs.rename(columns={"ci95_low": "low", "ci95_high": "high"})
    runs = runs.assign(level="run", rejected=is_rejected).reindex(columns=COLUMNS)
    records = _of_means(found[(found["level"] == "record") & found["test"].isin(tests)])
    foundations = _of_means(found[found["level"] == "foundation"])
    with_runs = len(runs[["test", "run"]].drop_duplicates()) + records["test"].nunique() <= MOST_ROWS
    groups = []
    for foundation, of_foundation in records.groupby("foundation", sort=False):
        rows: list[pd.DataFrame] = []
        several = of_foundation.groupby("block")["test"].nunique()
        if not with_runs:
            of_foundation = _evenly(of_foundation, max(1, MOST_RECORDS // records["foundation"].nunique()))
        for test, record in of_foundation.groupby("test", sort=False):
            scene = style.label(labels, record["block"].iloc[0], str(foundation))
            name = f"{scene}: {test}" if several[record["block"].iloc[0]] > 1 else scene
            own = runs[runs["test"] == test]
            if with_runs and (own["run"].nunique() > 1 or str(test) in {each for each, _ in no}):
                rows += [each.assign(row=f"run {run}") for run, each in own.groupby("run", sort=False)]
            rows.append(record.assign(row=name))
        of_records = foundations[foundations["foundation"] == foundation]
        if len(of_records):
            name = f"{style.label(labels, str(foundation))}, {of_records['n_records'].iloc[0]} records"
            rows.append(of_records.assign(row=name))
        groups.append(rows)
    return groups


def _evenly(records: pd.DataFrame, most: int) -> pd.DataFrame:
    """The rows of no more than so many records."""
    tests = records["test"].unique()
    kept = np.unique(np.linspace(0, len(tests) - 1, min(most, len(tests))).round().astype(int))
    return records[records["test"].isin(tests[kept])]


def _of_laws(table: pd.DataFrame, laws: Mapping[str, str]) -> pd.DataFrame:
    """The rows of a table that are of the law of their foundation, and of its parameters."""
    own = table[table["model"] == table["foundation"].map(laws)]
    if "parameter" not in own:
        return own
    return own[[each in MODELS[law] for law, each in zip(own["model"], own["parameter"], strict=True)]]


def _of_means(found: pd.DataFrame) -> pd.DataFrame:
    """Means of records or foundations as drawn, and of how many records they are."""
    ends = {end: found[f"total95_{end}"].fillna(found[f"ci95_{end}"]) for end in ("low", "high")}
    texts = [_spread(row) for row in found.itertuples()]
    drawn = found.rename(columns={"mean": "value"}).assign(tau_text=texts, **ends)
    return drawn.reindex(columns=[*COLUMNS, "n_records"])


def _spread(row: Any) -> str:
    """τ in per cent of the mean, nothing where it is not known."""
    text = spread(row).text
    return {"–": "", "not seen": text}.get(text, f"{text} %")


def _panel(ax: Axes, rows: pd.DataFrame, name: str, room: float) -> None:
    """One parameter of some rows, in so much of the figure's width."""
    ax.margins(x=0.05)
    own = rows[rows["parameter"] == name]
    kinds = own["level"].mask(own["rejected"].eq(True), "rejected")
    for kind, marked in own.groupby(kinds, sort=False):
        _mark(ax, str(kind), marked)
    ax.grid(axis="y", visible=False)
    low, high = ax.get_xlim()
    if low > 0:
        style.number_ticks(ax.xaxis, low, high, 2, room)
    ax.set_xlim(low, high)


def _mark(ax: Axes, kind: str, marked: pd.DataFrame) -> None:
    """Rows of a kind: runs, or means of several with the interval of the next."""
    look, text = LOOKS[kind]
    value, low, high, places = marked[["value", "low", "high", "place"]].to_numpy(float).T
    bars = np.abs([value - low, high - value])
    look = look | {"elinewidth": 1.2}
    ax.errorbar(value, places, xerr=bars, capsize=0, zorder=3, **look, label=text)
    if kind not in NEXT:
        return
    spans = marked[["next_low", "next_high"]].assign(gap=np.nan).to_numpy(float)
    if np.isfinite(spans[:, 0]).any():
        bar = {"alpha": 0.25, "linewidth": HIGH[kind], "solid_capstyle": "butt"}
        ax.plot(spans.ravel(), np.repeat(places, 3), color=look["color"], **bar, label=NEXT[kind])
    for place, text in zip(places, marked["tau_text"], strict=True):
        style.beside_row(ax, place, text)
