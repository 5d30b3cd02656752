"""A panel for each block on a foundation: the impacts of its runs, and those of the three laws."""

from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from math import nan

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from freerock.arrays import Floats
from freerock.errors import number_of
from freerock.figures import looks, style
from freerock.figures.style import Axes, Drawing, Labels, styled
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS
from freerock.tables.number_text import fixed, in_words
from freerock.tables.swings import first_runs, swings

MARKERS = "os^Dv<>p*h"  # of the runs of a record
SHADES = ("0.1", "0.45", "0.65")
HEIGHT_IN = 2.0
MOST_NAMED = 12  # runs in a legend
LINE = 0.09  # height of a line of text in a panel
RIGID: style.Style = {"color": "0.45", "linestyle": ":", "label": "rigid block (Housner 1963)"}
BAND: style.Style = {"color": "0.88", "label": "95 % of impacts, selected law and σ$_r$"}


def figure_of(
    y: str, label: str, point: str, rigid: Callable[[Block, float], tuple[Floats, Floats]]
) -> tuple[Callable[..., Drawing], Callable[..., str]]:
    """The functions `draw` and `caption` of a figure of all impacts against |θ| over the critical angle.

    Parameters
    ----------
    y : str
        Column of `freerock.tables.swings.swings`. r has bars, and the band of the selected law's σ_r.
    label, point : str
        Label of its axis, and what a marker stands for.
    rigid : callable
        Of a block and the largest amplitude, the line of a rigid block.
    """

    @styled()
    def draw(
        runs: pd.DataFrame,
        restitution: pd.DataFrame,
        epsilon: pd.DataFrame,
        blocks: Mapping[str, Block],
        origin: str,
        labels: Labels = None,
    ) -> Drawing:
        """Draw all runs, and the laws fitted to the first of each scene, of tidy tables.

        Returned are the figure and the numbers drawn, in the columns of `freerock.tables.swings.swings`,
        with the candidate selected for each run and, of r, its σ_r.
        """
        found = swings(runs, restitution, epsilon, blocks)
        modelled = first_runs(found)
        drawn = [found[found["source"] == "experiment"], modelled[modelled["source"].isin(PAPER_MODELS)]]
        data = pd.concat(drawn, ignore_index=True)
        data = _with_selected(data[data[y].notna()], epsilon)
        data = data if y == "r" else data.drop(columns="sigma_r")
        figure, panels = style.panel_per_scene(style.scenes_in(runs), labels, HEIGHT_IN)
        looks_of_runs = run_looks(data[data["source"] == "experiment"])
        for scene, ax in panels.items():
            own = style.of_scene(data, *scene)
            absent = _absent(own, style.of_scene(epsilon, *scene))
            far_off = _far_off(own) if y == "r" else {}
            _panel(ax, y, own[~own["source"].isin(far_off)], looks_of_runs)
            if 0 < own["amplitude"].max() < 1:
                ax.plot(*rigid(blocks[scene[0]], own["amplitude"].max()), **RIGID)
            ax.margins(0.04)
            ax.set_xlim(left=0)
            if own.empty:
                ax.text(0.5, 0.5, f"no {point}", ha="center", transform=ax.transAxes)
            _tell(ax, [*absent, *far_off.values()], at_left=y == "r")
        style.outer_labels(panels.values(), "amplitude |θ|/$θ_{cr}$", label)
        style.finish(figure, origin, _handles(figure, looks_of_runs, origin))
        return figure, data

    def caption(data: pd.DataFrame, labels: Labels = None) -> str:
        """Whether there are a band and a line of the selected law; how many points and runs are drawn."""
        told = ["Band: 95 % of the impacts by the scatter σ_r of the selected law."] * bool(len(_band(data)))
        return " ".join([*told, *_counted(data, point)])

    return draw, caption


def _counted(data: pd.DataFrame, point: str) -> list[str]:
    """Sentences about selected laws that have no line, and about the points and runs that are drawn."""
    seen = data[data["source"] == "experiment"]
    others = [MODEL_LABELS[law] for law in seen["selected"].unique() if law and law not in PAPER_MODELS]
    n = len(seen[["test", "run"]].drop_duplicates())
    drawn = f"{number_of(len(seen), point).capitalize()} of {number_of(n, 'run')}."
    return [f"No line is drawn of the selected law: {in_words(others)}."] * bool(others) + [drawn]


def run_looks(seen: pd.DataFrame) -> dict[tuple[str, str], style.Style]:
    """Marker, shade and label of each run, by test and run: the same in all panels.

    Parameters
    ----------
    seen : pandas.DataFrame
        Columns block, foundation, test and run, in the order of the panels.
    """
    runs = seen[["block", "foundation", "test", "run"]].drop_duplicates()
    tests = runs.drop_duplicates("test")
    place = dict(zip(tests["test"], tests.groupby(["block", "foundation"]).cumcount(), strict=True))
    of_place = {i: [test for test, own in place.items() if own == i] for i in place.values()}
    keys = {(str(test), str(run)): (place[test], int(run)) for test, run in runs[["test", "run"]].values}
    found = {}
    for (i, number), marker, shade in zip(sorted({*keys.values()}), cycle(MARKERS), cycle(SHADES)):
        record = style.as_text(str(of_place[i][0])) if len(of_place[i]) == 1 else f"record {i + 1}"
        name = f"run {number}" if len(of_place) == 1 else f"{record}, run {number}"
        line: style.Style = {"marker": marker, "color": shade, "linestyle": "", "markersize": 3}
        found[i, number] = line | {"markerfacecolor": "none", "label": name}
    return {run: found[key] for run, key in keys.items()}


