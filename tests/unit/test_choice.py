import math

import pytest

from freerock.identification.choice import choose_model, is_wanted


def found(bic=0.0, holdout=1e-3, noise=True, ratio=1.0, added=0.0, success=True):
    return {
        "success": success,
        "bic": bic,
        "epsilon_holdout": holdout,
        "noise": noise,
        "residual_over_sigma": ratio,
        "added_damping": added,
    }


LOUD = {"noise": False, "ratio": 3.0}


@pytest.mark.parametrize(
    "evidence, model, reason",
    [
        ({"housner": found(success=False)}, "", "every fit failed"),
        (
            {"housner": found(**LOUD), "winkler": found(bic=-5.0), "hunt_crossley": found(bic=-7.0)},
            "hunt_crossley",
            "the smallest law (2 parameters) whose residual is noise: as at rest, 1.00 σ",
        ),
        (
            {"housner": found(bic=-5.0), "hunt_crossley": found(bic=-9.0)},
            "housner",
            "the smallest law (1 parameter) whose residual is noise: as at rest, 1.00 σ",
        ),
        (
            {"hunt_crossley": found(bic=-5.0, added=4.0), "general": found(bic=-9.0)},
            "general",
            "the smallest law (3 parameters) whose residual is noise: as at rest, 1.00 σ",
        ),
        (
            {
                "housner": found(holdout=2e-3, bic=-9.0, **LOUD),
                "winkler": found(holdout=1e-3, bic=-5.0, **LOUD),
            },
            "winkler",
            "no residual is noise; held-out ε_θ = 0.1 %, the lowest",
        ),
        (
            {
                "winkler": found(holdout=1.05e-3, bic=-9.0, **LOUD),
                "hunt_crossley": found(holdout=1e-3, bic=-5.0, **LOUD),
            },
            "winkler",
            "no residual is noise; held-out ε_θ = 0.105 %, the lowest BIC of 2 within a tenth of the best",
        ),
        (
            {
                "winkler": found(holdout=math.nan, bic=-9.0, **LOUD),
                "housner": found(holdout=math.nan, **LOUD),
            },
            "winkler",
            "no residual is noise; the lowest BIC",
        ),
    ],
)
def test_the_chosen_model_and_why(evidence, model, reason):
    assert choose_model(evidence) == (model, reason)


def test_the_general_law_is_fitted_where_no_smaller_one_leaves_noise_only():
    assert not is_wanted("general", {"winkler": found(added=9.0), "hunt_crossley": found()})
    assert is_wanted("general", {"winkler": found(added=3.1), "hunt_crossley": found(**LOUD)})
    assert not is_wanted("general", {"housner": found(**LOUD), "winkler": found(added=9.0, success=False)})
