"""Tables 1 to 3 of Spanos et al. 2017 for any campaign, and those of candidates and recovered values, as a
reader sees them.

Each table has one definition of its columns: Markdown, LaTeX and the report take their cells from it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import pandas as pd

from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.tables.candidates import MEDIANS
from freerock.tables.number_text import SEEN_NOTE, SIMULATED_NOTE, between, fixed, quantity, with_unit

U_NOTE = "±: total standard uncertainty (one standard deviation) of"
RUNS_NOTE = (
    "Identified: mean of the runs that the law explains; of all fitted runs if it explains none. "
    f"{U_NOTE} their scatter, noise, block, sensor, clock and law. τ: spread between the runs beyond their "
    "noise; < where noise may explain it, not seen where noise explains all. Next run: its 95 % interval at "
    "the estimated τ. Neither is shown for a rejected law."
)
ONE_RUN_NOTE = (
    f"Identified: from one run, which does not show the scatter between runs. {U_NOTE} noise, block, "
    "sensor, clock and law."
)
REJECTED = " †"
REJECTED_NOTE = (
    "† Rejected by most of the runs: the residual exceeds the noise or an input would have to be wrong. "
    "The parameters describe the fit, not the foundation."
)
SELECTED = " ‡"
SELECTED_NOTE = (
    "‡ Selected for most of the runs: it explains them with the fewest parameters, or is nearest if none "
    "explains them."
)
STOPS_NOTE = (
    "Stops: at the minimum of ε_θ the rigid block comes to rest too soon. In phase: the best value with "
    "which it rocks for at least half the time. Neither is used further."
)
EPSILON_NOTE = (
    "ε_θ: median of the fits that may be used, of all where none may. The choice counts a failed fit as "
    "rejected."
)
GIVEN_NOTE = "Fixed and tied parameters are stated in the configuration (fits.parameters)."
UNDETERMINED_NOTE = (
    "An undetermined parameter was held: the run hardly depends on it, or the motion jumps there."
)
UNKNOWN = "not determined"
UNKNOWN_NOTE = "Not determined: the standard uncertainty exceeds the value."
NO_U_NOTE = "Without ±: the law does not explain the run, and the error of the parameter is not known."
PUBLISHED_NOTE = "Published values: doi:{doi}, from the laboratory's own records."

ANGLE_NOTE = "α: release angle; recorded: mean of the runs; ±: standard deviation between the runs."

CANDIDATES_NOTE = (
    "Number of runs in which a candidate is selected, also possible, rejected, or not fitted. Selected: the "
    "one with the fewest parameters whose residual agrees with the noise; otherwise the nearest. Parameters: "
    f"medians of the runs in which it is selected or possible. {EPSILON_NOTE}"
)

SCATTERS = 0.05  # chance of noise to scatter runs as much, above which their spread is but bounded

# Operators miss a nominal angle by some tenths of a degree, 5 % in the virtual campaign.
NOMINAL_DIFFERS = 0.25

MOST_BESIDE = 4  # blocks that have a column each

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


def numbers(head: str, name: str, text: Callable[[Any], str] = str) -> Column:
    """The column of a head and of the numbers of this name in a frame, each as the text makes it."""
    return Column(head, lambda row: number(text(getattr(row, name)), getattr(row, name)))


def with_error(head: str, name: str, error: str) -> Column:
    """The column of a head and of the numbers of this name in a frame, each with its error."""

    def cell(row: Any) -> Cell:
        value = getattr(row, name)
        return number(quantity(value, getattr(row, error)), value)

    return Column(head, cell)


def identified(mean: float, u: float) -> str:
    """A mean with its total standard uncertainty; in words where that exceeds it."""
    return UNKNOWN if is_unknown(mean, u) else quantity(mean, u)


def is_unknown(mean: Any, u: Any) -> Any:
    """Whether the total standard uncertainty exceeds a mean; of numbers or of columns."""
    return u > abs(mean)


def decimals(n: int) -> Callable[[float], str]:
    """What writes a number with so many decimals."""
    return partial(fixed, decimals=n)


def _stated(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


_FOUR_DIGITS = partial(quantity, digits=4)


def _failed(row: Any, times: float = 1.0) -> str:
    """What is printed after a number of a fit that may not be used, or that was given."""
    if not row.success and math.isfinite(row.in_phase):
        return f" (stops; in phase {quantity(times * row.in_phase)})"
    if not row.success:
        return " (failed fit)"
    given = getattr(row, "given", "")  # empty cells of a file are NaN
    return f" ({given.partition(':')[0]})" if given and isinstance(given, str) else ""


def _mark(row: Any) -> str:
    return SELECTED if row.selected else REJECTED if row.rejected else ""


def spread(row: Any) -> Cell:
    """Spread between runs in per cent of the mean; its upper bound where the scatter may be noise alone."""
    if not math.isfinite(row.tau):
        return Cell("–")
    if row.scatter_p > SCATTERS or row.tau == 0:
        bound = 100 * row.tau_high / row.mean
        return number(f"< {quantity(bound, digits=2)}" if bound else "not seen", bound)
    return number(quantity(100 * row.tau / row.mean, digits=2), row.tau / row.mean)


def _next_run(row: Any) -> Cell:
    if row.rejected or not math.isfinite(row.next_low):
        return Cell("–")
    return number(between(row.next_low, row.next_high), row.next_low)


def _range(row: Any) -> Cell:
    if row.n_runs < 2:
        return Cell("–")
    return number(between(100 * row.epsilon_low, 100 * row.epsilon_high, apart=False), row.epsilon_low)


_MODEL = Column("Model", lambda row: Cell(MODEL_LABELS[row.model] + _mark(row)))
PARAMETER = Column("Parameter", lambda row: Cell(with_unit(SYMBOLS[row.parameter], row.unit)))
_RUNS = numbers("Runs", "n_runs")
_BETWEEN_RUNS = (
    Column("τ / %", lambda row: Cell("–") if row.rejected else spread(row)),
    Column("Next run", _next_run),
)

TABLE1 = (
    numbers("2h / m", "height_m", _stated),
    numbers("2b / m", "width_m", _stated),
    numbers("h/b", "slenderness", _stated),
    numbers("m / kg", "mass_kg", _stated),
    numbers("α / °", "alpha_nominal_deg", _stated),
    with_error("α recorded / °", "alpha_deg", "alpha_std_deg"),
    numbers("θ_cr / °", "theta_cr_deg", _FOUR_DIGITS),
    numbers("R / m", "R_m", _FOUR_DIGITS),
    numbers("p / (rad s⁻¹)", "p_rad_s", _FOUR_DIGITS),
    numbers("r (Housner)", "r_housner", _FOUR_DIGITS),
)
_PUBLISHED = "Published"
TABLE2 = (
    _MODEL,
    PARAMETER,
    Column("Identified", lambda row: number(identified(row.mean, row.u_total) + _failed(row), row.mean)),
    *_BETWEEN_RUNS,
    _RUNS,
    numbers(_PUBLISHED, "published", quantity),
)
TABLE3 = (
    _MODEL,
    Column(
        "ε_θ / %",
        lambda row: number(quantity(100 * row.epsilon_theta) + _failed(row, 100.0), row.epsilon_theta),
    ),
    Column("Range / %", _range),
    _RUNS,
    Column("Published / %", lambda row: number(fixed(100 * row.published, 2), row.published)),
    numbers("t_f / s", "final_time_s", decimals(2)),
)


def _median_head(name: str) -> str:
    return with_unit(SYMBOLS[MEDIANS[name]], PARAMETERS[MEDIANS[name]].unit)


CANDIDATE_COLUMNS = (
    Column("Candidate", lambda row: Cell(MODEL_LABELS[row.model])),
    numbers("Freed", "n_freed"),
    numbers("Selected", "n_selected"),
    numbers("Also possible", "n_also_possible"),
    numbers("Rejected", "n_rejected"),
    numbers("Not fitted", "n_not_fitted"),
    Column("ε_θ / %", lambda row: number(quantity(100 * row.epsilon_theta), row.epsilon_theta)),
    *(numbers(_median_head(name), name, quantity) for name in MEDIANS),
)


RECOVERED = (
    Column("Record", lambda row: Cell(row.test)),
    Column("Run", lambda row: Cell(str(row.run))),
    PARAMETER,
    numbers("Truth", "truth", partial(quantity, digits=5)),
    with_error("Identified", "value", "u_total"),
    numbers("Error / %", "error_percent", decimals(3)),
    Column("In 1.96 u", lambda row: Cell("yes" if row.inside_total else "no")),
)


def texts(columns: Sequence[Column], frame: pd.DataFrame) -> pd.DataFrame:
    """A frame as text: the cells of each row below the heads of the columns."""
    rows = [[column.cell(row).text for column in columns] for row in frame.itertuples()]
    return pd.DataFrame(rows, columns=[column.head for column in columns])


def printed_tables(
    frames: Mapping[str, pd.DataFrame], origin: str, *, doi: str = "", labels: Labels | None = None
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
    seen = "simulated" if simulated else "measured"
    scatter = [ANGLE_NOTE] * any(math.isfinite(row.alpha_std_deg) for row in first.itertuples())
    notes = [*simulated, PUBLISHED_NOTE.format(doi=doi)] if doi else simulated
    return {
        "table1": Printed(
            first,
            table1_columns(first),
            table1_text(first, labels),
            "Block configurations",
            [SEEN_NOTE, *scatter, *angle_notes(first, labels), *simulated],
        ),
        "table2": _parameters(second, "Identified parameters, record by record", notes, labels),
        "table3": Printed(
            third,
            _beside(TABLE3, third),
            table3_text(third, labels),
            f"Discrepancy ε_θ between {seen} and modelled rotation up to t_f, median and range of the runs",
            [*_marked_notes(third), *_given_notes(third), f"{EPSILON_NOTE} t_f: of the longest run.", *notes],
        ),
    }


def printed_candidates(frame: pd.DataFrame, origin: str, labels: Labels | None = None) -> Printed:
    """The table candidates as printed: a row per candidate that was fitted, below its block and foundation.

    Parameters
    ----------
    frame : pandas.DataFrame
        The numbers.
    origin : str
        Of the records, "measured" or "simulated".
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    """
    notes = [CANDIDATES_NOTE, SIMULATED_NOTE] if "simulated" in origin else [CANDIDATES_NOTE]
    fitted = frame[frame["n_not_fitted"] < frame["n_runs"]]
    without = [name for name in MEDIANS if name not in fitted or fitted[name].isna().all()]
    columns = [each for each in CANDIDATE_COLUMNS if each.head not in map(_median_head, without)]
    labels, text = labels or {}, list[dict[str, str]]()
    for (block, foundation), own in fitted.groupby(["block", "foundation"], sort=False):
        scene = f"{labels.get(block, block)}, {labels.get(foundation, foundation)}"
        text += [{"Candidate": scene}, *texts(columns, own).to_dict("records")]
    printed = pd.DataFrame(text, columns=[column.head for column in columns]).fillna("")
    return Printed(fitted, columns, printed, "Candidates tried on the runs", notes)


def printed_recovered(frame: pd.DataFrame) -> Printed:
    """Cells of `summary.recovered_table`, with caption and notes."""
    caption = "Identified values and those the records were simulated with"
    n = frame["inside_total"].sum()
    note = f"{U_NOTE} noise, block, sensor, clock and law. {n} of {len(frame)} inside 1.96 u. "
    note += "A simulation may have no errors of block and sensor, which u covers, too."
    return Printed(frame, RECOVERED, texts(RECOVERED, frame), caption, [note, SIMULATED_NOTE])


def named(table: Printed) -> Printed:
    """Table 2 with the rows alone that are of the candidate named for their record, explained or nearest.

    Parameters
    ----------
    table : Printed
        Table 2.
    """
    frame = table.frame
    own = frame[frame["selected"].astype(bool)]
    lost = [test for test in dict.fromkeys(frame["test"]) if test not in set(own["test"])]
    none = [f"No candidate is selected for most runs of {', '.join(lost)}."] if lost else []
    return _parameters(own, f"{table.caption}, of the model selected for it", [*none, *_further(table)], None)


def of_other_laws(table: Printed) -> Printed:
    """Table 2 without the rows of `named`."""
    frame = table.frame[~table.frame["selected"].astype(bool)]
    return _parameters(frame, f"{table.caption}, of the other models", _further(table), None)


def _further(table: Printed) -> list[str]:
    """Notes of table 2 but those that depend on its rows."""
    return [note for note in table.notes if note not in _notes_on_rows(table.frame)]


def _parameters(frame: pd.DataFrame, caption: str, notes: Sequence[str], labels: Labels | None) -> Printed:
    told = [*_notes_on_rows(frame), *notes]
    return Printed(frame, table2_columns(frame), table2_text(frame, labels), caption, told)


def table1_columns(frame: pd.DataFrame) -> tuple[Column, ...]:
    """Columns of `summary.table1` as printed, without those that no block has."""
    return tuple(column for column in TABLE1 if (texts([column], frame) != "–").any(axis=None))


def table1_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table1` as printed: a column per block, named by its label; a row each of many."""
    block = Column("Block", lambda row: Cell((labels or {}).get(row.block, row.block)))
    text = texts([block, *table1_columns(frame)], frame)
    return text if len(frame) > MOST_BESIDE else text.set_index("Block").T.reset_index(names="")


