"""What the data of a campaign do not bear, in sentences."""

import pandas as pd

from freerock.models.laws import law_of
from freerock.tables.choices import laws_of_foundations

MOST = 4  # the weightiest come first
UNLIKE = 1.2  # ratio of release angles from which durations are not compared


def limits(runs: pd.DataFrame, choice: pd.DataFrame) -> list[str]:
    """What must not be concluded, the weightiest first.

    Parameters
    ----------
    runs, choice : pandas.DataFrame
        Tidy tables.
    """
    if choice.empty:
        return ["No run was fitted: nothing is known of the foundations."]
    laws = [law for law in laws_of_foundations(choice).values() if law]
    soft = any(law_of(law).is_foundation for law in laws)
    selected = choice[choice["status"] == "selected"]
    single = (choice.groupby("test")["run"].nunique() == 1).any()
    blocks = runs.groupby("foundation")["block"].nunique()
    released = runs.assign(angle=runs["theta0_deg"].abs()).groupby(["block", "foundation"])["angle"].median()
    of_block = released.groupby("block")
    unlike = (of_block.max() > UNLIKE * of_block.min()).any()
    housner = (
        "that r of the fitted Housner law is the restitution of an impact: it also makes up for a soft base"
    )
    told = [
        ("simulated" in set(runs["origin"]), "that real blocks behave like this: the records are simulated"),
        (
            not selected["explains"].astype(bool).all(),
            "that a law is right within a swing where its residual exceeds the noise",
        ),
        (bool(unlike), "where blocks rock longest: on one foundation they were released further"),
        (soft, housner),
        (soft, "that k holds for a block that moves sideways otherwise than assumed"),
        (bool((blocks == 1).any()), "that the parameters hold for another block on the same foundation"),
        (bool(single), "how much runs differ, where a record has only one"),
        (True, "that the same holds for releases at other angles"),
    ]
    return [text for holds, text in told if holds][:MOST]
