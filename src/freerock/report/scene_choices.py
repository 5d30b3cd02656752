"""What is known of a block on a foundation, and which candidate explains its runs, in words."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from freerock.identification.significance_levels import NEAR, TELLS
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.models.laws import CANDIDATES, MODEL_LABELS, PAPER_MODELS, law_of
from freerock.selection.allowed_hypotheses import NOT_TRIED
from freerock.tables.candidates import MEDIANS, Answer, answers
from freerock.tables.number_text import in_words, quantity, value_text

PIVOTING = [m for m, each in CANDIDATES.items() if each.kinematics == "pivoting" and law_of(m).is_foundation]


@dataclass(frozen=True)
class SceneChoices:
    """The choices of a block on a foundation.

    Parameters
    ----------
    choice : pandas.DataFrame
        Its rows of the tidy table, of single runs.
    answers : sequence of Answer
        One per run.
    summary : mapping of str to mapping
        Rows of the table candidates by model.
    block : Block
    """

    choice: pd.DataFrame
    answers: Sequence[Answer]
    summary: Mapping[str, Mapping[str, Any]]
    block: Block

    @property
    def explained(self) -> list[Answer]:
        """Answers of the runs that a candidate explains."""
        return [each for each in self.answers if each.explained]

    def possible_on(self, foundation: bool) -> list[str]:
        """Candidates that explain a run with a compliant foundation, or with a rigid one, in their order."""
        found = {model for each in self.explained for model in each.possible}
        return [m for m in CANDIDATES if m in found and law_of(m).is_foundation == foundation]

    @cached_property
    def asked(self) -> frozenset[str]:
        """Candidates that were fitted to any run, if only by a quick fit."""
        return frozenset(self.choice["model"][tried(self.choice)])

    def frees_width(self, model: str) -> bool:
        """Whether a candidate's contact width was fitted in runs for which it is possible."""
        return bool(pd.notna(self.summary[model]["contact_width_m"]))

    def numbers(self, model: str) -> str:
        """Medians of a candidate over the runs for which it is possible: "k = 6.88·10⁶ N m⁻², λ = …"."""
        row, told = self.summary[model], []
        for column, parameter in MEDIANS.items():
            if pd.notna(row.get(column)):
                value = value_text(row[column], math.nan, PARAMETERS[parameter].unit)
                told.append(f"{SYMBOLS[parameter]} = {value}")
                if parameter == "width":
                    told[-1] += f", {100 * row[column] / self.block.width_m:.0f} % of the block's"
        return ", ".join(told)


def tried(choice: pd.DataFrame) -> "pd.Series[bool]":
    """Which rows of the tidy table are of a candidate that was fitted, if only by a quick fit."""
    return ~choice["reason"].astype(str).str.startswith(NOT_TRIED)


def unexplained(choice: pd.DataFrame) -> str:
    """How many runs no candidate explains, from the tidy table; "" where there is none."""
    found = answers(choice)
    lost = sum(not each.explained for each in found)
    if not lost:
        return ""
    return f"No candidate explains {_runs(lost, len(found)) if len(found) > 1 else 'the only run with fits'}."


def sentences(scene: SceneChoices) -> list[str]:
    """What the runs of a scene say, in words."""
    return [
        *_explains(scene),
        *_unexplained(scene),
        *_others(scene),
        *_rigid_or_compliant(scene),
        *_guided_or_pivoting(scene),
    ]


def _explains(scene: SceneChoices) -> list[str]:
    n, counted = len(scene.answers), Counter(each.model for each in scene.explained)
    named = [(MODEL_LABELS[model], counted[model]) for model in CANDIDATES if model in counted]
    if not named:
        return []
    (first, count), rest = named[0], named[1:]
    if rest:
        others = "".join(f", {name} {times} of {n}" for name, times in rest)
        return [f"No one candidate is the smallest for all runs: {first} explains {count} of {n}{others}."]
    why = "its residual is the noise of the sensor at rest, and no smaller law does as well"
    return [f"{first} explains {_runs(count, n)}: {why}."]


def _unexplained(scene: SceneChoices) -> list[str]:
    n, lost = len(scene.answers), [each for each in scene.answers if not each.explained]
    if not lost:
        return []
    whom = "the run" if n == 1 else f"any of the {n} runs" if len(lost) == n else f"{len(lost)} of {n} runs"
    told = [f"No candidate explains {whom}: each leaves more than the sensor shows at rest."]
    counted = Counter(each.model for each in lost)
    nearest = [f"{MODEL_LABELS[m]}{_in(counted[m], len(lost))}" for m in CANDIDATES if m in counted]
    if nearest:
        told.append(
            f"The nearest is {in_words(nearest)}; its parameters depend on how much of a run is fitted, and "
            "their standard errors don't say how wrong it is."
        )
    if counted[""]:
        told.append(f"For {_runs(counted[''], n)} none is near enough to be selected.")
    return told


