"""The evidence of each block on its foundation: sentences, and a table of all candidates that were fitted."""

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import pandas as pd

from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS
from freerock.report.scene_choices import SceneChoices, sentences
from freerock.report.tables import Sortable
from freerock.tables.candidates import STATUS_WORDS, answers
from freerock.tables.number_text import chance, fixed, quantity
from freerock.tables.printed_tables import Cell, Labels, number

HEADS = ["Candidate", "Runs", "Freed", "ε_θ / %", "Held out / %", "ΔBIC"]
HEADS += ["Noise at rest", "Why, why not"]
EXPLAINED = ["Block, foundation", "Runs explained", "Selected", "Medians", "As good", "Nearest of the others"]
EACH = "Each block and foundation"  # has what all scenes have in common
IN_BRACKETS = "In brackets: in how many of the runs. "
EXPLAINED_NOTE = "Medians are over the runs that the model explains. Each row leads to its evidence."
AS_GOOD_NOTE = " As good: the data can't tell it from the selected one."
CLAUSES, DIGIT = re.compile(r"[:;,] "), re.compile(r"\d")  # of a reason
QUICK = f"{STATUS_WORDS['not_fitted']} in"  # begins the status of one that was fitted to no run
QUICK_FIT = "A quick fit, to fewer samples, rules out: {}."


def scenes_of(
    choice: pd.DataFrame,
    candidates: pd.DataFrame,
    blocks: Mapping[str, Block],
    labels: Labels,
    failed: Collection[tuple[str, str, str]] = (),
) -> list[dict[str, Any]]:
    """The evidence of each block on each foundation.

    Parameters
    ----------
    choice, candidates : pandas.DataFrame
        Tables of that name.
    blocks : mapping of str to Block
        The blocks by name.
    labels : mapping of str to str
        Printed names of blocks and foundations.
    failed : collection of (str, str, str), optional
        Test, run and candidate of the fits that may not be used.

    Returns
    -------
    list of dict
        name; explained, cells of the scene in the table of all scenes, see `EXPLAINED`; sentences, a list;
        rows of the table of candidates, one row per candidate that was fitted, if only by a quick fit;
        left_out, a sentence per reason on those that were not.
    """
    found = []
    for (block, foundation), own in choice.groupby(["block", "foundation"], sort=False):
        here = candidates[(candidates["block"] == block) & (candidates["foundation"] == foundation)]
        summary = {row["model"]: row for row in here.to_dict("records")}
        scene = SceneChoices(own, answers(own), summary, blocks[block])
        asked = [model for model in summary if model in scene.asked]
        left_out = dict[str, list[str]]()
        for model in summary:
            if model not in asked:
                why = _reason(own[own["model"] == model]).capitalize()
                left_out.setdefault(why, []).append(MODEL_LABELS[model])
        found.append(
            {
                "name": f"{labels.get(block, block)} on {labels.get(foundation, foundation)}",
                "explained": _explained(scene),
                "sentences": sentences(scene),
                "rows": [_row(scene, model, failed) for model in asked],
                "left_out": [f"{why}: {'; '.join(names)}." for why, names in left_out.items()],
            }
        )
    return found


def explained(scenes: Sequence[Mapping[str, Any]]) -> Sortable:
    """What explains the runs of each scene: a row for each, which leads to its evidence."""
    names = [Cell(scene["name"], anchor=f"evidence-{i}") for i, scene in enumerate(scenes, 1)]
    rows = [[name, *scene["explained"]] for name, scene in zip(names, scenes, strict=True)]
    used = [i for i in range(len(EXPLAINED)) if any(row[i].text != "–" for row in rows)]
    heads, rows = [EXPLAINED[i] for i in used], [[row[i] for i in used] for row in rows]
    some = any(" (" in cell.text for row in rows for cell in row[2:])
    note = IN_BRACKETS * some + EXPLAINED_NOTE + AS_GOOD_NOTE * ("As good" in heads)
    return Sortable(heads, rows, "What explains the runs of each block on its foundation", [note])


