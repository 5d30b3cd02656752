"""Which candidates explain the runs of each block on each foundation: choices, summed up."""

from typing import NamedTuple

import pandas as pd

from freerock.columns import columns_of
from freerock.models.laws import CANDIDATES

SCENE = ["campaign", "block", "foundation"]
COUNTS = {f"n_{status}": status for status in ("selected", "also_possible", "rejected", "not_fitted")}
# Column of the median of a parameter over the runs of a block on a foundation.
MEDIANS = {"r": "r", "k_n_m2": "k", "c_n_s_m2": "c", "lambda_n_s_m3": "lambda", "contact_width_m": "width"}
POSSIBLE = ("selected", "also_possible")
RUN_AND_MODEL = ["test", "run", "model"]
ANSWERS = ("test", "run", "status", "model", "explains", "reason")
STATUS_WORDS = {
    "selected": "selected",
    "nearest": "nearest",
    "also_possible": "possible",
    "rejected": "rejected",
    "not_fitted": "not fitted",
}


class Answer(NamedTuple):
    """What the data say of one run.

    Parameters
    ----------
    test, run : str
        Its number.
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
    of_run = dict[tuple[str, str], list[tuple[str, str, bool, str]]]()
    for test, run, *rest in zip(*(choice[name] for name in ANSWERS), strict=True):
        of_run.setdefault((test, str(run)), []).append(tuple(rest))
    found = []
    for (test, run), rows in of_run.items():
        named = (row for row in rows if row[0] == "selected")
        _, model, explains, reason = next(named, ("", "", False, ""))
        others = tuple(model for status, model, *_ in rows if status == "also_possible")
        found.append(Answer(test, run, model, bool(explains), others, reason))
    return found


def accepted_fits(choice: pd.DataFrame) -> set[tuple[str, str, str]]:
    """Test, run and candidate of the fits that explain their run and may be its law, from the tidy table."""
    known = choice[choice["status"].isin(POSSIBLE) & choice["explains"].astype(bool)]
    return set(known[RUN_AND_MODEL].astype(str).itertuples(index=False, name=None))


def of_selected(table: pd.DataFrame, choice: pd.DataFrame) -> pd.DataFrame:
    """The rows of a table of fits that are of the candidate that the choice names for their run."""
    named = choice.loc[choice["status"] == "selected", RUN_AND_MODEL].astype(str)
    return table.astype({"run": str}).merge(named, on=RUN_AND_MODEL)


def named_by(model: str, choice: pd.DataFrame) -> str:
    """How many of the runs of the tidy table choice name a candidate, in words: "12 of 18 runs"."""
    n = len(choice[["test", "run"]].astype(str).drop_duplicates())
    own = choice[(choice["model"] == model) & (choice["status"] == "selected")]
    return f"{len(own)} of {n} run{'' if n == 1 else 's'}"


def candidates_table(choice: pd.DataFrame, parameters: pd.DataFrame) -> pd.DataFrame:
    """How often each candidate is named for a block on a foundation, with what numbers.

    Parameters
    ----------
    choice, parameters : pandas.DataFrame
        Tidy tables.

    Returns
    -------
    pandas.DataFrame
        Columns of candidates.csv, one row per block, foundation and candidate. n_runs: those with a choice;
        n_selected to n_not_fitted: their number by status; n_explains: runs in which the candidate leaves no
        more than the noise at rest. epsilon_theta, epsilon_holdout: medians (fractions) of the fits that may
        be used, of all where none may. r, k_n_m2 [N/m²], c_n_s_m2 [N s/m²], lambda_n_s_m3 [N s/m³],
        contact_width_m: medians over the runs in which the candidate is named or also
        possible, NaN where there is none or it has no such parameter.
    """
    key = [*SCENE, "test", "run", "model"]
    choice, parameters = (table.assign(run=table["run"].astype(str)) for table in (choice, parameters))
    usable = parameters[parameters["success"]]
    choice["usable"] = choice.set_index(key).index.isin(usable.set_index(key).index)
    values = choice[choice["status"].isin(POSSIBLE)][key].merge(usable, on=key)
    medians = values.groupby([*SCENE, "model", "parameter"])["value"].median()
    rows = []
    for scene, asked in choice.groupby(SCENE, sort=False):
        for model in (name for name in CANDIDATES if name in set(asked["model"])):
            each = asked[asked["model"] == model]
            row = dict(zip([*SCENE, "model"], (*scene, model), strict=True))
            row |= {"n_freed": each["n_freed"].max(), "n_runs": len(each)}
            row |= {name: int((each["status"] == status).sum()) for name, status in COUNTS.items()}
            row["n_explains"] = int(each["explains"].sum())
            fitted = each[each["usable"] if each["usable"].any() else each["status"] != "not_fitted"]
            row |= {name: fitted[name].median() for name in ("epsilon_theta", "epsilon_holdout")}
            row |= {name: medians.get((*scene, model, own), float("nan")) for name, own in MEDIANS.items()}
            rows.append(row)
    return pd.DataFrame(rows, columns=columns_of("candidates")).astype({"n_freed": "Int64"})
