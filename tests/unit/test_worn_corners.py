"""A rigid block on worn corners, from its motion to the words of the report."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from freerock.identification.fit import fit_run
from freerock.models.block import Block
from freerock.products.netcdf import open_fits, write_fits
from freerock.report.scene_evidence import scenes_of
from freerock.runs.verdict import Verdict
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.choice import choose, evidence
from freerock.selection.hypotheses_tried import Identified
from freerock.selection.reasons_after_fits import reasons_of_fits
from freerock.tables.candidates import candidates_table
from freerock.tables.tidy_tables import choice_table, epsilon_table, parameters_table, runs_table
from freerock_bench.virtual_run import Truth, virtual_motion

NOMINAL = Block(0.28, 0.07, 5.84)
WORN = replace(NOMINAL, contact_width_m=0.91 * NOMINAL.width_m)
ATTRS = {"campaign": "c", "test": "worn", "block": "b", "foundation": "steel", "origin": "simulated"}
ATTRS |= {"verdict": "ok", "reasons": []}


@pytest.fixture(scope="module")
def motion():
    truth = Truth("housner", WORN, {"r": 0.93}, math.radians(8), math.radians(0.01))
    return virtual_motion(truth, np.random.default_rng(3))


def stored(folder, motion, models):
    fits = {model: fit_run(model, NOMINAL, motion) for model in models}
    choice = choose([evidence(fit) for fit in fits.values()])
    doubts = reasons_of_fits(Verdict(), NOMINAL, motion, Identified(fits), BY_DEFAULT)
    write_fits(folder / "worn.nc", {1: fits}, ATTRS, {1: choice}, {1: doubts})
    return open_fits(folder / "worn.nc")


def sentences(tree):
    choice = choice_table([tree])
    table = candidates_table(choice, parameters_table([tree]))
    (scene,) = scenes_of(choice, table, {"b": NOMINAL}, {})
    return scene["sentences"]


def record():
    """The record of the run, as far as the table runs reads it."""
    zero = {name: ((), 0.0) for name in ("release", "end", "theta0", "sigma_theta")}
    zero["n_impacts"] = ((), 0)
    zero["restitution"] = ("impact", np.empty(0))
    run = xr.Dataset(zero, attrs={"verdict": "ok", "reasons": "[]", "excluded": 0})
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=ATTRS), "run_1": run})


def test_worn_corners_are_named_with_their_width(motion, tmp_path):
    tree = stored(tmp_path, motion, ("housner", "housner_width", "hunt_crossley"))
    epsilon = epsilon_table([tree])
    assert epsilon[epsilon["selected"]]["model"].tolist() == ["housner_width"]
    told = sentences(tree)
    assert told[0].startswith("Housner, width free explains the run: ")
    numbers = re.fullmatch(
        r"So this is a rigid block whose edges are not where its width says, as worn corners make it: "
        r"r = (\S+), 2b = (\S+) m, 91 % of the block's\. These runs give no reason to quote k and λ .*",
        told[-1],
    )
    assert float(numbers[1]) == pytest.approx(0.93, abs=1e-3)
    assert float(numbers[2]) == pytest.approx(WORN.contact_width_m, abs=1e-4)
    assert runs_table([record()], [tree])["verdict"].tolist() == ["ok"]


def test_the_paper_alone_explains_nothing_and_says_so(motion, tmp_path):
    tree = stored(tmp_path, motion, ("housner", "winkler", "hunt_crossley"))
    assert sentences(tree)[0] == (
        "No candidate explains the run: each leaves more than the sensor shows at rest."
    )
    runs = runs_table([record()], [tree])
    assert runs["verdict"].tolist() == ["warn"]
    (reasons,) = runs["reasons"]
    assert reasons.startswith("no candidate explains the run")