def run_handles(looks_of_runs: Mapping[tuple[str, str], style.Style], kind: str) -> list[Artist]:
    """The markers of runs for a legend, and how many more there are; `kind` says what they are runs of."""
    named = {str(look["label"]): look for look in looks_of_runs.values()}
    handles: list[Artist] = [Line2D([], [], **look) for look in [*named.values()][:MOST_NAMED]]
    if handles:
        handles[0].set_label(f"{kind}: {handles[0].get_label()}")
    if (more := len(named) - MOST_NAMED) > 0:
        handles.append(Line2D([], [], linestyle="", label=number_of(more, "more run")))
    return handles


def _panel(ax: Axes, y: str, own: pd.DataFrame, looks_of_runs: Mapping[tuple[str, str], style.Style]) -> None:
    """A scene: markers of each run, lines of the laws, the band of scattered impacts."""
    seen = own[own["source"] == "experiment"].groupby(["test", "run"], sort=False)
    for (test, run), rows in seen:
        bars = rows["r_u"] if y == "r" else None
        look = looks_of_runs[str(test), str(run)]
        ax.errorbar(rows["amplitude"], rows[y], bars, elinewidth=0.6, **look)
    for law in PAPER_MODELS:
        rows = own[own["source"] == law].sort_values("amplitude")
        if len(rows):
            ax.plot(rows["amplitude"], rows[y], **looks.line_of(law))
    if len(band := _band(own)):
        ends = (band[y] * (1 + sign * NORMAL_95 * band["sigma_r"]) for sign in (-1, 1))
        ax.fill_between(band["amplitude"], *ends, zorder=0, linewidth=0, **BAND)


def _tell(ax: Axes, told: Sequence[str], at_left: bool) -> None:
    """Words in a lower corner; at the left below all that is drawn."""
    if not told:
        return
    text = "\n".join(told)
    if at_left:
        low, high = ax.get_ylim()
        share = 0.04 + LINE * len(text.splitlines())
        ax.set_ylim(low - (high - low) * share / (1 - share), high)
    at, side = (0.02, "left") if at_left else (0.98, "right")
    ax.text(at, 0.04, text, ha=side, transform=ax.transAxes)


def _handles(
    figure: Figure, looks_of_runs: Mapping[tuple[str, str], style.Style], origin: str
) -> list[Artist]:
    """What the markers and lines of all panels stand for."""
    drawn = style.shown(figure)
    lines = [*map(looks.line_of, PAPER_MODELS), RIGID]
    handles = run_handles(looks_of_runs, str(style.recorded(origin)["label"]))
    handles += [Line2D([], [], **line) for line in lines if line["label"] in drawn]
    return handles + [Patch(**BAND)] * (BAND["label"] in drawn)


def _absent(own: pd.DataFrame, epsilon: pd.DataFrame) -> list[str]:
    """Why laws that were fitted to the first run have no line."""
    first = own[own["source"] == "experiment"][["test", "run"]].astype(str).head(1)
    fits = epsilon.astype({"run": str}).merge(first)
    fits = fits[fits["model"].isin(set(PAPER_MODELS) - set(own["source"]))].drop_duplicates("model")
    why = {True: "at rest after\none impact", False: "failed fit"}
    return [f"{MODEL_LABELS[row.model]}: {why[bool(row.success)]}" for row in fits.itertuples()]


def _far_off(own: pd.DataFrame) -> dict[str, str]:
    """Laws whose r lies far from what was measured, with their r in words: they do not rule the axis."""
    seen = own[own["source"] == "experiment"]["r"]
    room = 2 * max(0.05, seen.max() - seen.min())
    return {
        str(law): f"{MODEL_LABELS[str(law)]}: {fixed(r.median(), 3)}"
        for law, r in own[own["source"] != "experiment"].groupby("source")["r"]
        if r.max() < seen.min() - room or r.min() > seen.max() + room
    }


def _with_selected(data: pd.DataFrame, epsilon: pd.DataFrame) -> pd.DataFrame:
    """The swings with the candidate selected for their run, "" where none is, and its σ_r."""
    chosen = epsilon[epsilon["selected"].astype(bool)]
    runs = zip(chosen["test"], chosen["run"].astype(str), strict=True)
    found = dict(zip(runs, zip(chosen["model"], chosen["sigma_r"], strict=True), strict=True))
    own = [found.get(key, ("", nan)) for key in zip(data["test"], data["run"].astype(str), strict=True)]
    return data.assign(selected=[model for model, _ in own], sigma_r=[sigma_r for _, sigma_r in own])


def _band(data: pd.DataFrame) -> pd.DataFrame:
    """The impacts of the selected law where they scatter and it is drawn."""
    if "sigma_r" not in data:
        return data[:0]
    scattered = (data["source"] == data["selected"]) & (data["sigma_r"] > 0)
    return data[scattered].sort_values("amplitude")
