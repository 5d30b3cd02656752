"""What the table of choices says: which fits may be the law of a run, and how many runs name one."""

import pandas as pd

from freerock.tables.number_text import number_of

POSSIBLE = ("selected", "also_possible")
STATUS_WORDS = {
    "selected": "selected",
    "also_possible": "possible",
    "rejected": "rejected",
    "not_fitted": "not fitted",
}


def named_by(model: str, choice: pd.DataFrame) -> str:
    """For how many of the runs of the tidy table choice a candidate is selected: "12 of 18 runs"."""
    n = len(choice[["test", "run"]].astype(str).drop_duplicates())
    own = choice[(choice["model"] == model) & (choice["status"] == "selected")]
    return f"{len(own)} of {number_of(n, 'run')}"


def laws_of_foundations(choice: pd.DataFrame) -> dict[str, str]:
    """By foundation the candidate that is selected for most of its runs; "" where none is for any."""
    found = {}
    for foundation, own in choice.groupby("foundation", sort=False):
        named = own[own["status"] == "selected"]["model"].value_counts()
        found[str(foundation)] = str(named.index[0]) if len(named) else ""
    return found


def rejected_laws(choice: pd.DataFrame) -> set[tuple[str, str, str]]:
    """Block, foundation and candidate that some runs reject and none may have; "" stands for all blocks.

    Parameters
    ----------
    choice : pandas.DataFrame
        Tidy table.
    """
    found = set()
    for block, own in [("", choice), *choice.groupby("block")]:
        for (foundation, model), statuses in own.groupby(["foundation", "model"])["status"]:
            if "rejected" in {*statuses} and not {*statuses} & {*POSSIBLE}:
                found.add((str(block), str(foundation), str(model)))
    return found
