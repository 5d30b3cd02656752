"""What the data of a campaign do not bear, in sentences."""

from collections.abc import Iterator

import pandas as pd

from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import law_of
from freerock.report.printed import Labels
from freerock.tables.choices import POSSIBLE, laws_of_foundations

MOST = 4  # the weightiest come first
UNLIKE = 1.2  # ratio of release angles from which durations are not compared


def limits(runs: pd.DataFrame, choice: pd.DataFrame, populations: pd.DataFrame, labels: Labels) -> list[str]:
    """What limits the results, a sentence each, the weightiest first.

    Parameters
    ----------
    runs, choice, populations : pandas.DataFrame
        Tidy tables.
    labels : mapping of str to str
        Printed names of foundations.
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
        "The fitted r of Housner's law also makes up for the soft base: impacts have another restitution."
    )
    told = [
        ("simulated" in set(runs["origin"]), "The records are simulated: real blocks may behave otherwise."),
        *((True, text) for text in _by_law(choice, populations, labels)),
        (
            not selected["explains"].astype(bool).all(),
            "Where the residual exceeds the noise, a law is only near within a swing.",
        ),
        (bool(unlike), "Blocks were released further on one foundation: they also rock longest for that."),
        (soft, housner),
        (soft, "k holds for blocks that move sideways as the law assumes."),
        (
            bool((blocks == 1).any()),
            "Parameters of a foundation with one block are known for that block alone.",
        ),
        (bool(single), "Records of one run leave open how much runs differ."),
        (True, "All holds for releases at the angles tested."),
    ]
    return [text for holds, text in told if holds][:MOST]


def _by_law(choice: pd.DataFrame, populations: pd.DataFrame, labels: Labels) -> Iterator[str]:
    """Foundations on which k of laws that the data can't tell apart differs by more than its ±."""
    k = populations[(populations["level"] == "record") & (populations["parameter"] == "k")]
    possible = choice.loc[choice["status"].isin(POSSIBLE), ["test", "model"]].drop_duplicates()
    of_record = k.merge(possible, on=["test", "model"]).groupby(["foundation", "test"], sort=False)
    ends = of_record.agg(low=("mean", "min"), high=("mean", "max"), u=("u_total", "max"))
    depends = ends[ends["high"] - ends["low"] > NORMAL_95 * ends["u"]]
    apart = 100 * (depends["high"] / depends["low"] - 1).groupby("foundation", sort=False).max()
    for foundation, percent in apart.items():
        name = labels.get(str(foundation), str(foundation))
        yield f"{name}: k of laws that the data can't tell apart differs by {percent:.2g} %, more than its ±."
