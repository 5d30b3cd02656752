"""What the data of a campaign do not bear."""

import pandas as pd

from freerock.models.laws import CANDIDATES, law_of
from freerock.report.numbers import Sentence, Tables
from freerock.report.scene_choices import tried
from freerock.tables.candidates import answers

MOST = 3  # the weightiest come first


def limits(known: Tables, quoted: set[str]) -> list[Sentence]:
    """What must not be concluded, the weightiest first.

    Parameters
    ----------
    known : Tables
        runs, choice and foundations.
    quoted : set of str
        Candidates whose parameters are given.
    """
    choice, found = known["choice"], answers(known["choice"])
    soft = {model for model in quoted if law_of(model).is_foundation}
    transfers = known["foundations"][known["foundations"]["model"].isin(soft)]["transfers"]
    explained = [each for each in found if each.explained]
    simulated = "simulated" in set(known["runs"]["origin"])
    rigid_too = any(len({law_of(model).is_foundation for model in each.possible}) == 2 for each in explained)
    housner = choice[(choice["model"] == "housner") & (choice["status"] != "not_fitted")]
    single = choice.groupby("test")["run"].nunique() == 1
    told = [
        (simulated, "that blocks in a laboratory behave like this: the records are simulated"),
        (
            len(explained) < len(found),
            "that parameters of runs which no law explains are those of block or foundation",
        ),
        (
            rigid_too,
            "that the foundation yields: a rigid block with other corners explains some of the runs as well",
        ),
        (
            any(_sideways_open(choice, model) for model in soft),
            "that k is right if the base moves sideways in another way than assumed: that was not ruled out",
        ),
        (
            not transfers.all(),
            "that parameters found with one block hold for another: on one foundation blocks differ",
        ),
        (bool(single.any()), "how much runs scatter, if a record has only one"),
        (
            not housner["explains"].all(),
            "that r of the fitted Housner law is the restitution of an impact"
            + " where that law is rejected" * ("housner" in quoted)
            + ": the fit also compensates for a base that yields",
        ),
        (bool(found), "that the same holds for releases at other angles"),
    ]
    weighty = [text for holds, text in told if holds][:MOST]
    return [(f"{text[0].upper()}{text[1:]}.",) for text in weighty] or [("Anything: no run was fitted.",)]


def _sideways_open(choice: pd.DataFrame, model: str) -> bool:
    """Whether the same law with another motion of the base sideways is left open in a run that it explains.

    It is ruled out where it was rejected, or where a quick fit was not worth a full one.
    """
    mine = CANDIDATES[model]
    twins = [
        name
        for name, each in CANDIDATES.items()
        if (each.law, each.width) == (mine.law, mine.width) and each.kinematics != mine.kinematics
    ]
    of_run = choice.set_index(["test", "run"])
    named = of_run[(of_run["model"] == model) & (of_run["status"] == "selected") & of_run["explains"]]
    for twin in twins:
        beside = of_run[of_run["model"] == twin].reindex(named.index)
        screened = (beside["status"] == "not_fitted") & tried(beside)
        if not ((beside["status"] == "rejected") | screened).all():
            return True
    return False
