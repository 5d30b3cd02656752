"""Which candidates explain the runs of each block on each foundation: choices, summed up."""

from collections.abc import Sequence
from typing import NamedTuple

import pandas as pd

from freerock.models.laws import CANDIDATES, MODEL_LABELS, PARAMETERS, SYMBOLS
from freerock.tables.paper import SIMULATED_NOTE, Cell, Column, Labels, Printed, number
from freerock.tables.text import quantity, with_unit

SCENE = ["campaign", "block", "foundation"]
COUNTS = {
    "n_selected": "selected",
    "n_also_possible": "also_possible",
    "n_rejected": "rejected",
    "n_not_fitted": "not_fitted",
}
MEDIANS = {
    "r": "r",
    "k_n_m2": "k",
    "c_n_s_m2": "c",
    "lambda_n_s_m3": "lambda",
    "contact_width_m": "width",
}
COLUMNS = [*SCENE, "model", "n_freed", "n_runs", *COUNTS, "n_explains"]
COLUMNS += ["epsilon_theta", "epsilon_holdout", *MEDIANS]
POSSIBLE = ("selected", "also_possible")
NOTE = (
    "Number of runs in which a candidate is named (of those that leave no more than the noise at rest and "
    "that the data can't tell apart, the one with the fewest numbers; where there is none, the nearest), "
    "also possible, rejected, or not fitted. ε_θ: median of the runs to which it was fitted; parameters: of "
    "those in which it is named or possible."
)


class Answer(NamedTuple):
    """What the data say of one run, or of all runs of a record jointly.

    Parameters
    ----------
    test, run : str
        Its number, or "pooled".
    model : str
        The candidate named, or the nearest where none explains the run; "" where there is none.
    explained : bool
        Whether it leaves no more than the noise at rest.
    others : tuple of str
        Candidates that the data can't tell from it.
    reason : str
        Why it is named.
    """

    test: str
    run: str
    model: str
    explained: bool
    others: tuple[str, ...]
    reason: str

    @property
    def possible(self) -> tuple[str, ...]:
        """The one named, and those that can't be told from it."""
        return (self.model, *self.others) if self.model else self.others


def answers(choice: pd.DataFrame) -> list[Answer]:
    """What each run says, from the rows of the tidy table choice."""
    found = []
    for (test, run), own in choice.groupby(["test", "run"], sort=False):
        named = own[own["status"] == "selected"]
        model, reason = ("", "") if named.empty else named[["model", "reason"]].iloc[0]
        others = tuple(own[own["status"] == "also_possible"]["model"])
        found.append(Answer(test, str(run), model, bool(named["explains"].any()), others, reason))
    return found


def single_runs(choice: pd.DataFrame) -> pd.DataFrame:
    """The rows of the tidy table choice that are of single runs, not of all runs jointly."""
    return choice[choice["run"].astype(str) != "pooled"]


def candidates_table(choice: pd.DataFrame, parameters: pd.DataFrame) -> pd.DataFrame:
    """How often each candidate is named for a block on a foundation, with what numbers.

    Parameters
    ----------
    choice, parameters : pandas.DataFrame
        Tidy tables.

    Returns
    -------
    pandas.DataFrame
        Columns `COLUMNS`, one row per block, foundation and candidate, of single runs. n_runs: those with a
        choice; n_selected to n_not_fitted: their number by status; n_explains: runs in which the candidate
        leaves no more than the noise at rest. epsilon_theta, epsilon_holdout: medians (fractions). r, k_n_m2
        [N/m²], c_n_s_m2 [N s/m²], lambda_n_s_m3 [N s/m³], contact_width_m: medians over the runs in which the
        candidate is named or also possible, NaN where there is none or it has no such parameter.
    """
    runs = single_runs(choice)
    possible = runs[runs["status"].isin(POSSIBLE)]
    key = [*SCENE, "test", "run", "model"]
    usable = parameters[parameters["success"]].assign(run=lambda frame: frame["run"].astype(str))
    values = possible[key].assign(run=possible["run"].astype(str)).merge(usable, on=key)
    medians = values.groupby([*SCENE, "model", "parameter"])["value"].median()
    rows = []
    for scene, asked in runs.groupby(SCENE, sort=False):
        for model in (name for name in CANDIDATES if name in set(asked["model"])):
            each = asked[asked["model"] == model]
            row = dict(zip([*SCENE, "model"], (*scene, model), strict=True))
            row |= {"n_freed": each["n_freed"].max(), "n_runs": len(each)}
            row |= {name: int((each["status"] == status).sum()) for name, status in COUNTS.items()}
            row["n_explains"] = int(each["explains"].sum())
            row |= {name: each[name].median() for name in ("epsilon_theta", "epsilon_holdout")}
            row |= {name: medians.get((*scene, model, own), float("nan")) for name, own in MEDIANS.items()}
            rows.append(row)
    return pd.DataFrame(rows, columns=COLUMNS).astype({"n_freed": "Int64"})


def _head(name: str) -> str:
    return with_unit(SYMBOLS[MEDIANS[name]], PARAMETERS[MEDIANS[name]].unit)


def _median(name: str) -> Column:
    return Column(_head(name), lambda row: number(quantity(getattr(row, name)), getattr(row, name)))


def _count(head: str, name: str) -> Column:
    return Column(head, lambda row: number(str(getattr(row, name)), getattr(row, name)))


PRINTED = (
    Column("Candidate", lambda row: Cell(MODEL_LABELS[row.model])),
    _count("Freed", "n_freed"),
    _count("Named", "n_selected"),
    _count("Also possible", "n_also_possible"),
    _count("Rejected", "n_rejected"),
    _count("Not fitted", "n_not_fitted"),
    Column("ε_θ / %", lambda row: number(quantity(100 * row.epsilon_theta), row.epsilon_theta)),
    *map(_median, MEDIANS),
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
    columns = shown(fitted)
    labels, text = labels or {}, []
    for (block, foundation), own in fitted.groupby(["block", "foundation"], sort=False):
        scene = f"{labels.get(block, block)}, {labels.get(foundation, foundation)}"
        for row in own.itertuples():
            text.append([scene, *(column.cell(row).text for column in columns)])
            scene = ""
    heads = ["Block, foundation", *(column.head for column in columns)]
    caption = "Candidates that explain the runs"
    return Printed(fitted, columns, pd.DataFrame(text, columns=heads), caption, notes)


def shown(frame: pd.DataFrame) -> Sequence[Column]:
    """The columns of `PRINTED`, without parameters that no candidate named has."""
    empty = {_head(name) for name in MEDIANS if frame[name].isna().all()}
    return [column for column in PRINTED if column.head not in empty]
