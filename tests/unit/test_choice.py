"""Which candidates explain a run, by evidence that is made up."""

import math
from dataclasses import replace

import fabricated
import numpy as np
import pytest

from freerock.identification.significance_levels import TELLS
from freerock.products.runs import runs_in
from freerock.selection.added_uncertainty import beside_all_that_explain
from freerock.selection.allowed_hypotheses import contains
from freerock.selection.choice import Evidence, choose, plainly

N = {
    "housner": 3,
    "housner_width": 4,
    "winkler": 4,
    "hunt_crossley": 4,
    "hunt_crossley_pivoting": 4,
    "hunt_crossley_width": 5,
    "general": 5,
}
LOUD = {"noise_p": 1e-9, "noise_ratio": 9.0, "noise_low_hz": 1.0, "noise_high_hz": 2.0}


def found(model, bic=0.0, holdout=1e-3, success=True, **numbers):
    known = {"epsilon_theta": 1e-3, "noise_p": 0.5, "epsilon_holdout": holdout} | numbers
    return Evidence(model, N[model], success, "k lies at its bound" if not success else "", bic=bic, **known)


def statuses(choice):
    return {each.evidence.model: each.status for each in choice.judged}


@pytest.mark.parametrize(
    "evidence, selected, reason",
    [
        ([found("housner", success=False)], "", "every fit failed"),
        (
            [found("housner", **LOUD), found("winkler", 35.0), found("hunt_crossley", -7.0)],
            "hunt_crossley",
            "the candidate with fewest parameters whose residual agrees with the noise (4 parameters)",
        ),
        (
            [found("housner", -5.0), found("hunt_crossley", -9.0)],
            "housner",
            "the candidate with fewest parameters whose residual agrees with the noise (3 parameters); "
            "the data can't tell it from "
            "Hunt–Crossley",
        ),
        (
            [found("hunt_crossley", -5.0, added_damping=4.0), found("general", -9.0)],
            "general",
            "the candidate with fewest parameters whose residual agrees with the noise (5 parameters)",
        ),
        (
            [found("housner", -9.0, 2e-3, **LOUD), found("winkler", -5.0, 1e-3, **LOUD)],
            "winkler",
            "no candidate explains the run; held-out ε_θ = 0.1 %, the lowest",
        ),
        (
            [found("winkler", -9.0, 1.05e-3, **LOUD), found("hunt_crossley", -5.0, 1e-3, **LOUD)],
            "winkler",
            "no candidate explains the run; held-out ε_θ = 0.105 %, "
            "the lowest BIC of 2 within a tenth of the best",
        ),
        (
            [found("winkler", -9.0, math.nan, **LOUD), found("housner", 0.0, math.nan, **LOUD)],
            "winkler",
            "no candidate explains the run; the lowest BIC",
        ),
        (
            [found("winkler", -9.0, 1.2), found("housner", 0.0, 1.4, **LOUD)],
            "",
            "every held-out ε_θ is above 1: worse than a block at rest",
        ),
    ],
)
def test_the_selected_candidate_and_why(evidence, selected, reason):
    choice = choose(evidence)
    assert (choice.selected, choice.reason) == (selected, reason)
    assert choice.explained == reason.startswith("the candidate with fewest parameters")


def test_each_candidate_with_its_reason():
    choice = choose(
        [
            found("housner", 900.0, **LOUD),
            found("housner_width", 3.0),
            found("winkler", 2.0, success=False),
            found("hunt_crossley", 1.0),
            found("hunt_crossley_pivoting", 1.0 + 2 * TELLS),
            found("general", 8.0),
            Evidence("hunt_crossley_width", 5, fitted=False, message="a smaller one explains the run"),
        ]
    )
    assert [(each.status, each.reason) for each in choice.judged] == [
        ("rejected", "the residual exceeds the noise: 9 times the power at rest, 1 to 2 Hz"),
        ("also_possible", "its residual agrees with the noise; BIC +2.0, not significant"),
        ("rejected", "k lies at its bound"),
        ("selected", "the one with fewest parameters whose residual agrees with the noise"),
        ("rejected", "its residual agrees with the noise, but the BIC is 20 higher"),
        ("rejected", "needless: hunt_crossley with 1 more parameter"),
        ("not_fitted", "a smaller one explains the run"),
    ]
    assert choice.also_possible == ("housner_width",)


def test_a_larger_candidate_that_the_data_ask_for():
    """A small misfit that the residual does not show, and the likelihood does."""
    choice = choose([found("housner", 0.0), found("hunt_crossley", -TELLS - 1)])
    assert statuses(choice) == {"housner": "rejected", "hunt_crossley": "selected"}


