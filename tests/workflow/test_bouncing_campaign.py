"""Cubes that bounce, seen by a laser from their fall on: from volts to the law that is named."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from golden_numbers import differences
from small_campaign import COLUMNS, add_campaign, check_out

from freerock.models.block import Block
from freerock.products.netcdf import open_fits
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record

pytestmark = pytest.mark.slow
CUBE, LASER = Block(0.1, 0.1, 2.5), Laser("horizontal", 0.07, 0.1)
U_M = 5e-5  # standard uncertainty of width and height
TRUTHS = {"slips": (0.35, 0.25), "sticks": (0.4, 5.0)}
CAMPAIGN = f"""\
title: Cubes that bounce
origin: simulated
blocks:
  cube: {{height_m: 0.1, width_m: 0.1, mass_kg: 2.5, uncertainty: {{width_m: {U_M}, height_m: {U_M}}}}}
foundations:
  floor: {{label: Floor}}
lasers:
  laser: {{beam: horizontal, position_m: 0.07, range_m: 0.1, units: V}}
processing: {{runs: {{start: motion, min_impacts: 0}}}}
records_per_job: 2
figures: [parameters, parts, pulls]
fits: {{models: [housner]}}
"""


def recorded(name, e, mu, seed):
    """A record whose block differs from the stated one by what its uncertainty says."""
    draw = np.random.default_rng(seed)
    width, height = np.array([CUBE.width_m, CUBE.height_m]) + draw.normal(0, U_M, 2)
    block = replace(CUBE, width_m=float(width), height_m=float(height))
    release = VirtualRelease(math.radians(25), {"e": e, "mu": mu}, tilt_s=1.2, held_s=1.5, pause_s=1.5)
    return simulate_record(block, LASER, "bouncing", [release], seed=seed, recording=Recording())


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    checkout = check_out(tmp_path_factory.mktemp("cubes"))
    records = {name: recorded(name, *truth, 5 + i) for i, (name, truth) in enumerate(TRUTHS.items())}
    add_campaign(checkout, "cubes", CAMPAIGN, [])
    lines = [f"{name},{name}.csv,volts,cube,floor,laser,,,,\n" for name in records]
    (checkout / "config/campaigns/cubes.csv").write_text(COLUMNS + "".join(lines))
    raw = checkout / "raw/cubes"
    raw.mkdir(parents=True, exist_ok=True)
    for name, record in records.items():
        falls = record.time_s > record.truth["runs"][0]["free_s"] + 0.03
        told = pd.DataFrame({"time": record.time_s, "volts": record.volts})[falls]
        told.to_csv(raw / f"{name}.csv", index=False)
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    return checkout / "results/cubes"


def test_the_law_is_named_with_its_parameters(tables):
    runs, choice, parameters = (tables[name] for name in ("runs", "choice", "parameters"))
    assert list(runs["verdict"]) == ["warn", "warn"] and runs["reasons"].str.contains("same side").all()
    named = choice[choice["status"] == "selected"]
    assert list(named["model"]) == ["bouncing"] * 2 and named["explains"].all(), choice.T
    assert not choice[choice["model"] == "housner"]["explains"].any()
    found = parameters[parameters["model"] == "bouncing"].set_index(["test", "parameter"])
    for name, (e, mu) in TRUTHS.items():
        row = found.loc[(name, "e")]
        assert abs(row["value"] - e) < 2.6 * row["u_total"] < 0.03
        row = found.loc[(name, "mu")]
        if name == "sticks":
            assert row["given"] == "undetermined" and np.isnan(row["stderr"])
        else:
            assert abs(row["value"] - mu) < 2.6 * row["u_total"]


def test_friction_that_makes_no_difference_is_said_to_be_undetermined(results):
    fit = open_fits(results / "fits/sticks.nc")["run_1/bouncing"]
    assert "the run does not determine μ" in fit.attrs["message"]
    assert "determine" not in open_fits(results / "fits/slips.nc")["run_1/bouncing"].attrs["message"]


def test_tables_and_report_have_the_law(results, tables):
    assert {"e", "mu"} <= {*tables["candidates"].columns}
    assert tables["epsilon"].query("model == 'bouncing'")["epsilon_theta"].max() < 1e-3
    report = (results / "report.html").read_text(encoding="utf-8")
    assert "corners bounce with restitution e" in report
    assert "moreau1988" in (results / "tables/methods.bib").read_text(encoding="utf-8")


def test_each_number_is_as_kept(results):
    assert differences(results, "bouncing") == []
