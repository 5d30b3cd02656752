"""A block on a bed that relaxes: from volts to the law that is named, where a campaign lists it alone."""

import math

import pandas as pd
import pytest
from golden_numbers import differences
from small_campaign import COLUMNS, add_campaign, check_out

from freerock.models.block import Block
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record

pytestmark = pytest.mark.slow
BLOCK, LASER = Block(0.28, 0.07, 5.84), Laser("horizontal", 0.2, 0.1)
TRUTH = {"k": 6.88e6, "c": 0.02 * 6.88e6, "tau": 0.03}
CAMPAIGN = """\
title: A block on a bed that relaxes
origin: simulated
blocks:
  tall: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}
foundations:
  mat: {label: Mat}
lasers:
  high: {beam: horizontal, position_m: 0.2, range_m: 0.1, units: V}
figures: [models, residuals, restitution, parameters, predictions]
fits: {models: [viscoelastic]}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    checkout = check_out(tmp_path_factory.mktemp("mat"))
    release = VirtualRelease(math.radians(8), TRUTH, tilt_s=1.2, held_s=1.5, fade_s=0.0, pause_s=1.5)
    record = simulate_record(BLOCK, LASER, "viscoelastic", [release], seed=3, recording=Recording())
    add_campaign(checkout, "mat", CAMPAIGN, [])
    (checkout / "config/campaigns/mat.csv").write_text(COLUMNS + "mat,mat.csv,volts,tall,mat,high,,,,\n")
    raw = checkout / "raw/mat"
    raw.mkdir(parents=True)
    pd.DataFrame({"time": record.time_s, "volts": record.volts}).to_csv(raw / "mat.csv", index=False)
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    return checkout / "results/mat"


def test_the_law_is_named_with_its_numbers(results):
    tables = {name: pd.read_csv(results / f"tables/{name}.csv") for name in ("choice", "parameters")}
    named = tables["choice"].query("status == 'selected'")
    assert list(named["model"].str.partition("_")[0]) == ["viscoelastic"] and named["explains"].all()
    assert tables["parameters"]["model"].str.startswith("viscoelastic").all()  # and its rivals
    found = tables["parameters"].merge(named[["test", "run", "model"]]).set_index("parameter")
    for name, truth in TRUTH.items():
        assert abs(found.loc[name, "value"] - truth) < 3 * found.loc[name, "u_total"] < 0.5 * truth


def test_tables_and_report_have_the_law(results):
    assert "tau_s" in pd.read_csv(results / "tables/candidates.csv").columns
    assert "relaxes in the time" in (results / "report.html").read_text(encoding="utf-8")
    assert "flugge1975" in (results / "tables/methods.bib").read_text(encoding="utf-8")


def test_each_number_is_as_kept(results):
    assert differences(results, "viscoelastic") == []
