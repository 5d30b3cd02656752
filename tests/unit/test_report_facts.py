"""Numbers of the report's sentences."""

import math

import pandas as pd

from freerock.models.block import Block
from freerock.report.facts import counts, facts


def test_a_restitution_exceeds_another_where_both_uncertainties_are_known():
    rows = [(0.97, 0.94, 0.01, 0.01), (0.96, 0.94, 0.01, 0.01), (0.97, 0.94, math.nan, 0.01)]
    compared = pd.DataFrame(rows, columns=["r_fitted", "r_first", "r_fitted_u", "r_first_u"])
    runs = pd.DataFrame({"block": ["b1"], "theta0_deg": [10.0]})
    known = facts(runs, [], compared.assign(first_impact_s=0.3, rigid_s=0.2), {"b1": Block(0.28, 0.07, 5.8)})
    assert (known["n_above"], known["n_fitted"]) == (1, 2)  # by 2.1 and 1.4 of them, one unknown
    assert known["shift_mm"] == "0.53"  # 35 (1 - cos 10°)


def test_a_run_that_failed_is_no_record_that_could_not_be_processed():
    runs = pd.DataFrame({"test": ["a", "a", "b"], "run": ["1", "2", None], "verdict": ["fail", "ok", "fail"]})
    told = "2 records with 2 free-rocking runs; verdicts: 2 fail, 1 ok. 1 record could not be processed."
    assert counts(runs) == told
