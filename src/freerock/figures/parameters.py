"""Parameters run by run, with the mean of each record and foundation, and the correlation of the two."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from freerock.arrays import Floats
from freerock.errors import number_of
from freerock.figures import style
from freerock.figures.style import Axes, Drawing, Labels, Style, styled
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import MODEL_LABELS, MODELS
from freerock.tables.choices import laws_of_foundations
from freerock.tables.number_text import quantity

MOST_RECORDS = 12  # of a foundation: with more, as many of them evenly, without rows of their runs
ROW_IN, FRAME_IN, LEAST_ROWS = 0.16, 0.9, 8.0  # height of a row, of a panel's frame, and its least rows
COLUMNS = ["level", "model", "test", "run", "block", "foundation", "parameter", "value", "u", "correlation"]
COLUMNS += ["rejected", "named_by"]
LOOKS: dict[str, tuple[Style, str]] = {
    "run": ({"fmt": "o", "color": "0.45", "markersize": 3}, "run"),
    "rejected": (
        {"fmt": "o", "color": "0.45", "markersize": 3, "markerfacecolor": "white"},
        "run, law rejected",
    ),
    "record": ({"fmt": "D", "color": "0.15", "markersize": 4}, "mean of a record"),
    "foundation": ({"fmt": "s", "color": "#0a5bd3", "markersize": 5}, "mean of the records"),
}
BRIGHTEST = 0.75  # of the colour map, as a text on white can be read
MARGIN = np.sqrt(5.991)  # of an ellipse that holds 95 %, in standard uncertainties


@styled()
def draw(
    parameters: pd.DataFrame,
    populations: pd.DataFrame,
    choice: pd.DataFrame,
    origin: str,
    labels: Labels = None,
) -> Drawing:
    """Parameters of the law that most runs of a foundation name: a line of panels for each foundation.

    Parameters
    ----------
    parameters, populations, choice : pandas.DataFrame
        Tidy tables.

    Returns
    -------
    figure, data : Figure, pandas.DataFrame
        Columns `COLUMNS`; SI units, u the total standard uncertainty, correlation with the first parameter.
    """
    fitted = set(parameters[parameters["success"].astype(bool)]["foundation"])
    laws = {base: law for base, law in laws_of_foundations(choice).items() if law and base in fitted}
    if not laws:
        return style.nothing_drawn("no law is selected for any run", origin), pd.DataFrame(columns=COLUMNS)
    data = _data(parameters, populations, choice, laws)
    names = {base: [n for n in MODELS[law] if n in set(data["parameter"])] for base, law in laws.items()}
    beside = max(len(own) + (len(own) > 1) for own in names.values())
    of_base = {base: _rows(data[data["foundation"] == base], labels) for base in laws}
    room = [FRAME_IN + ROW_IN * max(LEAST_ROWS, len(rows)) for rows in of_base.values()]
    figure = Figure(figsize=(style.WIDTH_IN, 0.3 + sum(room)))
    axes = figure.subplots(len(laws), beside, squeeze=False, height_ratios=room)
    for n, (line, (base, rows)) in enumerate(zip(axes, of_base.items(), strict=True)):
        style.entitle(line[0], n, len(laws), style.label(labels, base), 0.9)
        own = data[data["foundation"] == base]
        for i, (ax, name) in enumerate(zip(line, names[base], strict=False)):
            _panel(ax, own[own["parameter"] == name], rows)
            _name_rows(ax, rows, _shades(own), named=i == 0)
            ax.set_xlabel(style.axis_of(name) if name != "r" else "restitution r")
            _numbered(ax.xaxis)
        for ax in line[len(names[base]) :]:
            ax.set_axis_off()
        if len(names[base]) > 1:
            line[len(names[base])].set_axis_on()
            _ellipses(line[len(names[base])], own, names[base][:2])
    style.finish(figure, origin)
    chosen = choice[choice["model"] == choice["foundation"].map(laws)]
    by = dict[str, str]()
    for law, own in chosen.groupby("model"):
        runs, selected = own[["test", "run"]].astype(str).drop_duplicates(), own["status"] == "selected"
        by[str(law)] = f"{selected.sum()} of {number_of(len(runs), 'run')}"
    return figure, data.assign(named_by=data["model"].map(by))[COLUMNS]


def caption(data: pd.DataFrame, labels: Labels = None) -> str:
    """Of which laws the parameters are, of how many runs and records; what bars, markers and ellipses are."""
    if data.empty:
        return "No law is selected for any run."
    known, told = labels or {}, list[str]()
    for (model, named), own in data.groupby(["model", "named_by"], sort=False):
        on = ", ".join(known.get(each, each) for each in own["foundation"].unique())
        several = data["model"].nunique() > 1
        told.append(f"{MODEL_LABELS[model]}{f' ({on})' * several}, selected for {named}")
    drawn = number_of(data["test"].replace("", pd.NA).nunique(), "record")
    laws = f"Law{'s' * (len(told) > 1)}: {'; '.join(told)}. {drawn.capitalize()}."
    return " ".join([laws, *_symbols(data)])


def _symbols(data: pd.DataFrame) -> list[str]:
    """What bars, markers and ellipses are, of those that are drawn."""
    of_base = [own for _, own in data.groupby("foundation")]
    told = ["Bars: 95 % by the total uncertainty."]
    if any(run for own in of_base for _, run in _rows(own, None)):
        told.append("Circles: runs.")
    told.append("Diamonds: means of records.")
    if (data["level"] == "foundation").any():
        told.append("Squares: means of the records of a foundation.")
    if any(own["parameter"].nunique() > 1 for own in of_base):
        told.append("Right: both parameters of each run, in the colour of its record's name.")
        told.append("The ellipse holds 95 % of their uncertainty; they are correlated.")
    return told


def _data(
    parameters: pd.DataFrame, populations: pd.DataFrame, choice: pd.DataFrame, laws: Mapping[str, str]
) -> pd.DataFrame:
    """Runs, records and foundations of the law of each foundation."""
    runs, means = (
        table[table["model"] == table["foundation"].map(laws)].astype({"foundation": str})
        for table in (parameters[parameters["success"].astype(bool)], populations)
    )
    no = choice[choice["status"] == "rejected"]
    rejected = {*zip(no["test"], no["run"].astype(str), no["model"], strict=True)}
    runs = runs.assign(
        level="run",
        u=runs["u_total"].fillna(runs["stderr"]),
        rejected=[
            each in rejected
            for each in zip(runs["test"], runs["run"].astype(str), runs["model"], strict=True)
        ],
    )
    means = means[means["level"].isin(["record", "foundation"])]
    means = means.rename(columns={"mean": "value"}).assign(u=means["u_total"].fillna(means["stderr"]))
    data = pd.concat([part.reindex(columns=COLUMNS) for part in (runs, means)], ignore_index=True)
    of_law = [name in MODELS[law] for law, name in zip(data["model"], data["parameter"], strict=True)]
    return data[of_law].astype({"run": object})


def _rows(own: pd.DataFrame, labels: Labels) -> dict[tuple[str, str], str]:
    """Names of the rows of a foundation, by record and run: runs, their record, last all records."""
    tests = [test for test in own[own["level"] == "record"]["test"].unique() if test]
    every = np.unique(np.linspace(0, len(tests) - 1, min(len(tests), MOST_RECORDS)).round().astype(int))
    rows: dict[tuple[str, str], str] = {}
    blocks = own.drop_duplicates("test").set_index("test")["block"]
    for test in (tests[i] for i in every):
        runs = own[(own["test"] == test) & (own["level"] == "run")]["run"].astype(str).unique()
        if len(tests) <= MOST_RECORDS and len(runs) > 1:
            rows |= {(test, run): f"run {run}" for run in runs}
        name = style.label(labels, blocks[test])
        rows[test, ""] = f"{name}: {test}" if (blocks == blocks[test]).sum() > 1 else name
    if (own["level"] == "foundation").any():
        rows["", ""] = "all records"
    return rows


def _panel(ax: Axes, own: pd.DataFrame, rows: Mapping[tuple[str, str], str]) -> None:
    """One parameter of a foundation, a row below the other."""
    places = {key: i for i, key in enumerate(rows)}
    for level, (look, text) in LOOKS.items():
        is_rejected = own["rejected"].eq(True)
        of_level = own[is_rejected] if level == "rejected" else own[(own["level"] == level) & ~is_rejected]
        drawn: list[tuple[Any, ...]] = []
        for row in of_level.itertuples():
            key = (row.test if isinstance(row.test, str) else "", str(row.run) if row.level == "run" else "")
            if key in places:
                drawn.append((row.value, places[key], NORMAL_95 * row.u))
        if drawn:
            value, place, half = np.array(drawn, float).T
            ax.errorbar(value, place, xerr=half, capsize=0, elinewidth=1.2, zorder=3, label=text, **look)
    ax.grid(axis="y", visible=False)
    ax.margins(x=0.05)


def _name_rows(ax: Axes, rows: Mapping[tuple[str, str], str], shades: Mapping[str, Any], named: bool) -> None:
    """The names of the rows, each in the colour of its record's ellipses."""
    ax.set_yticks(range(len(rows)), rows.values() if named else [""] * len(rows))
    ax.set_ylim(len(rows) - 0.4, -0.6)
    for text, (test, run) in zip(ax.get_yticklabels(), rows, strict=True):
        text.set(fontweight="normal" if run else "bold", color=shades.get(test, "black"))


