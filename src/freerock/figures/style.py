"""What all figures share: the style sheet, line styles, thinning, the footer, and writing to files."""

import functools
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import NDArray
from PIL import Image

from freerock.figures.looks import MEASURED
from freerock.figures.looks import Style as Style
from freerock.files import atomic
from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.tables.csvfile import write_csv
from freerock.tables.number_text import fixed, in_words, with_unit

Axes = Any
"""Axes of Matplotlib: its hints do not say what an array of them holds."""
Labels = Mapping[str, str] | None
"""Printed names of blocks and foundations, where they have any."""
Drawing = tuple[Figure, pd.DataFrame]
"""A figure and the numbers drawn."""

WIDTH_IN = 7.0  # both columns of a journal's page: 178 mm
HERE = Path(__file__).parent
LIGATURES = {
    "GSUB",
    "GPOS",
    "GDEF",
    "kern",
}  # and the like; without, a font is embedded in a quarter of the time
styled = functools.partial(matplotlib.rc_context, fname=HERE / "freerock.mplstyle")
"""Context manager and decorator that draws in the style sheet, whatever the user's own settings are."""


def legend_columns(labels: Sequence[str], room: float = 1.0) -> int:
    """How many columns of a legend fit side by side into so much of the figure's width."""
    points = _points("legend.fontsize")
    inches = room * WIDTH_IN
    beside = points * (matplotlib.rcParams["legend.handlelength"] + 2.8)  # handle and spaces
    widths = [beside + CHARACTER * points * len(text.replace("$", "")) for text in labels]
    for n in range(len(labels), 1, -1):
        if sum(map(max, np.array_split(widths, n))) <= 72 * inches - points:
            return n
    return 1


def wrapped(text: str, room: float) -> str:
    """A title or label of an axis without formulas, broken where it is wider than so much of the figure."""
    characters = room * WIDTH_IN * 72 / (CHARACTER * _points("axes.titlesize"))
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
COLOURS = 64  # of a PNG: lines, text and their smooth edges need no more
PURE = {1: 0, 254: 255}  # what the choice of colours makes of black and white
FOOTER = "simulated record – not the laboratory's data"


def label(labels: Labels, *names: str) -> str:
    """Printed names of a block, a foundation or both, to be drawn; the name itself where none is given."""
    return ", ".join(as_text((labels or {}).get(name) or name) for name in names)


def as_text(text: str) -> str:
    """A user's text as Matplotlib draws it: a $ begins no formula, a _ leaves nothing out of a legend."""
    return text.replace("$", r"\$") if text[:1] != "_" else as_text(f" {text}")


def axis_of(parameter: str) -> str:
    """Label of an axis along which a parameter is drawn, "k / (N m⁻²)"."""
    return with_unit(SYMBOLS[parameter], PARAMETERS[parameter].unit)


def letter(index: int) -> str:
    """Letter of a panel: a to z, aa, ab and so on."""
    more, last = divmod(index, 26)
    return (letter(more - 1) if more else "") + chr(97 + last)


def entitle(ax: Axes, index: int, n_panels: int, text: str, room: float) -> None:
    """Give a panel its title in so much of the figure's width, with a letter where there are several.

    With its height given, Matplotlib does not look for one at each drawing.
    """
    ax.set_title(wrapped(f"({letter(index)}) {text}" if n_panels > 1 else text, room), loc="left", y=1.0)


def recorded(origin: str) -> Style:
    """Look and label of a record, measured or simulated, for what is drawn now."""
    return MEASURED | {"label": "simulated record" if origin == "simulated" else origin}


def drawn_runs(data: pd.DataFrame, labels: Labels = None) -> str:
    """Sentence of a caption about the runs drawn; what to say where there is none."""
    runs = data[["test", "run"]].dropna().astype(str).drop_duplicates()
    of_runs: dict[tuple[str, ...], list[str]] = {}  # tests by the runs that are drawn of each
    for test, own in runs.groupby("test", sort=False)["run"]:
        of_runs.setdefault(tuple(own), []).append(str(test))
    named = [
        f"run{'s' * (len(each) > 1)}\N{NO-BREAK SPACE}{in_words(each)} of {in_words(tests)}"
        for each, tests in of_runs.items()
    ]
    return f"Drawn: {'; '.join(named)}." if named else "No run can be drawn."


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
    figure = Figure(figsize=(WIDTH_IN, 0.8))
    figure.set_layout_engine("none")
    figure.text(0.5, 0.6, why, ha="center")
    footer(figure, origin)
    return figure


def fit_beside(n: int, narrowest_in: float) -> int:
    """How many of so many panels stand side by side in the figure's width."""
    return max(1, min(n, int(WIDTH_IN / narrowest_in)))


NARROWEST_IN, ALONE_IN = 1.7, 2.1  # of a panel of a scene, below one of its foundation and else
Scene = tuple[str, str]
"""A block on a foundation."""


def scenes_in(table: pd.DataFrame) -> list[Scene]:
    """The blocks and their foundations of a table, in its order."""
    return [*table[["block", "foundation"]].drop_duplicates().itertuples(index=False, name=None)]


def of_scene(table: pd.DataFrame, block: str, foundation: str) -> pd.DataFrame:
    """The rows of a block on a foundation."""
    return table[(table["block"] == block) & (table["foundation"] == foundation)]


