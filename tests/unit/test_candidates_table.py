"""How often each candidate is named, and with what numbers."""

import numpy as np
import pytest
from evidence import NAMED, POSSIBLE, paper, scene

from freerock.columns import columns_of
from freerock.models.laws import CANDIDATES
from freerock.tables.candidates import candidates_table

RUNS = (
    paper() | {"hunt_crossley": NAMED},
    paper(housner_width=NAMED) | {"hunt_crossley": POSSIBLE},
    paper() | {"winkler": NAMED},
)


def test_counts_and_medians():
    choice, parameters = scene(*RUNS)
    rows = np.flatnonzero((parameters["model"] == "hunt_crossley") & (parameters["parameter"] == "k"))
    parameters.loc[rows, "value"] = [6e6, 8e6, 1e9]  # of the third run it is rejected
    choice.loc[choice["status"] == "not_fitted", "epsilon_theta"] = 0.5  # that of a quick fit
    table = candidates_table(choice, parameters)
    assert list(table) == columns_of("candidates")
    assert not (table["epsilon_theta"] == 0.5).any()
    assert table["model"].tolist() == list(CANDIDATES)
    row = table.set_index("model").loc["hunt_crossley"]
    assert row[["n_runs", "n_selected", "n_also_possible", "n_rejected", "n_explains"]].tolist() == [
        3,
        1,
        1,
        1,
        2,
    ]
    assert (row["k_n_m2"], row["lambda_n_s_m3"], row["epsilon_theta"]) == (7e6, 1.3e8, 1e-5)
    worn = table.set_index("model").loc["housner_width"]
    assert (worn["n_selected"], worn["n_not_fitted"], worn["contact_width_m"]) == (1, 2, 0.063)
    assert np.isnan(table.set_index("model").loc["housner", "r"])
    assert (table[["n_selected", "n_also_possible", "n_rejected", "n_not_fitted"]].sum(axis=1) == 3).all()


def test_medians_are_of_fits_that_may_be_used_unless_none_may():
    choice, parameters = scene(*RUNS)
    winkler = choice["model"] == "winkler"
    choice.loc[winkler, "epsilon_theta"] = choice.loc[winkler, "epsilon_holdout"] = [0.1, 0.2, 0.9]
    failed = (parameters["model"] == "winkler") & (parameters["run"] == 3)
    parameters.loc[failed | (parameters["model"] == "housner"), "success"] = False
    table = candidates_table(choice, parameters).set_index("model")
    assert table.loc["winkler", ["epsilon_theta", "epsilon_holdout"]].tolist() == pytest.approx([0.15, 0.15])
    assert table.loc["housner", ["epsilon_theta", "epsilon_holdout"]].tolist() == [1e-5, 2e-5]
