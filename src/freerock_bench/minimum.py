"""Is the paper's own fit the least that its law can have?

Of each record of Palermo the first run and the laws of the paper: the printed ε_θ against the least that
lmfit's Nelder–Mead finds from 50 random starts, with the same limits of the release. A case is a record. Of
all its runs stand the printed ε_θ, Housner's r and the duration, whose medians the report prints.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import lmfit
import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.config.fit_settings import FitSettings
from freerock.identification.paper_fit import RELEASE_WALLS, paper_fit
from freerock.identification.posed import release_prior
from freerock.identification.run_model import Point, RunModel
from freerock.models.block import Block
from freerock.models.free_parameters import PARAMETERS
from freerock.models.laws import LAWS
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.selection.loaded_record import load
from freerock.virtual_lab.published import BLOCKS, TABLE_2
from freerock_bench.campaigns import COLUMNS, ROOT, Row
from freerock_bench.document import in_markdown
from freerock_bench.scattered import BEAMS_M

SEED, STARTS, SAMPLES, EVALUATIONS = 50, 50, 500, 150
WITHIN = 0.01  # of the least
PAPER = ("housner", "winkler", "hunt_crossley")


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table: of ε_θ truth is the least found, value the printed one; numbers of the printed fit."""
    rows, draw = list[Row](), np.random.default_rng(SEED)
    few = 1 if size == "small" else None
    for block, foundation in [(block, each) for block in BLOCKS for each in TABLE_2][:few]:
        of, file = {"case": f"{block} on {foundation}"}, f"raw/palermo_virtual/{block}_{foundation}.tdms"
        runs = load(ROOT / file, BLOCKS[block], Laser("horizontal", BEAMS_M[block], 0.1)).runs[:few]
        motions = [run.motion for run in runs]
        rows += _of_runs(of, "duration", [motion.time_s[-1] for motion in motions])
        for law in PAPER[:few]:
            fits = [paper_fit(law, BLOCKS[block], motion) for motion in motions]
            rows += _of_runs(of, f"printed ε_θ of {law}", [fit.epsilon_theta for fit in fits])
            if law == "housner":
                rows += _of_runs(of, "printed r", [fit.values["r"] for fit in fits])
            printed = fits[0]
            least, at = _least(law, BLOCKS[block], motions[0], draw)
            inside = printed.epsilon_theta <= (1 + WITHIN) * least
            found: Row = {"truth": least, "value": printed.epsilon_theta, "inside": inside}
            found["scene"] = " ".join(f"{name} {value:.4g}" for name, value in at.items())
            rows.append(of | {"parameter": f"ε_θ of {law}"} | found)
            for name, value in printed.values.items():
                rows.append(of | {"parameter": f"{name} of {law}", "value": value})
    return pd.DataFrame(rows, columns=COLUMNS)


def _of_runs(of: Row, parameter: str, values: Sequence[float]) -> list[Row]:
    """A row for each run of a record."""
    return [of | {"parameter": parameter, "value": each, "run": i} for i, each in enumerate(values, 1)]


def _least(
    law: str, block: Block, motion: Motion, draw: np.random.Generator
) -> tuple[float, dict[str, float]]:
    """Least ε_θ of a law and its numbers, by Nelder and Mead's simplex from many starts."""
    model = RunModel(law, block, motion, FitSettings(), moves_inputs=False)
    few, names = model.until(np.inf, SAMPLES), LAWS[law].parameters
    ranges = [PARAMETERS[name].grid[:2] for name in names]

    def values(moved: lmfit.Parameters) -> dict[str, float]:
        found = {name: math.exp(moved[f"ln_{name}"].value) for name in names}
        if "r" in found:
            found["r"] = 1 - found["r"]
        else:
            found = {name: each if name == "k" else each * found["k"] for name, each in found.items()}
        return found | {name: moved[name].value for name in ("theta0", "t0")}

    def misfit(moved: lmfit.Parameters, samples: tuple[Floats, Floats] = (few.time_s, few.theta)) -> float:
        at = Point(values(moved), np.zeros(0), np.zeros(0))
        error = model.curve(at, samples[0], 1e-6) - samples[1]
        return float(np.nan_to_num(error @ error / (samples[1] @ samples[1]), nan=1e3))

    ends = list[lmfit.Parameters]()
    for _ in range(STARTS):
        start = lmfit.Parameters()
        for name, (low, high) in zip(names, ranges, strict=True):
            ends_at = math.log(low), math.log(high)
            start.add(f"ln_{name}", draw.uniform(*ends_at), min=ends_at[0] - 2, max=ends_at[1] + 2)
        if "r" in names:
            start["ln_r"].max = math.log(1 - 1e-3)
        for name, (centre, u) in release_prior(model).items():
            near = RELEASE_WALLS * u
            start.add(name, centre + draw.uniform(-near, near), min=centre - near, max=centre + near)
        ends.append(lmfit.minimize(misfit, start, "nelder", options={"maxfev": EVALUATIONS}).params)
    longer, best = {"maxfev": 4 * EVALUATIONS}, sorted(ends, key=misfit)[:3]
    best = [lmfit.minimize(misfit, each, "nelder", options=longer).params for each in best]
    whole = model.whole.time_s, model.whole.theta
    end = min(best, key=lambda each: misfit(each, whole))
    return misfit(end, whole), values(end)


def markdown(frame: pd.DataFrame) -> str:
    """A row per record, a column per law: printed, and the least found."""
    rows, frame = [], frame[frame["parameter"].str.startswith("ε_θ")]
    for case, own in frame.groupby("case", sort=False):
        rows.append(
            [case, *(f"{100 * row.value:.4g} %, {100 * row.truth:.4g} %" for row in own.itertuples())]
        )
    laws = frame["parameter"].str.removeprefix("ε_θ of ").unique()
    return in_markdown(["ε_θ printed, least", *laws], rows)
