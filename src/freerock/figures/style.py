"""What all figures share: the style sheet, line styles, thinning, the footer, and writing to files."""

import functools
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.textpath import TextPath
from matplotlib.ticker import MaxNLocator, NullFormatter
from numpy.typing import NDArray
from PIL import Image

from freerock.figures.looks import MEASURED
from freerock.figures.looks import Style as Style
from freerock.files import atomic
from freerock.models.free_parameters import SYMBOLS, unit_of
from freerock.tables.csvfile import write_csv
from freerock.tables.number_text import fixed, in_words, quantity, with_unit
from freerock.tables.number_text import number_of as number_of

Axes = Any
"""Axes of Matplotlib: its hints do not say what an array of them holds."""
Labels = Mapping[str, str] | None
"""Printed names of blocks and foundations, where they have any."""
Drawing = tuple[Figure, pd.DataFrame]
"""A figure and the numbers drawn."""

WIDTH_IN = 7.0  # both columns of a journal's page: 178 mm
HERE = Path(__file__).parent
styled = functools.partial(matplotlib.rc_context, fname=HERE / "freerock.mplstyle")
"""Context manager and decorator that draws in the style sheet, whatever the user's own settings are."""


def size(height_in: float) -> tuple[float, float]:
    """Size of a figure of so much height, as wide as both columns of a journal's page [inch]."""
    return WIDTH_IN, height_in


def legend_columns(labels: Sequence[str], room: float = 1.0) -> int:
    """How many columns of a legend fit side by side into so much of the figure's width."""
    points = _points("legend.fontsize")
    inches = room * size(1)[0]
    beside = points * (matplotlib.rcParams["legend.handlelength"] + 2.8)  # handle and spaces
    widths = [beside + _width(text, points) for text in labels]
    for n in range(len(labels), 1, -1):
        if sum(map(max, np.array_split(widths, n))) <= 72 * inches - points:
            return n
    return 1


@functools.cache
def _width(text: str, points: float) -> float:
    """Width of a text in the style's font [points]."""
    return TextPath((0, 0), text, prop=FontProperties(size=points)).get_extents().width


def wrapped(text: str, room: float) -> str:
    """A title or label of an axis without formulas, broken where it is wider than so much of the figure."""
    characters = room * size(1)[0] * 72 / (CHARACTER * _points("axes.titlesize"))
    return as_text(textwrap.fill(text.replace(r"\$", "$"), max(8, int(characters))))


def _points(parameter: Any) -> float:
    return FontProperties(size=matplotlib.rcParams[parameter]).get_size_in_points()


# Foundations in order of appearance; the first two as in Spanos et al. 2017, figure 2.
FOUNDATION_STYLES: tuple[Style, ...] = (
    {"color": "black", "linestyle": "-"},
    {"color": "#0a5bd3", "linestyle": "--"},
    {"color": "#b34700", "linestyle": "-."},
    {"color": "#00805e", "linestyle": ":"},
    {"color": "#9a4d83", "linestyle": (0, (7, 1.5, 1, 1.5, 1, 1.5))},
)
LINEAR = 3.0  # standard deviations of noise up to which a scale of residuals is linear, logarithmic beyond
NOISE_COLOUR = "#f0c000"
NOISE = 1.96  # standard deviations within which 95 % of white noise lies
CHARACTER = 0.56  # width of a character over the size of its font, as a rule
FOOTER = "simulated record – not the laboratory's data"


def label(labels: Labels, *names: str) -> str:
    """Printed names of a block, a foundation or both, to be drawn; the name itself where none is given."""
    return ", ".join(as_text((labels or {}).get(name) or name) for name in names)


def as_text(text: str) -> str:
    """A user's text as Matplotlib draws it: a $ begins no formula, a _ leaves nothing out of a legend."""
    return text.replace("$", r"\$") if text[:1] != "_" else as_text(f" {text}")


def axis_of(parameter: str) -> str:
    """Label of an axis along which a parameter is drawn, "k / (N m⁻²)"."""
    return with_unit(SYMBOLS[parameter], unit_of(parameter))


def letter(index: int) -> str:
    """Letter of a panel: a to z, aa, ab and so on."""
    more, last = divmod(index, 26)
    return (letter(more - 1) if more else "") + chr(97 + last)


