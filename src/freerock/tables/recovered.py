"""Values identified in a simulated campaign beside those it was simulated with."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import pandas as pd

from freerock.identification.levels import NORMAL_95
from freerock.tables.paper import (
    PARAMETER,
    SIMULATED_NOTE,
    U_NOTE,
    Cell,
    Column,
    Printed,
    decimals,
    number,
    numbers,
)
from freerock.tables.quantities import quantity

RECOVERED = (
    Column("Record", lambda row: Cell(row.test)),
    Column("Run", lambda row: Cell(str(row.run))),
    PARAMETER,
    numbers("Truth", "truth", partial(quantity, digits=5)),
    Column("Identified", lambda row: number(quantity(row.value, row.u_total), row.value)),
    numbers("Error / %", "error_percent", decimals(3)),
    Column("In 1.96 u", lambda row: Cell("yes" if _inside(row) else "no")),
)


def _inside(row: Any) -> bool:
    return bool(abs(row.value - row.truth) <= NORMAL_95 * row.u_total)


def recovered_table(
    parameters: pd.DataFrame, truth: Mapping[tuple[str, int, str, str], float]
) -> pd.DataFrame:
    """Values identified in a simulated campaign beside those it was simulated with.

    Parameters
    ----------
    parameters : pandas.DataFrame
        Tidy table.
    truth : mapping of (str, int, str, str) to float
        True value by test, run, model and parameter, SI units; other models are left out.

    Returns
    -------
    pandas.DataFrame
        Columns test, run, parameter, unit, truth, value, ci95_low, ci95_high, u_total, error_percent, inside
        (the truth lies in the 95 % interval by noise).
    """
    keys = parameters[["test", "run", "model", "parameter"]].astype(str).itertuples(index=False, name=None)
    known = {(test, str(run), model, name): value for (test, run, model, name), value in truth.items()}
    true = pd.Series([known.get(key, math.nan) for key in keys], parameters.index, float)
    frame = parameters[true.notna()].assign(
        truth=true,
        error_percent=100 * (parameters["value"] / true - 1),
        inside=(parameters["ci95_low"] <= true) & (true <= parameters["ci95_high"]),
    )
    columns = ["test", "run", "parameter", "unit", "truth", "value", "ci95_low", "ci95_high", "u_total"]
    return frame[[*columns, "error_percent", "inside"]].reset_index(drop=True)


def printed_recovered(frame: pd.DataFrame) -> Printed:
    """Cells of `recovered_table`, with caption and notes."""
    caption = "Identified values and those the records were simulated with"
    n = sum(map(_inside, frame.itertuples()))
    note = f"{U_NOTE} noise, block, sensor, clock and law. {n} of {len(frame)} inside 1.96 u."
    return Printed(frame, RECOVERED, recovered_text(frame), caption, [note, SIMULATED_NOTE])


def recovered_text(frame: pd.DataFrame) -> pd.DataFrame:
    """Cells of `recovered_table` as printed."""
    rows = [[column.cell(row).text for column in RECOVERED] for row in frame.itertuples()]
    return pd.DataFrame(rows, columns=[column.head for column in RECOVERED])