def test_a_candidate_worse_than_a_block_at_rest_is_never_named():
    alike = found("winkler", -50.0, 1.5), found("hunt_crossley", 0.0)
    assert choose(alike).selected == "hunt_crossley"
    runs = choose([found("winkler", -50.0, 1.5), found("hunt_crossley", 0.0, **LOUD)])
    assert runs.selected == "hunt_crossley"
    assert runs.judged[0].reason == "held-out ε_θ is worse than that of a block at rest: 150 %"


def test_worn_corners_against_a_compliant_foundation_in_words():
    worn, soft = (
        found("housner_width", 0.0, epsilon_theta=3e-6),
        found("hunt_crossley", 4.0, epsilon_theta=4e-6),
    )
    both = (
        "Both a rigid block with worn corners (Housner, width free, ε_θ = 0.0003 %) and "
        "a compliant foundation (Hunt–Crossley, ε_θ = 0.0004 %) "
        "come as near as published fits do (ε_θ up to 5 %). "
    )
    assert choose([worn, soft]).stories == both + "The data can't tell them apart."
    loud = found("hunt_crossley", 4e3, epsilon_theta=3e-3, **LOUD)
    told = choose([worn, loud]).stories
    assert told.endswith("Only Housner, width free leaves nothing but noise, which rules Hunt–Crossley out.")
    neither = choose([found("housner_width", epsilon_theta=1e-2, **LOUD), loud]).stories
    assert neither.endswith("Neither explains the run.")
    assert choose([found("housner_width", epsilon_theta=0.2, **LOUD), soft]).stories == ""


def test_what_holds_what():
    assert contains("general", "hunt_crossley") and contains("hunt_crossley_width", "hunt_crossley")
    assert contains("general_pivoting_width", "winkler_pivoting")
    assert not contains("hunt_crossley_pivoting_width", "hunt_crossley")
    assert not contains("hunt_crossley", "general") and not contains("hunt_crossley", "housner")


@pytest.mark.parametrize(
    "value, text",
    [
        (9774.0, "9770"),
        (2.0, "2"),
        (0.03214, "0.0321"),
        (3.2e-6, "0.0000032"),
        (9.77e7, "97.7 million"),
        (math.nan, "nan"),
        (math.inf, "inf"),
    ],
)
def test_reasons_have_plain_figures(value, text):
    assert plainly(value) == text


@pytest.mark.parametrize("charged, selected", [(5.0, "hunt_crossley"), (7.0, "hunt_crossley_width")])
def test_a_larger_candidate_is_told_from_its_case_by_the_likelihood(charged, selected):
    law, worn = found("hunt_crossley", 0.0), found("hunt_crossley_width", -4.0, charged=charged)
    choice = choose([law, worn])
    assert choice.selected == selected
    beaten = (
        choice.judged[0].reason
        == "its residual agrees with the noise, but −2 ln L of a larger candidate is lower by 10"
    )
    assert beaten == (selected != "hunt_crossley")
    assert choose([law, replace(worn, bic=1.0)]).selected == "hunt_crossley"
    assert not worn.rules_out(worn)
    assert not choose([found("hunt_crossley_pivoting", 0.0), worn]).judged[0].reason.startswith("needless")


def test_the_uncertainty_of_a_law_holds_a_larger_one_by_its_odds():
    tree = fabricated.record()
    run = runs_in(tree)[0]
    law = explaining(fabricated.fit(tree, "hunt_crossley", run, ()), 0.0)
    worn = explaining(fabricated.fit(tree, "hunt_crossley_width", run, ()), -3.0)
    k = law.value * [1.01, *[1.0] * (len(law.value) - 1)]
    worn = replace(worn, value=np.insert(k, worn.parameters.index("width"), 0.1))
    told = beside_all_that_explain({"hunt_crossley": law, "hunt_crossley_width": worn})
    share = 1 / (1 + math.exp(-1.5))
    assert told["hunt_crossley"].discrepancy[0] ** 2 == pytest.approx(
        law.discrepancy[0] ** 2 + share * (0.01 * law.value[0]) ** 2
    )
    assert told["hunt_crossley"].discrepancy[1] == law.discrepancy[1]
    off = worn.value[worn.parameters.index("k")] - law.value[law.parameters.index("k")]
    assert told["hunt_crossley_width"].discrepancy[worn.parameters.index("k")] ** 2 == pytest.approx(
        worn.discrepancy[worn.parameters.index("k")] ** 2 + (1 - share) * off**2
    )
    unexplained = replace(worn, diagnostics=worn.diagnostics | {"noise_p": 0.0})
    alone = beside_all_that_explain({"hunt_crossley": law, "hunt_crossley_width": unexplained})
    assert (alone["hunt_crossley"].discrepancy == law.discrepancy).all()


def explaining(fit, bic):
    return replace(fit, bic=bic, diagnostics=fit.diagnostics | {"noise_p": 0.5})