def panel(index: int, n_panels: int, text: str) -> str:
    """Title of a panel, with its letter where there are several."""
    return f"({letter(index)}) {text}" if n_panels > 1 else text


def entitle(ax: Axes, index: int, n_panels: int, text: str, room: float) -> None:
    """Give a panel its letter and title, in so much of the figure's width."""
    ax.set_title(wrapped(panel(index, n_panels, text), room), loc="left")


def recorded(origin: str) -> Style:
    """Look and label of a record, measured or simulated, for what is drawn now."""
    return MEASURED | {"label": "simulated record" if origin == "simulated" else origin}


def runs_told(data: pd.DataFrame) -> str:
    """The runs of a figure's numbers, as its caption names them."""
    runs = data[["test", "run"]].dropna().astype(str).drop_duplicates()
    of_runs: dict[tuple[str, ...], list[str]] = {}  # tests by the runs that are drawn of each
    for test, own in runs.groupby("test", sort=False)["run"]:
        of_runs.setdefault(tuple(own), []).append(str(test))
    named = [
        f"run{'s' * (len(each) > 1)}\N{NO-BREAK SPACE}{in_words(each)} of {in_words(tests)}"
        for each, tests in of_runs.items()
    ]
    return "; ".join(named)


def drawn_runs(data: pd.DataFrame, labels: Labels = None) -> str:
    """Sentence of a caption about the runs drawn; what to say where there is none."""
    told = runs_told(data)
    return f"Drawn: {told}." if told else "No run can be drawn."


def thin(n_samples: int, n_drawn: int = 1000) -> NDArray[np.intp]:
    """Every so many samples, the last included, so that about `n_drawn` remain.

    Parameters
    ----------
    n_samples : int
        Samples there are.
    n_drawn : int
        Samples to keep.

    Returns
    -------
    ndarray of int
        Indices to draw.
    """
    kept = np.arange(0, n_samples, max(1, round(n_samples / n_drawn)))
    return np.union1d(kept, n_samples - 1) if n_samples else kept


def gathered(parts: Iterable[pd.DataFrame], columns: Sequence[str]) -> pd.DataFrame:
    """Frames one below the other; an empty one with the columns where there is none."""
    parts = list(parts)
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)


