"""The rows of laws and parameters: complete, and consistent with one another."""

import pytest

from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import CANDIDATES, LAWS, MODEL_LABELS, MODELS, Rules


@pytest.mark.parametrize("model", LAWS)
def test_a_law_is_made_of_known_parameters(model):
    law = LAWS[model]
    assert set(law.parameters) <= set(PARAMETERS) and set(law.free) <= set(law.may_free)
    assert all(set(LAWS[case].parameters) < set(law.parameters) for case in law.cases)
    if law.is_foundation:
        assert law.parameters[0] == "k"
        assert len(law.ratios) == 1 or law.cases  # a scan is of one damping
        for name in law.parameters:
            (low, high), (least, most, n) = PARAMETERS[name].bounds, PARAMETERS[name].grid
            assert low < least < most < high and n > 1


def test_candidates_are_the_laws_with_their_kinematics_and_width_from_few_numbers_to_many():
    assert list(MODELS) == list(CANDIDATES) == list(MODEL_LABELS)
    laws = [model for model in CANDIDATES if not CANDIDATES[model].is_rival]
    assert laws == sorted(LAWS, key=lambda model: len(LAWS[model].parameters))
    foundations = [name for name, law in LAWS.items() if law.is_foundation]
    rivals = {
        f"{name}{ending}" for name in foundations for ending in ("_pivoting", "_width", "_pivoting_width")
    }
    assert set(CANDIDATES) == {*LAWS, "housner_width", *rivals}
    added = [len(MODELS[model]) + CANDIDATES[model].width for model in CANDIDATES]
    assert added == sorted(added) and added[0] == 1
    assert MODELS["general_pivoting_width"] == ("k", "c", "lambda")
    assert MODEL_LABELS["hunt_crossley_pivoting_width"] == "Hunt–Crossley, pivoting, width free"
    assert MODEL_LABELS["housner_width"] == "Housner, width free"


def test_tensionless_rule_is_for_one_damping_at_a_time():
    general, tensionless = LAWS["general"], Rules("tensionless").debonding
    assert general.allows(tensionless, 1) and not general.allows(tensionless, 2)
    assert general.allows(Rules().debonding, 2) and LAWS["winkler"].allows(tensionless, 1)
