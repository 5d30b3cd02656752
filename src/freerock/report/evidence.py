"""The evidence of each block on its foundation: sentences, and a table of all candidates that were fitted."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import pandas as pd

from freerock.models.block import Block
from freerock.models.laws import MODEL_LABELS
from freerock.report.scene import Scene, jointly, sentences
from freerock.tables.candidates import answers, single_runs
from freerock.tables.paper import Cell, Labels, number
from freerock.tables.text import fixed, quantity

HEADS = ["Candidate", "Runs", "Freed", "ε_θ / %", "Held out / %", "Other runs / %", "ΔBIC"]
HEADS += ["Noise at rest", "Why, why not"]
STATUS = {
    "selected": "named",
    "nearest": "nearest",
    "also_possible": "possible",
    "rejected": "rejected",
    "not_fitted": "not fitted",
}


def scenes_of(
    choice: pd.DataFrame, candidates: pd.DataFrame, blocks: Mapping[str, Block], labels: Labels
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

    Returns
    -------
    list of dict
        name; sentences, a list; heads and rows of the table, one row per candidate that was fitted; left_out,
        a sentence on those that were not.
    """
    found = []
    for (block, foundation), own in choice.groupby(["block", "foundation"], sort=False):
        single = single_runs(own)
        here = candidates[(candidates["block"] == block) & (candidates["foundation"] == foundation)]
        summary = {row["model"]: row for row in here.to_dict("records")}
        scene = Scene(single, answers(single), summary, blocks[block])
        joint = answers(own[own["run"].astype(str) == "pooled"])
        left_out = [MODEL_LABELS[model] for model in summary if not scene.tried(model)]
        found.append(
            {
                "name": f"{labels.get(block, block)} on {labels.get(foundation, foundation)}",
                "sentences": sentences(scene) + jointly(joint, scene.answers),
                "heads": HEADS,
                "rows": [_row(scene, model) for model in summary if scene.tried(model)],
                "left_out": f"Not fitted: {'; '.join(left_out)}." if left_out else "",
            }
        )
    return found


def _row(scene: Scene, model: str) -> list[Cell]:
    """A candidate's cells: medians over the runs."""
    run = [scene.choice["test"], scene.choice["run"]]
    above = scene.choice["bic"] - scene.choice["bic"].groupby(run).transform("min")
    mine = scene.choice["model"] == model
    own, summed = scene.choice[mine].assign(above=above[mine]), scene.summary[model]
    medians = own[["epsilon_theta", "epsilon_holdout", "epsilon_holdout_runs"]].median()
    return [
        Cell(MODEL_LABELS[model], kind="named" if summed["n_selected"] + summed["n_also_possible"] else ""),
        Cell(_status(own)),
        number(str(summed["n_freed"]), summed["n_freed"]),
        *(number(quantity(100 * each), each) for each in medians),
        number(fixed(own["above"].median(), 0), own["above"].median()),
        Cell(_against_rest(own)),
        Cell(_reason(own)),
    ]


def _status(own: pd.DataFrame) -> str:
    """What the choice made of a candidate: "named in 2, rejected in 1"."""
    counted = Counter(own["status"].where((own["status"] != "selected") | own["explains"], "nearest"))
    return ", ".join(f"{word} in {counted[kind]}" for kind, word in STATUS.items() if counted[kind])


def _against_rest(own: pd.DataFrame) -> str:
    """The residual of a candidate that is least like the noise at rest."""
    known = own.dropna(subset=["noise_p", "noise_ratio"])
    if known.empty:
        return "–"
    worst = known.loc[known["noise_p"].idxmin()]
    band = f"{quantity(worst['noise_low_hz'])}–{quantity(worst['noise_high_hz'])} Hz"
    if worst["noise_ratio"] < 1:
        return "as at rest"
    return f"{quantity(worst['noise_ratio'])} times at {band} (p = {quantity(worst['noise_p'], digits=2)})"


def _reason(own: pd.DataFrame) -> str:
    """The reason of a candidate's most frequent status; where reasons differ, that of the first such run."""
    first = own[own["status"] == own["status"].mode().iloc[0]].iloc[0]
    several = own["reason"].nunique() > 1
    return f"{first['reason']} (run {first['run']} of {first['test']})" if several else str(first["reason"])