def together(scenes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The evidence of all scenes: what several have in common is there once.

    Returns
    -------
    dict
        told: sentences with the names of the scenes that share them, `EACH` where all do; heads of the table;
        rows by scene, of the candidates with a full fit; notes on the others, with the scenes of each.
    """
    told, notes = dict[str, list[str]](), dict[str, list[str]]()
    rows = []
    for scene in scenes:
        told.setdefault("\n".join(scene["sentences"]), []).append(scene["name"])
        quick = [row[0].text for row in scene["rows"] if row[1].text.startswith(QUICK)]
        rows.append([row for row in scene["rows"] if not row[1].text.startswith(QUICK)])
        for note in [QUICK_FIT.format("; ".join(quick))] * bool(quick) + scene["left_out"]:
            notes.setdefault(note, []).append(scene["name"])
    used = [i for i in range(len(HEADS)) if any(row[i].text != "–" for own in rows for row in own)]

    def named(names: list[str], each: str = "") -> str:
        return each if len(names) == len(scenes) > 1 else "; ".join(names)

    return {
        "told": [(named(names, EACH), text.split("\n")) for text, names in told.items()],
        "heads": [HEADS[i] for i in used],
        "rows": [[[row[i] for i in used] for row in own] for own in rows],
        "notes": [(named(names), note) for note, names in notes.items()],
    }


def _explained(scene: SceneChoices) -> list[Cell]:
    """How many runs are explained, by which candidates, with what numbers, and what explains them as well."""
    n = len(scene.answers)
    named = Counter(each.model for each in scene.explained)
    others = Counter(model for each in scene.explained for model in each.others if model not in named)
    nearest = Counter(each.model for each in scene.answers if not each.explained and each.model)

    def listed(counted: "Counter[str]") -> str:
        return "; ".join(
            MODEL_LABELS[model] + f" ({counted[model]})" * (counted[model] < n) for model in counted
        )

    return [
        number(f"{len(scene.explained)} of {n}", len(scene.explained)),
        Cell(listed(named) or "none", kind="" if named else "warn"),
        Cell("; ".join(scene.numbers(model) for model in named) or "–"),
        Cell(listed(others) or "–"),
        Cell(listed(nearest) or "–"),
    ]


def _row(scene: SceneChoices, model: str, failed: Collection[tuple[str, str, str]]) -> list[Cell]:
    """A candidate's cells: numbers of the fits that may be used, of all where none may."""
    run = [scene.choice["test"], scene.choice["run"]]
    named = scene.choice["bic"].where(scene.choice["status"] == "selected").groupby(run).transform("max")
    mine = scene.choice["model"] == model
    own = scene.choice[mine].assign(above=(scene.choice["bic"] - named)[mine])
    summed, status = scene.summary[model], _status(own)
    fitted = own[own["status"] != "not_fitted"]
    usable = fitted[[(row.test, str(row.run), model) not in failed for row in fitted.itertuples()]]
    used = own if usable.empty else usable
    kind = "named" if "selected" in status or "possible" in status else "warn" if "nearest" in status else ""
    medians = summed["epsilon_theta"], summed["epsilon_holdout"]
    return [
        Cell(MODEL_LABELS[model], kind=kind),
        Cell(status),
        number(str(summed["n_freed"]), summed["n_freed"]),
        *(number(quantity(100 * each), each) for each in medians),
        number(fixed(used["above"].median(), 0), used["above"].median()),
        Cell(_against_rest(used)),
        Cell(_reason(own)),
    ]


def _status(own: pd.DataFrame) -> str:
    """What the choice made of a candidate: "selected in 2, rejected in 1"."""
    counted = Counter(own["status"].where((own["status"] != "selected") | own["explains"], "nearest"))
    return ", ".join(f"{word} in {counted[kind]}" for kind, word in STATUS_WORDS.items() if counted[kind])


def _against_rest(own: pd.DataFrame) -> str:
    """The residual of a candidate that is least like the noise at rest."""
    known = own.dropna(subset=["noise_p", "noise_ratio"])
    if known.empty:
        return "–"
    worst = known.sort_values(["noise_p", "noise_ratio"], ascending=[True, False]).iloc[0]
    band = f"{quantity(worst['noise_low_hz'])}–{quantity(worst['noise_high_hz'])} Hz"
    if worst["noise_ratio"] < 1:
        return "as at rest"
    return f"{quantity(worst['noise_ratio'])} times at {band} ({chance(worst['noise_p'])})"


def _reason(own: pd.DataFrame) -> str:
    """The most frequent reason of a candidate's most frequent status; its numbers stand in other columns."""
    reasons = own["reason"][own["status"] == own["status"].mode().iloc[0]].astype(str)
    told = [[part for part in CLAUSES.split(each) if not DIGIT.search(part)] for each in reasons]
    return Counter("; ".join(each) for each in told).most_common(1)[0][0] or str(reasons.iloc[0])
