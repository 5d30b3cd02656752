"""What the table of choices says: which fits may be the law of a run, and which law a foundation has."""

import pandas as pd

POSSIBLE = ("selected", "also_possible")
QUOTED = ("r", "k", "c", "lambda")  # parameters of the law of a foundation
STATUS_WORDS = {
    "selected": "selected",
    "also_possible": "possible",
    "rejected": "rejected",
    "not_fitted": "not fitted",
}


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
