"""Tables 1 to 3 of Spanos et al. 2017 for any campaign, as a reader sees them.

Each table has one definition of its columns: Markdown, LaTeX and the report take their cells from it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd

from freerock.models.laws import MODEL_LABELS, SYMBOLS
from freerock.tables.text import fixed, quantity, with_unit

SIMULATED_NOTE = "The records are simulated; they are not the laboratory's data."
RUN_BY_RUN_NOTE = (
    "Identified: jointly, with its standard error. Run by run: mean and standard deviation of the fits of "
    "single runs; where it exceeds the standard error, releases differ by more than the noise."
)
REJECTED = " †"
REJECTED_NOTE = (
    "† Rejected by most of the runs: more than noise is left, and the numbers describe the fit, not the "
    "foundation. What explains the runs: table of candidates."
)
SELECTED = " ‡"
SELECTED_NOTE = (
    "‡ The one chosen for most of the runs: it explains them with as few numbers as the data allow, or comes "
    "nearest where none does."
)
PUBLISHED_NOTE = "Published values: doi:{doi}; they stem from the laboratory's own records."

# Operators miss a nominal angle by some tenths of a degree, 5 % in the virtual campaign.
NOMINAL_DIFFERS = 0.25

Labels = Mapping[str, str]


class Cell(NamedTuple):
    """A cell of a table: its text, what it is sorted by, the anchor it leads to, and its verdict."""

    text: str
    value: float | str = ""
    anchor: str = ""
    kind: str = ""


class Column(NamedTuple):
    """A column of a table: its head, and the cell it makes of a row of the numeric frame."""

    head: str
    cell: Callable[[Any], Cell]


class Printed(NamedTuple):
    """A printed table.

    frame holds the numbers, columns how each row of it is shown, text the cells as printed on paper.
    """

    frame: pd.DataFrame
    columns: Sequence[Column]
    text: pd.DataFrame
    caption: str
    notes: Sequence[str] = ()


def number(text: str, value: float) -> Cell:
    """A cell sorted by its number; without one it is sorted last."""
    return Cell(text, float(value) if math.isfinite(value) else "")


def _given(name: str) -> Callable[[Any], Cell]:
    def cell(row: Any) -> Cell:
        value = getattr(row, name)
        return number(f"{value:.4g}" if math.isfinite(value) else "–", value)

    return cell


def _failed(row: Any) -> str:
    """What is printed after a number of a fit that may not be used."""
    return "" if row.success else " (failed fit)"


def _mark(row: Any) -> str:
    return SELECTED if row.selected else REJECTED if row.rejected else ""


def _between_runs(row: Any) -> str:
    """Mean and standard deviation of what the single runs of a record gave; "–" for a single one."""
    return quantity(row.run_mean, row.run_scatter) if math.isfinite(row.run_scatter) else "–"


_MODEL = Column("Model", lambda row: Cell(MODEL_LABELS[row.model] + _mark(row)))
PARAMETER = Column("Parameter", lambda row: Cell(with_unit(SYMBOLS[row.parameter], row.unit)))
_RUN_BY_RUN = Column("Run by run", lambda row: number(_between_runs(row), row.run_mean))

TABLE1 = (
    Column("2h / m", _given("height_m")),
    Column("2b / m", _given("width_m")),
    Column("h/b", _given("slenderness")),
    Column("m / kg", _given("mass_kg")),
    Column("θ₀ nominal / °", _given("release_angle_nominal_deg")),
    Column(
        "θ₀ measured / °",
        lambda row: number(quantity(row.release_angle_deg, row.release_angle_std_deg), row.release_angle_deg),
    ),
)
TABLE2 = (
    _MODEL,
    PARAMETER,
    Column("Identified", lambda row: number(quantity(row.value, row.stderr) + _failed(row), row.value)),
    _RUN_BY_RUN,
    Column("Published", lambda row: number(quantity(row.published), row.published)),
)
TABLE3 = (
    _MODEL,
    Column(
        "ε_θ / %",
        lambda row: number(quantity(100 * row.epsilon_theta) + _failed(row), row.epsilon_theta),
    ),
    Column("Published / %", lambda row: number(fixed(100 * row.published, 2), row.published)),
    Column("t_f / s", lambda row: number(fixed(row.final_time_s, 2), row.final_time_s)),
)


def printed_tables(
    frames: Mapping[str, pd.DataFrame],
    origin: str,
    *,
    doi: str = "",
    labels: Labels | None = None,
) -> dict[str, Printed]:
    """Tables 1 to 3 of Spanos et al. 2017 for another campaign.

    Parameters
    ----------
    frames : mapping of str to pandas.DataFrame
        The numbers of "table1" to "table3", see `freerock.tables.summary`.
    origin : str
        Of the records, "measured" or "simulated".
    doi : str, optional
        Of the publication whose values stand beside; empty without one.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    dict of str to Printed
        By name, "table1" to "table3".
    """
    first, second, third = (frames[name] for name in ("table1", "table2", "table3"))
    simulated = [SIMULATED_NOTE] if "simulated" in origin else []
    notes = [*simulated, PUBLISHED_NOTE.format(doi=doi)] if doi else simulated
    columns = table2_columns(second)
    return {
        "table1": Printed(
            first,
            TABLE1,
            table1_text(first, labels),
            "Block configurations",
            [*angle_notes(first, labels), *simulated],
        ),
        "table2": Printed(
            second,
            columns,
            table2_text(second, labels),
            f"Identified parameters, {_of_runs(second)}",
            [*_marked_notes(second), *([RUN_BY_RUN_NOTE] if _RUN_BY_RUN in columns else []), *notes],
        ),
        "table3": Printed(
            third,
            TABLE3,
            table3_text(third, labels),
            f"Discrepancy ε_θ between measured and modelled rotation up to t_f, {_of_runs(third)}",
            [*_marked_notes(third), *notes],
        ),
    }


def table1_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table1` as printed: one column per block, named by its label."""
    text = {"": [column.head for column in TABLE1]}
    for row in frame.itertuples():
        text[(labels or {}).get(row.block, row.block)] = [column.cell(row).text for column in TABLE1]
    return pd.DataFrame(text)


