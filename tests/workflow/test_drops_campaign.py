"""A few measured drops of the shipped campaign: bounced runs get the law of a block that bounces."""

import shutil

import numpy as np
import pytest
from golden_numbers import differences
from small_campaign import ROOT, check_out

from freerock_bench.drops import clean_falls, means

pytestmark = pytest.mark.slow
DROPS = ("drop_006", "drop_022", "drop_032", "drop_134", "drop_146", "drop_178", "drop_354", "drop_434")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    checkout = check_out(tmp_path_factory.mktemp("drops"))
    (checkout / "config/config.yaml").write_text("campaigns: [drops]\n")
    shutil.copy2(ROOT / "config/campaigns/drops.yaml", checkout / "config/campaigns")
    head, *lines = (ROOT / "config/campaigns/drops.csv").read_text(encoding="utf-8").splitlines(True)
    some = [line for line in lines if line.startswith(DROPS)]
    (checkout / "config/campaigns/drops.csv").write_text("".join([head, *some]), encoding="utf-8")
    shutil.copytree(ROOT / "raw/drops", checkout / "raw/drops")
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    return checkout / "results/drops"


def test_each_run_that_bounced_has_the_law(tables):
    reasons, parameters = tables["reasons"], tables["parameters"]
    bounced = {*reasons["test"][reasons["reason"] == "bounced"]}
    assert len(bounced) >= 5
    own = parameters[parameters["model"] == "bouncing"]
    assert bounced <= {*own["test"]} and {"e", "mu", "theta0"} <= {*own["parameter"]}
    assert bounced <= {*tables["choice"].query("model == 'bouncing'")["test"]}
    thrown = {*reasons["test"][reasons["reason"] == "thrown"]} & bounced
    assert thrown and {*own["test"][own["parameter"] == "omega0"]} == thrown
    others = parameters[parameters["model"] != "bouncing"]
    assert not {*others["test"]} & thrown  # no release from rest begins so


def test_no_rejected_law_is_ok(tables):
    choice, runs = tables["choice"], tables["runs"].set_index("test")
    for test in choice["test"][(choice["status"] == "selected") & ~choice["explains"].astype(bool)]:
        assert runs.loc[test, "verdict"] != "ok"
    assert "unexplained" in set(tables["reasons"]["reason"])


def test_what_the_drops_tell(results):
    falls = clean_falls(results)
    assert len(falls) >= 4 and falls["is_run"].all()
    found = means(results).set_index("parameter")
    assert 0.3 < found.loc["e", "mean"] < 0.6 and 0.1 < found.loc["mu", "mean"] < 0.8
    assert np.isfinite(found.loc["e", "half95"])


def test_each_number_is_as_kept(results):
    assert differences(results, "drops") == []