def legend_above(ax: Axes, handles: Sequence[Artist] | None = None) -> None:
    """Legend above the panel's right corner, clear of the curves and of the title, which moves up for it."""
    handles = handles or ax.get_legend_handles_labels()[0]
    labels = [str(handle.get_label()) for handle in handles]
    n = legend_columns(labels, 0.93)
    ax.legend(handles=handles, ncols=n, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.2)
    title = ax.get_title(loc="left")
    widest = max(title.split("\n"), key=len)
    if title and (n < len(labels) or legend_columns([widest, *labels], 0.93) <= len(labels)):
        rows = -(-len(labels) // n)
        ax.set_title(title, loc="left", pad=4 + rows * 1.6 * _points("legend.fontsize"))


def footer(figure: Figure, origin: str) -> None:
    """Say at the foot of the figure that its record is simulated, if it is."""
    if origin == "simulated":
        size = _points("legend.fontsize")
        figure.text(0.99, 0.005, FOOTER, ha="right", va="bottom", fontsize=size, color="0.35")
        if isinstance(engine := figure.get_layout_engine(), ConstrainedLayoutEngine):
            foot = 1.8 * size / 72 / figure.get_figheight()
            engine.set(rect=(0, foot, 1, 1 - foot))


def nothing_drawn(why: str, origin: str) -> Figure:
    """A figure that says why there is nothing in it."""
    figure = Figure(figsize=size(0.8))
    figure.suptitle(why, fontsize="medium")
    footer(figure, origin)
    return figure


def fit_beside(n: int, narrowest_in: float) -> int:
    """How many of so many panels stand side by side in the figure's width."""
    return max(1, min(n, int(size(1)[0] / narrowest_in)))


NARROWEST_IN, ALONE_IN = 1.7, 2.1  # of a panel of a scene, beside other foundations and beside other blocks
Scene = tuple[str, str]
"""A block on a foundation."""


def scenes_in(table: pd.DataFrame) -> list[Scene]:
    """The blocks and their foundations of a table, in its order."""
    return [*table[["block", "foundation"]].drop_duplicates().itertuples(index=False, name=None)]


def of_scene(table: pd.DataFrame, block: str, foundation: str) -> pd.DataFrame:
    """The rows of a block on a foundation."""
    return table[(table["block"] == block) & (table["foundation"] == foundation)]


def _places(scenes: Sequence[Scene]) -> tuple[int, int, dict[Scene, tuple[int, int]]]:
    """Rows, columns and the place of each scene: blocks by foundations, or side by side on a single one."""
    above, under = (list(dict.fromkeys(names)) for names in zip(*scenes, strict=True))
    if len(under) > 1:
        grid = product(enumerate(above), enumerate(under))
        places = {(block, base): (i, j) for (i, block), (j, base) in grid if (block, base) in scenes}
        return len(above), len(under), places
    rows = -(-len(above) // fit_beside(len(above), ALONE_IN))
    beside = -(-len(above) // rows)
    return rows, beside, {(block, under[0]): divmod(i, beside) for i, block in enumerate(above)}


def panels_per_scene(
    scenes: Sequence[Scene],
    labels: Labels,
    height_in: float,
    ratios: Sequence[float] = (1.0,),
    **shared: Any,
) -> tuple[Figure, dict[Scene, tuple[Axes, ...]]]:
    """A figure with a row for each block and a column for each foundation, titled; blocks stand side by side
    where there is one foundation. With many foundations the figure grows wider than its target.

    Parameters
    ----------
    scenes : sequence of (str, str)
        Block and foundation of each; places of others stay empty.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    height_in : float
        Of a row [inch], for the double column.
    ratios : sequence of float
        Heights of the panels of a scene, one above the other over the same axis.
    **shared :
        sharex and sharey, as of `Figure.subplots`.

    Returns
    -------
    figure, panels : Figure, dict of (str, str) to tuple of Axes
        The panels of each block and foundation.
    """
    n, (rows, beside, places) = len(ratios), _places(scenes)
    width, height = size(0.5 + height_in * rows)
    figure = Figure(figsize=(max(width, NARROWEST_IN * beside), height))
    axes = figure.subplots(n * rows, beside, squeeze=False, height_ratios=[*ratios] * rows, **shared)
    panels: dict[Scene, tuple[Axes, ...]] = {}
    for scene, (i, j) in places.items():
        own = panels[scene] = (*axes[n * i : n * (i + 1), j],)
        for above, ax in pairwise(own):
            ax.sharex(own[0])
            above.tick_params(labelbottom=False)
        if (i + 1, j) not in places.values():
            own[-1].tick_params(labelbottom=True)  # above an empty place
        entitle(own[0], len(panels) - 1, len(places), label(labels, *scene), 0.8 / beside)
    for ax in {*axes.flat}.difference(*panels.values()):
        ax.set_axis_off()
    return figure, panels


def panel_per_scene(
    scenes: Sequence[Scene], labels: Labels, height_in: float, **options: Any
) -> tuple[Figure, dict[Scene, Axes]]:
    """As `panels_per_scene`, with one panel for each scene."""
    figure, panels = panels_per_scene(scenes, labels, height_in, **options)
    return figure, {scene: own[0] for scene, own in panels.items()}


def outer_labels(panels: Mapping[Any, Axes], x: str, y: str) -> None:
    """Label the axes of panels at the left and at the foot."""
    specs = [ax.get_subplotspec() for ax in panels.values()]
    places = [(spec.rowspan.start, spec.colspan.start) for spec in specs]
    for ax, (row, column) in zip(panels.values(), places, strict=True):
        if (row + 1, column) not in places:
            ax.set_xlabel(x)
        if column == 0:
            ax.set_ylabel(y)


def finish(figure: Figure, origin: str) -> None:
    """One legend of all panels above them, each label once, and the footer."""
    found = [ax.get_legend_handles_labels() for ax in figure.axes]
    handles = {name: handle for each in found for handle, name in zip(*each, strict=True)}
    if handles:
        columns = legend_columns(list(handles))
        figure.legend(handles.values(), handles, loc="outside upper center", ncols=columns)
    footer(figure, origin)


def finish_with(figure: Figure, origin: str, handles: Sequence[Artist]) -> None:
    """A legend of what the handles stand for above the panels, at the right, and the footer."""
    columns = legend_columns([str(handle.get_label()) for handle in handles])
    figure.legend(handles=handles, loc="outside upper right", ncols=columns)
    footer(figure, origin)


def rows_down(ax: Axes, names: Sequence[str]) -> None:
    """Name the rows of a panel and of those that share its axis, the first at the top."""
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.4, -0.6)


def number_ticks(axis: Any, low: float, high: float, n: int = 4, room: float = 1.0) -> None:
    """Ticks of an axis of numbers with powers of ten, also of a logarithmic one of less than a decade; as
    many as stand side by side in so much of the figure's width."""
    ticks = np.array(MaxNLocator(n, steps=[1, 2, 5, 10]).tick_values(low, high))
    ticks = ticks[(low < ticks) & (ticks < high)]
    beside = room * size(1)[0] * 72 / (10 * CHARACTER * _points("xtick.labelsize"))
    ticks = ticks[:: -(-len(ticks) // max(2, int(beside)))] if len(ticks) else ticks
    texts = ([quantity(tick, digits=digits) for tick in ticks] for digits in (2, 3, 4, 5, 6))
    axis.set_ticks(ticks, next((each for each in texts if len({*each}) == len(each)), list(map(str, ticks))))


def whole_decades(axis: Any) -> None:
    """A logarithmic axis has at least one decade, and numbers at powers of ten only."""
    low, high = axis.get_view_interval()
    axis.set_view_interval(min(low, 10 ** np.floor(np.log10(high))), high, ignore=True)
    axis.set_minor_formatter(NullFormatter())


def scale_by_noise(residual: Axes, furthest: float) -> None:
    """Linear about zero, logarithmic beyond: the axis of a residual over the noise, up to its largest, with
    the band that holds 95 % of white noise. Its edges lie on top: a residual that is noise hides the band."""
    residual.axhspan(-NOISE, NOISE, facecolor="0.85", linewidth=0)
    for edge, label in ((-NOISE, None), (NOISE, "95 % of the noise")):
        residual.axhline(edge, color=NOISE_COLOUR, linewidth=0.8, zorder=3, label=label)
    residual.set_yscale("symlog", linthresh=LINEAR)
    first = 2 if furthest > 30 else 1  # 10 would touch 3
    decades = [10.0**power for power in range(first, 7) if 10**power < furthest]
    ticks = [-each for each in decades[::-1]] + [-LINEAR, 0.0, LINEAR] + decades
    residual.set_yticks(ticks, [fixed(tick, 0) for tick in ticks])
    residual.minorticks_off()


@styled()
def save(
    figures: Figure | Sequence[Figure],
    data: pd.DataFrame,
    stem: str | Path,
    origin: str | None = None,
    pdf_fonts: int = 42,
) -> None:
    """Write a figure as `<stem>.pdf` and `<stem>.png`, and its numbers as `<stem>.csv`.

    Parameters
    ----------
    figures : Figure or sequence of Figure
        Several figures become the pages of the PDF and are stacked in the PNG.
    data : pandas.DataFrame
        The numbers drawn.
    stem : path-like
        Path without suffix.
    origin : str, optional
        "simulated" or "measured": written beside the numbers.
    pdf_fonts : 42 or 3
        TrueType, as publishers want it; or outlines, written in half the time, for pages of no paper.
    """
    pages = [figures] if isinstance(figures, Figure) else list(figures)
    images = []
    for page in pages:
        canvas = FigureCanvasAgg(page)
        if engine := page.get_layout_engine():
            engine.execute(page)
            page.set_layout_engine("none")  # the layout found once serves PNG and PDF
            for ax in page.axes:  # its solver's last digits depend on addresses in memory
                ax.set_position(np.round(ax.get_position().bounds, 6))
        canvas.draw()
        images.append(np.array(canvas.buffer_rgba())[..., :3])
    with atomic(f"{stem}.png") as part:
        stacked = Image.fromarray(np.vstack(images))
        stacked.save(part, "png", dpi=(pages[0].dpi, pages[0].dpi), compress_level=3)
    undated: dict[str, Any] = {"CreationDate": None}
    fonts = matplotlib.rc_context({"pdf.fonttype": pdf_fonts})
    with fonts, atomic(f"{stem}.pdf") as part, PdfPages(part, metadata=undated) as pdf:
        for page in pages:
            FigureCanvasPdf(page).print_pdf(pdf)
    write_csv(data if origin is None else data.assign(origin=origin), f"{stem}.csv")