def angle_notes(frame: pd.DataFrame, labels: Labels | None = None) -> list[str]:
    """A note for each block of `summary.table1` that was released at another angle than the nominal one."""
    return [
        f"{(labels or {}).get(row.block, row.block)} was released at {row.alpha_deg:.3g}°, not "
        f"at the nominal {row.alpha_nominal_deg:.3g}°: is release_angle_deg right, and in degrees?"
        for row in frame.itertuples()
        if abs(row.alpha_deg / row.alpha_nominal_deg - 1) > NOMINAL_DIFFERS
    ]


def table2_columns(frame: pd.DataFrame) -> Sequence[Column]:
    """Columns of `summary.table2`; those of how runs differ where a record has several."""
    several = (frame["n_runs"] > 1).any()
    return [column for column in _beside(TABLE2, frame) if several or column not in _BETWEEN_RUNS]


def _beside(columns: Sequence[Column], frame: pd.DataFrame) -> Sequence[Column]:
    """Columns without that of the published values, where there are none."""
    known = frame["published"].notna().any()
    return [column for column in columns if known or not column.head.startswith(_PUBLISHED)]


def table2_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table2` as printed: a row per foundation, model and parameter, grouped by block."""
    return _grouped(frame, labels, table2_columns(frame))


def table3_text(frame: pd.DataFrame, labels: Labels | None = None) -> pd.DataFrame:
    """Cells of `summary.table3` as printed: a row per foundation and model, grouped by block."""
    return _grouped(frame, labels, _beside(TABLE3, frame))


def _marked_notes(frame: pd.DataFrame) -> list[str]:
    notes = {"selected": SELECTED_NOTE, "rejected": REJECTED_NOTE}
    return [note for status, note in notes.items() if frame[status].any()]


def _given_notes(frame: pd.DataFrame) -> list[str]:
    stops = (~frame["success"].astype(bool) & frame["in_phase"].notna()).any()
    given = {*frame["given"].dropna().astype(str)} - {""} if "given" in frame else set[str]()
    notes = [STOPS_NOTE] * bool(stops) + [GIVEN_NOTE] * bool(given - {"undetermined"})
    return notes + [UNDETERMINED_NOTE] * ("undetermined" in given)


def _notes_on_rows(frame: pd.DataFrame) -> list[str]:
    """Notes of table 2 that depend on its rows."""
    numbers = frame["n_runs"].tolist()
    without = frame["success"].astype(bool) & frame["mean"].notna() & frame["u_total"].isna()
    without &= frame["given"].isna() | frame["given"].eq("")
    notes = [*_marked_notes(frame), *_given_notes(frame)]
    notes += [RUNS_NOTE] * any(n > 1 for n in numbers) + [ONE_RUN_NOTE] * (1 in numbers)
    unknown = is_unknown(frame["mean"], frame["u_total"]).any()
    return notes + [NO_U_NOTE] * bool(without.any()) + [UNKNOWN_NOTE] * bool(unknown)


def _grouped(frame: pd.DataFrame, labels: Labels | None, columns: Sequence[Column]) -> pd.DataFrame:
    """Printed rows under the name of their block; a repeated foundation or model is left blank."""
    labels, heads = labels or {}, ["Foundation", *(column.head for column in columns)]
    text: list[dict[str, str]] = []
    for block, rows in frame.groupby("block", sort=False):
        if frame["block"].nunique() > 1:
            text.append({"Foundation": labels.get(block, block)})
        for foundation, own in rows.groupby("foundation", sort=False):
            several = own["test"].nunique() > 1
            for test, fits in own.groupby("test", sort=False):
                name = labels.get(foundation, foundation)
                name += f" ({test})" if several else ""
                printed = texts(columns, fits).assign(Foundation=name)
                for head in ("Model", "Foundation"):
                    printed[head] = printed[head].mask(printed[head].duplicated(), "")
                text += printed.to_dict("records")
    return pd.DataFrame(text, columns=heads).fillna("")
