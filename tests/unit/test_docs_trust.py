"""docs/trust.md: what its tables say of k, λ and worn corners."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_workbook import fitted

from freerock.identification.fit import fit_run
from freerock.models.laws import MODEL_LABELS
from freerock.models.published import BLOCKS, RELEASE_ANGLES, TABLE_2, TABLE_3
from freerock.models.simulate import simulate
from freerock.runs.motion import Motion
from freerock_bench import workbook

TEXT = (Path(__file__).parents[2] / "docs/trust.md").read_text(encoding="utf-8")
NOISE = math.radians(0.0063)


def cells(first):
    """Cells of the row of a table that begins with a text."""
    (row,) = re.findall(rf"^\| {re.escape(first)} \| (.*) \|$", TEXT, re.M)
    return row.split(" | ")


def numbers(cell):
    return [float(number) for number in cell.split(" … ")]


@pytest.mark.parametrize(
    "model",
    ["hunt_crossley", "hunt_crossley_pivoting", "hunt_crossley_width", "hunt_crossley_pivoting_width"],
)
def test_k_of_the_wooden_blocks(model):
    """A1 and A3 have the ends of each range of k and λ."""
    found = [
        dict(zip(fit.parameters, fit.value, strict=True))
        for fit in (fitted("A1", model), fitted("A3", model))
    ]
    for name, cell in zip(("k", "lambda"), cells(MODEL_LABELS[model]), strict=False):
        ratios = sorted(each[name] / workbook.TABLE[name] for each in found)
        assert [round(ratio, 2) for ratio in ratios] == pytest.approx(
            2 * numbers(cell) if " … " not in cell else numbers(cell), abs=0.011
        )


@pytest.mark.parametrize(
    ("share", "r", "row"), [(0.91, 0.95, "worn to 91 %, 0.95"), (0.85, 0.90, "worn to 85 %, 0.90")]
)
def test_a_worn_rigid_block_looks_like_a_foundation(share, r, row):
    nominal, theta0, time = BLOCKS["config2"], RELEASE_ANGLES["config2"], np.arange(0, 8, 5e-4)
    worn = replace(nominal, contact_width_m=share * nominal.width_m)
    noise = NOISE * np.random.RandomState(1).standard_normal(time.size)
    theta = simulate("housner", worn, {"r": r}, time, theta0=theta0).theta + noise
    motion = Motion(time, theta, NOISE, theta0)
    fits = {name: fit_run(name, nominal, motion) for name in (*TABLE_3["marble"], "housner_width")}
    k, damping = fits["hunt_crossley"].value[:2]
    percent = [100 * fit.epsilon_theta for fit in fits.values()]
    stated = [float(cell) for cell in cells(row)]
    assert stated == pytest.approx([*percent[:3], k, damping, percent[3]], rel=0.05)


@pytest.mark.parametrize(("foundation", "row"), [("marble", "paper, marble"), ("aerstop", "paper, Aerstop")])
def test_values_of_the_paper(foundation, row):
    *stated, last = cells(row)
    values = [100 * epsilon for epsilon in TABLE_3[foundation].values()]
    values += TABLE_2[foundation]["hunt_crossley"].values()
    assert [float(cell) for cell in stated] == pytest.approx(values, rel=0.03)
    assert last == "not given"
