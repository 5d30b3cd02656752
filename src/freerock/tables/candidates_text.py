"""The table candidates as printed."""

from collections.abc import Sequence

import pandas as pd

from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.tables.candidates import MEDIANS
from freerock.tables.paper import EPSILON_NOTE, SIMULATED_NOTE, Cell, Column, Labels, Printed, number, numbers
from freerock.tables.quantities import quantity, with_unit

NOTE = (
    "Number of runs in which a candidate is selected, also possible, rejected, or not fitted. Selected: the "
    "one with the fewest parameters whose residual agrees with the noise; otherwise the nearest. Parameters: "
    f"medians of the runs in which it is selected or possible. {EPSILON_NOTE}"
)


def _head(name: str) -> str:
    return with_unit(SYMBOLS[MEDIANS[name]], PARAMETERS[MEDIANS[name]].unit)


PRINTED = (
    Column("Candidate", lambda row: Cell(MODEL_LABELS[row.model])),
    numbers("Freed", "n_freed"),
    numbers("Selected", "n_selected"),
    numbers("Also possible", "n_also_possible"),
    numbers("Rejected", "n_rejected"),
    numbers("Not fitted", "n_not_fitted"),
    Column("ε_θ / %", lambda row: number(quantity(100 * row.epsilon_theta), row.epsilon_theta)),
    *(numbers(_head(name), name, quantity) for name in MEDIANS),
)


def printed_candidates(frame: pd.DataFrame, origin: str, labels: Labels | None = None) -> Printed:
    """`candidates_table` as printed: a row per candidate that was fitted, grouped by block and foundation.

    Parameters
    ----------
    frame : pandas.DataFrame
        The numbers.
    origin : str
        Of the records, "measured" or "simulated".
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    """
    notes = [NOTE, SIMULATED_NOTE] if "simulated" in origin else [NOTE]
    fitted = frame[frame["n_not_fitted"] < frame["n_runs"]]
    columns = _shown(fitted)
    labels, text = labels or {}, []
    for (block, foundation), own in fitted.groupby(["block", "foundation"], sort=False):
        scene = f"{labels.get(block, block)}, {labels.get(foundation, foundation)}"
        text.append([scene, *[""] * (len(columns) - 1)])
        text += [[column.cell(row).text for column in columns] for row in own.itertuples()]
    heads = [column.head for column in columns]
    caption = "Candidates that explain the runs"
    return Printed(fitted, columns, pd.DataFrame(text, columns=heads), caption, notes)


def _shown(frame: pd.DataFrame) -> Sequence[Column]:
    """The columns of `PRINTED`, without parameters that no candidate named has."""
    empty = {_head(name) for name in MEDIANS if name not in frame or frame[name].isna().all()}
    return [column for column in PRINTED if column.head not in empty]