def _places(scenes: Sequence[Scene]) -> tuple[int, int, dict[Scene, tuple[int, int]]]:
    """Rows, columns and the place of each scene: blocks by foundations where most of these occur, else one
    after the other."""
    above, under = (list(dict.fromkeys(names)) for names in zip(*scenes, strict=True))
    if 1 < len(under) <= fit_beside(len(under), NARROWEST_IN) and 2 * len(scenes) > len(above) * len(under):
        places = {(block, base): (above.index(block), under.index(base)) for block, base in scenes}
        return len(above), len(under), places
    rows = -(-len(scenes) // fit_beside(len(scenes), ALONE_IN))
    beside = -(-len(scenes) // rows)
    return rows, beside, {scene: divmod(i, beside) for i, scene in enumerate(scenes)}


def panels_per_scene(
    scenes: Sequence[Scene],
    labels: Labels,
    height_in: float,
    ratios: Sequence[float] = (1.0,),
    **shared: Any,
) -> tuple[Figure, dict[Scene, tuple[Axes, ...]]]:
    """A figure with panels for each block on a foundation, titled.

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
    figure = Figure(figsize=(WIDTH_IN, 0.5 + height_in * rows))
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


def outer_labels(panels: Iterable[Axes], x: str, y: str) -> None:
    """Label the axes of panels at the left and at the foot."""
    specs = [(ax, ax.get_subplotspec()) for ax in panels]
    places = [(ax, spec.rowspan.start, spec.colspan.start) for ax, spec in specs]
    lowest = {column: row for row, column in sorted(place[1:] for place in places)}
    for ax, row, column in places:
        if row == lowest[column]:
            ax.set_xlabel(x)
        if column == 0:
            ax.set_ylabel(y)


def shown(figure: Figure) -> dict[str, Artist]:
    """What the panels of a figure show with a label, by label."""
    return {
        label: each for ax in figure.axes for each, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }


def finish(figure: Figure, origin: str, handles: Sequence[Artist] = ()) -> None:
    """A legend above the panels, of the handles or else of what they show, each label once; the footer."""
    known = {str(each.get_label()): each for each in handles} or shown(figure)
    if known:
        figure.legend(handles=[*known.values()], loc="outside upper right", ncols=legend_columns([*known]))
    footer(figure, origin)


def scale_by_noise(residual: Axes, furthest: float, few: bool = False) -> None:
    """Make the axis of a residual over the noise linear about zero and logarithmic beyond, up to its largest.

    Grey is the band that holds 95 % of white noise. Its edges lie on top: a residual that is noise hides the
    band. With `few` numbers, for a low panel, 10 has none: it would touch 3.
    """
    residual.axhspan(-NOISE, NOISE, facecolor="0.85", linewidth=0)
    for edge, label in ((-NOISE, None), (NOISE, "95 % of the noise")):
        residual.axhline(edge, color=NOISE_COLOUR, linewidth=0.8, zorder=3, label=label)
    residual.set_yscale("symlog", linthresh=LINEAR)
    decades = [10.0**power for power in range(1, 7) if 10**power < furthest]
    ticks = [-each for each in decades[::-1]] + [-LINEAR, 0.0, LINEAR] + decades
    crowded = {10.0} if few else set()  # beside 3
    residual.set_yticks(ticks, [fixed(tick, 0) if abs(tick) not in crowded else "" for tick in ticks])
    residual.minorticks_off()


@styled()
def save(
    figures: Figure | Sequence[Figure],
    data: pd.DataFrame,
    stem: str | Path,
    origin: str | None = None,
) -> None:
    """Write a figure as `<stem>.pdf` and `<stem>.png`, and its numbers as `<stem>.csv`.

    Parameters
    ----------
    figures : Figure or sequence of Figure
        Several are pages to look at, of no paper: stacked in the PNG, and the pictures of them in the PDF.
    data : pandas.DataFrame
        The numbers drawn.
    stem : path-like
        Path without suffix.
    origin : str, optional
        "simulated" or "measured": written beside the numbers.
    """
    pages = [figures] if isinstance(figures, Figure) else list(figures)
    images = []
    for page in pages:
        canvas = FigureCanvasAgg(page)
        if engine := page.get_layout_engine():
            each_axis = (axis for ax in page.axes for axis in (ax.xaxis, ax.yaxis))
            for axis in filter(lambda axis: not axis.get_label_text(), each_axis):
                axis.set_label_coords(0, 0)  # else a place is sought for no text, at each drawing
            engine.execute(page)
            page.set_layout_engine("none")  # the layout found once serves PNG and PDF
            for ax in page.axes:  # its solver's last digits depend on addresses in memory
                ax.set_position(np.round(ax.get_position().bounds, 6))
        canvas.draw()
        images.append(np.array(canvas.buffer_rgba())[..., :3])
    with atomic(f"{stem}.png") as part:
        stacked, dpi = Image.fromarray(np.vstack(images)), pages[0].dpi
        few = stacked.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        few.putpalette([PURE.get(value, value) for value in few.getpalette() or ()])
        few.save(part, "png", dpi=(dpi, dpi), compress_level=4)  # 6 takes twice as long for 6 % less
    with atomic(f"{stem}.pdf") as part:
        if isinstance(figures, Figure):
            _print_pdf(figures, part)
        else:
            undated: dict[str, Any] = {"creationDate": None, "modDate": None, "title": None}
            first, *others = map(Image.fromarray, images)
            first.save(part, "pdf", resolution=dpi, save_all=True, append_images=others, **undated)
    write_csv(data if origin is None else data.assign(origin=origin), f"{stem}.csv")


def _print_pdf(figure: Figure, path: Path) -> None:
    from fontTools import subset  # a tenth of a second, which pages do without
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    subset.Options._drop_tables_default = sorted({*subset.Options._drop_tables_default, *LIGATURES})
    FigureCanvasPdf(figure).print_pdf(path, metadata={"CreationDate": None})