def angle_notes(frame: pd.DataFrame, labels: Labels | None = None) -> list[str]:
    """A note for each block of `summary.table1` that was released at another angle than the nominal one."""
    return [
        f"{(labels or {}).get(row.block, row.block)} was released at {row.release_angle_deg:.3g}°, not "
        f"at the nominal {row.release_angle_nominal_deg:.3g}°: is release_angle_deg right, and in degrees?"
        for row in frame.itertuples()
        if abs(row.release_angle_deg / row.release_angle_nominal_deg - 1) > NOMINAL_DIFFERS
    ]


def table2_columns(frame: pd.DataFrame) -> Sequence[Column]:
    """Columns of `summary.table2`; what the single runs gave stands beside where a record has several."""
    several = frame["run_scatter"].notna().any()
    return [column for column in TABLE2 if several or column is not _RUN_BY_RUN]


def table2_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table2` as printed: a row per foundation, model and parameter, grouped by block."""
    return _grouped(frame, labels, table2_columns(frame))


def table3_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table3` as printed: a row per foundation and model, grouped by block."""
    return _grouped(frame, labels, TABLE3)


def name_of(test: str, run: str | int) -> str:
    """Printed name of what a fit is of: a record, or a run of it."""
    return test if str(run) == "pooled" else f"{test}, run {run}"


def _marked_notes(frame: pd.DataFrame) -> list[str]:
    notes = {"selected": SELECTED_NOTE, "rejected": REJECTED_NOTE}
    return [note for status, note in notes.items() if frame[status].any()]


def _of_runs(frame: pd.DataFrame) -> str:
    """Whether the fits of `summary.table2` or `summary.table3` are joint ones, in words."""
    joint = frame["run"].astype(str) == "pooled"
    if joint.all():
        return "all runs of a record jointly"
    return "all runs of a record jointly, or run by run" if joint.any() else "run by run"


def _grouped(frame: pd.DataFrame, labels: Labels | None, columns: Sequence[Column]) -> pd.DataFrame:
    """Printed rows under the name of their block; a repeated foundation or model is left blank."""
    labels, heads = labels or {}, ["Foundation", *(column.head for column in columns)]
    text: list[dict[str, str]] = []
    for block, rows in frame.groupby("block", sort=False):
        if frame["block"].nunique() > 1:
            text.append({"Foundation": labels.get(block, block)})
        for foundation, own in rows.groupby("foundation", sort=False):
            several = len(own[["test", "run"]].drop_duplicates()) > 1
            for (test, run), fits in own.groupby(["test", "run"], sort=False):
                name = labels.get(foundation, foundation)
                name += f" ({name_of(test, run)})" if several else ""
                printed = pd.DataFrame(
                    [[name, *(column.cell(row).text for column in columns)] for row in fits.itertuples()],
                    columns=heads,
                )
                for head in ("Model", "Foundation"):
                    printed[head] = printed[head].mask(printed[head].duplicated(), "")
                text += printed.to_dict("records")
    return pd.DataFrame(text, columns=heads).fillna("")