def _others(scene: SceneChoices) -> list[str]:
    """What else could explain the runs."""
    n, counted = len(scene.explained), Counter(model for each in scene.explained for model in each.others)
    if not n:
        return []
    names = [f"{MODEL_LABELS[model]}{_in(counted[model], n)}" for model in CANDIDATES if counted[model]]
    if names:
        return [f"The data can't tell it from {in_words(names, 'or')}."]
    if (scene.choice["explains"] & (scene.choice["status"] == "rejected")).any():
        return ["No other candidate that was fitted explains as much with as few parameters."]
    return ["No other candidate that was fitted explains a run."]


def _rigid_or_compliant(scene: SceneChoices) -> list[str]:
    """A rigid block, with worn corners or without, against a compliant foundation."""
    rigid, soft = scene.possible_on(False), scene.possible_on(True)
    both = [each for each in scene.explained if len({law_of(m).is_foundation for m in each.possible}) == 2]
    if both:
        corners = " with worn corners" if scene.frees_width(rigid[-1]) else ""
        runs = _runs(len(both), len(scene.answers))
        return [
            f"{runs[:1].upper()}{runs[1:]} can be a rigid block{corners} "
            f"({scene.numbers(rigid[-1])}) as well as a block on a compliant foundation "
            f"({_told(scene, soft[0])}): these data don't tell. Measure the contact width of the corners, "
            "or release from other angles, before you quote k and λ."
        ]
    if not scene.explained:
        return _neither(scene)
    if rigid and not soft:
        what = "a rigid block on a rigid foundation"
        if scene.frees_width(rigid[-1]):
            what = "a rigid block whose edges are not where its width says, as worn corners make it"
        fitted = any(model in scene.summary for model in PAPER_MODELS if law_of(model).is_foundation)
        needless = " These runs give no reason to quote k and λ of the other laws." * fitted
        return [f"So this is {what}: {scene.numbers(rigid[-1])}.{needless}"]
    if soft and not rigid and "housner_width" in scene.asked:
        n = scene.summary["housner_width"]["n_explains"]
        if n:
            where = _runs(n, len(scene.answers))
            return [
                f"A rigid block with worn corners would leave no more than noise in {where} as well, but the "
                f"data tell it apart: its BIC is higher by more than {TELLS:g}."
            ]
        return [
            f"A rigid block with worn corners does not explain {'them' if len(scene.answers) > 1 else 'it'}."
        ]
    return []


def _neither(scene: SceneChoices) -> list[str]:
    """Worn corners and a compliant foundation where both come near and neither explains a run."""
    near = [model for model, row in scene.summary.items() if row["epsilon_theta"] <= NEAR]
    worn = [model for model in near if CANDIDATES[model].width and not law_of(model).is_foundation]
    soft = [model for model in near if law_of(model).is_foundation]
    if not (worn and soft):
        return []
    first, other = (min(models, key=lambda m: scene.summary[m]["epsilon_theta"]) for models in (worn, soft))
    rigid, compliant = (
        f"{MODEL_LABELS[model]}, ε_θ = {quantity(100 * scene.summary[model]['epsilon_theta'])} %"
        for model in (first, other)
    )
    return [
        f"Both a rigid block with worn corners ({rigid}) and a compliant foundation ({compliant}) come as "
        f"near as published fits do (ε_θ up to {100 * NEAR:g} %): nearness does not show which of them it is."
    ]


def _guided_or_pivoting(scene: SceneChoices) -> list[str]:
    """What k means: guided against pivoting."""
    pivoting = [model for model in scene.possible_on(True) if model in PIVOTING]
    guided = [model for model in scene.possible_on(True) if model not in PIVOTING]
    if guided and pivoting:
        return [
            "These data don't tell whether the base's centre moves up and down only (guided) or the block "
            "turns about the corner that stays down (pivoting), and k depends on it: "
            f"{_told(scene, guided[0])}; {_told(scene, pivoting[0])}."
        ]
    if pivoting:
        return [
            "The block turns about the corner that stays down (pivoting): quote "
            f"{MODEL_LABELS[pivoting[0]]}. k and λ of laws in which the base's centre moves up and down only "
            "are not those of this foundation."
        ]
    if not guided:
        return []
    other = "was not fitted; its k would be another"
    if scene.asked & {*PIVOTING}:
        other = "does not explain as much with as few parameters"
    return [
        f"k of {MODEL_LABELS[guided[0]]} holds for a base whose centre moves up and down only (guided). "
        f"A block that turns about the corner that stays down (pivoting) {other}."
    ]


def _told(scene: SceneChoices, model: str) -> str:
    return f"{MODEL_LABELS[model]}, {scene.numbers(model)}"


def _runs(count: int, n: int) -> str:
    if n == 1:
        return "the run"
    return f"{count} of {n} runs" if count < n else "both runs" if n == 2 else f"all {n} runs"


def _in(count: int, n: int) -> str:
    return "" if count == n else f" (in {count} of {n} runs)"