def _shades(own: pd.DataFrame) -> dict[str, Any]:
    """A colour for each record of a foundation."""
    tests = own[own["level"] == "run"]["test"].unique()
    return dict(zip(tests, colormaps["inferno"](np.linspace(0, BRIGHTEST, len(tests))), strict=True))


def _numbered(axis: Any) -> None:
    """Ticks along an axis, with powers of ten and as many digits as tell them apart; along x at both ends."""
    low, high = axis.get_view_interval()
    ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(low, high)
    ticks = [tick for tick in ticks if low < tick < high]
    several = ([quantity(tick, digits=digits) for tick in ticks] for digits in range(2, 7))
    texts = next(each for each in several if len({*each}) == len(each))
    if axis.axis_name == "x":
        texts[1:-1] = [""] * len(texts[1:-1])
    axis.set_ticks(ticks, texts)


def _ellipses(ax: Axes, own: pd.DataFrame, names: list[str]) -> None:
    """Two parameters of each run, with the ellipse of 95 % of their uncertainty; a colour per record."""
    runs = own[own["level"] == "run"]
    first, second = (
        runs[runs["parameter"] == name].set_index(["test", "run"])[["value", "u", "correlation"]]
        for name in names
    )
    both = first.merge(second, left_index=True, right_index=True)
    shades = _shades(own)
    angle = np.linspace(0, 2 * np.pi, 90)
    for (test, _), row in both.iterrows():
        x, y = ellipse(row["u_x"], row["u_y"], row["correlation_y"], angle)
        ax.plot(
            row["value_x"] + x,
            row["value_y"] + y,
            color=shades[test],
            linewidth=0.8,
            solid_capstyle="round",
        )
        ax.plot(row["value_x"], row["value_y"], ".", color=shades[test], markersize=3)
    ax.set(xlabel=style.axis_of(names[0]), ylabel=style.axis_of(names[1]))
    ax.margins(0.08)
    for axis in (ax.xaxis, ax.yaxis):
        _numbered(axis)


def ellipse(u_x: float, u_y: float, correlation: float, angle: Floats) -> tuple[Floats, Floats]:
    """The ellipse that holds 95 % of two correlated normal variables, about their means."""
    return (
        MARGIN * u_x * np.cos(angle),
        MARGIN * u_y * (correlation * np.cos(angle) + np.sqrt(1 - correlation**2) * np.sin(angle)),
    )
