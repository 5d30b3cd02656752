"""Is the paper's own fit the least that its law can have?

Of each record of Palermo the first run and the laws of the paper: the printed ε_θ against the least that
lmfit's Nelder–Mead finds from 50 random starts, with the same limits of the release. A case is a record. Of
all its runs stand the duration and the printed numbers, whose medians the report prints.
"""

import math
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
from freerock.models.laws import LAWS, PAPER_MODELS
from freerock.rotation.sensor import Laser
from freerock.runs.motion import Motion
from freerock.selection.loaded_record import load
from freerock.virtual_lab.published import BLOCKS, TABLE_2
from freerock_bench.campaigns import COLUMNS, ROOT, Row
from freerock_bench.document import in_markdown
from freerock_bench.scattered import BEAMS_M

Numbers = dict[str, float]
SEED, STARTS, SAMPLES, EVALUATIONS = 50, 50, 500, 150
WITHIN = 0.01  # of the least


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """The long table: of ε_θ truth is the least found, value the printed one; numbers of the printed fit."""
    rows, draw = list[Row](), np.random.default_rng(SEED)
    few = 1 if size == "small" else None
    for block, foundation in [(block, each) for block in BLOCKS for each in TABLE_2][:few]:
        of, file = {"case": f"{block} on {foundation}"}, f"raw/palermo_virtual/{block}_{foundation}.tdms"
        runs = load(ROOT / file, BLOCKS[block], Laser("horizontal", BEAMS_M[block], 0.1)).runs[:few]
        for law in PAPER_MODELS[:few]:
            least, at = _least(law, BLOCKS[block], runs[0].motion, draw)
            for i, motion in enumerate((each.motion for each in runs), 1):
                fit = paper_fit(law, BLOCKS[block], motion)
                found = {**fit.values, "duration": motion.time_s[-1], "printed ε_θ": fit.epsilon_theta}
                for name, each in found.items():
                    rows.append(of | {"parameter": f"{name} of {law}", "value": each, "run": i})
                if i == 1:
                    row = of | {"parameter": f"ε_θ of {law}", "value": fit.epsilon_theta, "truth": least}
                    row["inside"] = fit.epsilon_theta <= (1 + WITHIN) * least
                    rows.append(row | {"scene": " ".join(f"{name} {each:.4g}" for name, each in at.items())})
    return pd.DataFrame(rows, columns=COLUMNS)


def _least(law: str, block: Block, motion: Motion, draw: np.random.Generator) -> tuple[float, Numbers]:
    """Least ε_θ of a law and its numbers, by Nelder and Mead's simplex from many starts."""
    model = RunModel(law, block, motion, FitSettings(), moves_inputs=False)
    few, names = model.until(np.inf, SAMPLES), LAWS[law].parameters

    def values(moved: lmfit.Parameters) -> Numbers:
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
        for name in names:
            low, high = np.log(PARAMETERS[name].grid[:2])
            start.add(f"ln_{name}", draw.uniform(low, high), min=low - 2, max=high + 2)
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
