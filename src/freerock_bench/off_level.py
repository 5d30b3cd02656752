"""A base off level by up to half a degree: is its tilt found, and are k and λ still right?

Records of the virtual laboratory as in `mishaps`, of the three blocks on both foundations in turn,
whose base is off level, but for one of four rounds. Fitted is the law of the truth, with what of base and
release the data ask for.

    python -m freerock_bench.off_level results/studies/off_level.csv full
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.selection.hypotheses import BY_DEFAULT
from freerock.tables.csvfile import write_csv
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench import moves
from freerock_bench.analysed import analysed
from freerock_bench.mishaps import SCATTER, spoiled
from freerock_bench.truths import place
from freerock_bench.virtual_run import Row

SIZES = {"small": 8, "full": 240}  # six make a round
MOST_DEG = 0.5
LADDER = replace(BY_DEFAULT, models=("hunt_crossley",), kinematics=())
NAMES = ("k", "lambda", "tilt")
COLUMNS = ["block", "foundation", "theta0_deg", "tilt_deg", "level", "scene", "explained"]
COLUMNS += ["tilt_found_deg", "tilt_stderr_deg", *(f"{name}_error_stderrs" for name in NAMES)]


def run(size: str = "full", first: int = 0) -> pd.DataFrame:
    """Records by number, from the first.

    Returns
    -------
    pandas.DataFrame
        A row per record: block, foundation, theta0_deg, tilt_deg; level of the verdict; scene (what was not
        taken for granted, joined by blanks), explained; tilt_found_deg and its standard error, NaN where none
        was freed; errors of k, λ and tilt in standard errors.
    """
    return pd.DataFrame([one(i) for i in range(first, first + SIZES[size])], columns=COLUMNS)


def one(i: int) -> Row:
    """The i-th record."""
    configuration, foundation = place(i)
    block, angle, laser = CONFIGURATIONS[configuration]
    draw = np.random.default_rng([17, i])
    truth = {name: x * (1 + draw.uniform(-SCATTER, SCATTER)) for name, x in FOUNDATIONS[foundation].items()}
    angle *= draw.choice([-1, 1]) * draw.uniform(0.6, 1.0)
    tilt = math.radians(draw.uniform(-MOST_DEG, MOST_DEG)) if i // 6 % 4 else 0.0
    how = {"moves": moves.off_level(tilt)} if tilt else {}
    record = spoiled(block, laser, truth, angle, how, i)
    verdict, found, _ = analysed(record.time_s, record.volts, laser, block, LADDER)
    row: Row = {
        "block": configuration,
        "foundation": foundation,
        "theta0_deg": math.degrees(angle),
        "tilt_deg": math.degrees(tilt),
        "level": verdict.level,
        "scene": " ".join(found.widened),
        "explained": found.explained,
    }
    fit = found.fits.get("hunt_crossley")
    for name, value in {**truth, "tilt": tilt}.items():
        if fit and name in fit.parameters:
            at = fit.parameters.index(name)
            row[f"{name}_error_stderrs"] = (fit.value[at] - value) / fit.stderr[at]
    if fit and "tilt" in fit.parameters:
        at = fit.parameters.index("tilt")
        row["tilt_found_deg"] = math.degrees(fit.value[at])
        row["tilt_stderr_deg"] = math.degrees(fit.stderr[at])
    return row


def main(product: str, size: str = "full") -> None:
    """Measure, and write the product."""
    write_csv(run(size), Path(product))


if __name__ == "__main__":
    main(*sys.argv[1:])
