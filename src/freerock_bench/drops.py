"""Measured drops of a square: which law foretells the next peak after a fall from a corner onto the face?

    python -m freerock_bench.drops results/studies/drops.csv
    python -m freerock_bench.drops results/drops      # what the campaign found: `clean_falls`, `means`

Both read the products of the campaign. Of the last run of a record that begins above `LEAST_DEG`, the
motion before the impact gives the state in which the corner comes down. A third of the falls chooses the
parameters of each law, by the mean of the absolute errors. The others are foretold by the law `bouncing`
(e, μ), Housner's (r), Hunt and Crossley's on a pivoting block (k, λ), and by the mean of the third. A peak is
positive on the side of the corner it fell from.
"""

import math
import sys
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.optimize import least_squares

from freerock.arrays import Floats, Mask
from freerock.config.campaign import load_campaign
from freerock.errors import FreerockError, exit_code
from freerock.jobs.make_record import POSITIONS
from freerock.models.block import Block
from freerock.models.bouncing import RIGHT, bounce, standing_on
from freerock.models.contact import State
from freerock.models.housner import housner_swings
from freerock.models.laws import Rules
from freerock.models.simulate import Solver, simulate
from freerock.products.groups import runs_of
from freerock.products.netcdf import open_record
from freerock.runs.begun_in_motion import lifted
from freerock.tables.csvfile import write_csv

CAMPAIGN, RESULTS = Path("config/campaigns/drops.yaml"), Path("results/drops")
LEAST_DEG, BEFORE, STANDS = 12.0, 6, 8  # of the start; samples of the state, on the corner, before it
FIRST_DEG = 0.25  # a turn of less is none
AFTER_S = 0.25
ENDS, STAYS_M = 10, 3e-3  # samples at rest; a tenth of the half width
RESAMPLES, SEED = 400, 43
E_GRID, MU_GRID = np.arange(0.1, 0.71, 0.05), (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 1.0, 3.0)
R_GRID = np.arange(0.0, 1.0, 0.02)
K_GRID, LAMBDA_GRID = np.geomspace(1e4, 1e8, 9), (0.1, 1.0, 5.0, 20.0, 100.0)  # N/m²; ratios to k [s/m]


class Fall(NamedTuple):
    """A fall: angle [rad] and rate [rad/s] some samples before the impact, and the next peak [rad]."""

    theta: float
    rate: float
    peak: float


def falls(block: Block, folder: Path = RESULTS) -> list[Fall]:
    """The falls from a corner in the last runs of the campaign's records."""
    found = []
    for path in sorted((folder / "records").glob("*.nc")):
        record = open_record(path)
        if runs := runs_of(record):  # none of a record that is excluded or failed
            found += _fall(record.dataset, runs[max(runs)].dataset, block)
    if not found:
        raise FreerockError(folder, "has no falls", "run `snakemake --config campaigns=drops` first")
    return found


def _fall(record: xr.Dataset, run: xr.Dataset, block: Block) -> list[Fall]:
    """The fall of a run, none of one that begins too low or near its first impact."""
    during = slice(*np.searchsorted(record["time"], (run["fit_start"], run["end"])))
    time, theta = record["time"].values[during], record["theta"].values[during]
    theta = theta * math.copysign(1.0, theta[0])
    turns_back = (theta[:-1] < math.radians(4)) & (np.diff(theta) > 0)
    down = np.flatnonzero(turns_back | (theta[:-1] <= 0))
    if not down.size or down[0] < STANDS or theta[0] < math.radians(LEAST_DEG):
        return []
    before = slice(int(down[0]) - BEFORE, int(down[0]))
    start = _state(time[before] - time[before][0], theta[before], block)
    return [Fall(*start, first_peak(theta[int(down[0]) :]))]


def _state(time: Floats, theta: Floats, block: Block) -> tuple[float, float]:
    """Angle and rate at the first of some samples of a block that turns about its corner."""

    def left(x: Floats) -> Floats:
        found = bounce(block, 0.0, 50.0, standing_on(block, RIGHT, x[0], x[1]), time)
        return np.asarray(found.theta - theta)

    rate = (theta[-1] - theta[0]) / time[-1]
    found = least_squares(left, [theta[0], rate], x_scale=[0.01, 1.0]).x
    return float(found[0]), float(found[1])


def first_peak(theta: Floats) -> float:
    """The first extremum after an impact: on the same side, or the lowest point where it rocks over."""
    turn = math.radians(FIRST_DEG)
    low = high = float(theta[0])
    for value in theta.tolist():
        low, high = min(low, value), max(high, value)
        if low < -turn and value > low + turn:
            return float(low)
        if low > -turn and value < high - turn and high > low + turn and high > turn:
            return float(high)
        if value <= low:
            high = value
    return float(low if abs(low) > abs(high) else high)


def by_bouncing(block: Block, fall: Fall, e: float, mu: float) -> float:
    """Next peak [rad] of a block that bounces."""
    time = np.linspace(0, AFTER_S, 1001)
    found = bounce(block, e, mu, standing_on(block, RIGHT, fall.theta, fall.rate), time)
    if not found.impact_time_s.size:
        return math.nan
    return first_peak(found.theta[np.searchsorted(time, found.impact_time_s[0]) :])


def by_housner(block: Block, fall: Fall, r: float) -> float:
    """Next peak [rad] of Housner's block: over the other corner."""
    swings = housner_swings(block, r, fall.theta, fall.rate, until=1.0, max_impacts=3)
    return -float(swings.peak[1]) if swings.peak.size > 1 else 0.0


def by_hunt_crossley(block: Block, fall: Fall, k: float, ratio: float) -> float:
    """Next peak [rad] on a bed of Hunt and Crossley."""
    time = np.linspace(0, AFTER_S, 501)
    rest = simulate("hunt_crossley", block, {"k": k, "lambda": ratio * k}, [0.0], theta0=fall.theta).z_cb[0]
    start = State(float(rest), -block.b * math.cos(fall.theta) * fall.rate, fall.theta, fall.rate)
    rules, solver = Rules("geometric", "pivoting"), Solver(1e-6)
    parameters = {"k": k, "lambda": ratio * k}
    found = simulate("hunt_crossley", block, parameters, time, theta0=start, rules=rules, solver=solver).theta
    down = np.flatnonzero(found < math.radians(2))
    return first_peak(found[down[0] :]) if down.size and np.isfinite(found).all() else math.nan


Law = Callable[..., float]
LAWS: dict[str, tuple[Law, list[tuple[float, ...]]]] = {
    "bouncing": (by_bouncing, [*product(E_GRID.tolist(), MU_GRID)]),
    "housner": (by_housner, [(r,) for r in R_GRID.tolist()]),
    "hunt_crossley": (by_hunt_crossley, [*product(K_GRID.tolist(), LAMBDA_GRID)]),
}


def run(size: str = "full") -> pd.DataFrame:
    """How well each law foretells, and its parameters.

    Columns law, n_chosen, n_foretold, parameters, and of the others mean_abs_deg, median_abs_deg, rms_deg.
    """
    block = load_campaign(CAMPAIGN).blocks["square"].block
    found = falls(block)[:: 1 if size == "full" else 4]
    third = np.arange(len(found)) % 3 == 0
    peak = np.array([each.peak for each in found])
    rows = [_row("mean", [()], np.full((1, len(found)), peak[third].mean()), peak, third)]
    for law, (foretells, grid) in LAWS.items():
        every = np.array([[foretells(block, each, *numbers) for each in found] for numbers in grid])
        rows.append(_row(law, grid, every, peak, third))
    return pd.DataFrame(rows)


def _row(
    law: str, grid: Sequence[tuple[float, ...]], every: Floats, peak: Floats, third: Mask
) -> dict[str, object]:
    """What a law foretells with the parameters of least mean absolute error on the third."""
    off = np.abs(np.nan_to_num(every, nan=0.0) - peak)
    best = int(np.argmin(off[:, third].mean(axis=1)))
    others = np.degrees(off[best][~third])
    return {
        "law": law,
        "n_chosen": int(third.sum()),
        "n_foretold": int((~third).sum()),
        "parameters": " ".join(f"{x:.4g}" for x in grid[best]),
        "mean_abs_deg": others.mean(),
        "median_abs_deg": np.median(others),
        "rms_deg": np.sqrt(np.mean(others**2)),
    }


def clean_falls(folder: Path) -> pd.DataFrame:
    """Falls of the campaign's records from a corner that neither slides nor lifts by more than `STAYS_M`.

    Columns test, from_deg (where the fall begins), back_deg (highest point on that side after the impact),
    is_run (neither failed nor excluded), bounced (so its verdict says).
    """
    runs, reasons = (pd.read_csv(folder / f"tables/{name}.csv") for name in ("runs", "reasons"))
    usable = {*runs["test"][(runs["verdict"] != "fail") & ~runs["excluded"].astype(bool)]}
    bounced, block = {*reasons["test"][reasons["reason"] == "bounced"]}, load_campaign(CAMPAIGN).blocks
    rows = [
        (path.stem, *fall, path.stem in usable, path.stem in bounced)
        for path in sorted((folder / "records").glob("*.nc"))
        if (fall := _clean_fall(open_record(path).dataset, block["square"].block))
    ]
    return pd.DataFrame(rows, columns=["test", "from_deg", "back_deg", "is_run", "bounced"])


def _clean_fall(record: xr.Dataset, block: Block) -> tuple[float, float] | None:
    """Where the last fall of a record begins, and the highest point on its side after it [°]."""
    if "position_x" not in record:
        return None
    theta, x, z = (record[name].values for name in ("theta", *POSITIONS))
    high = np.flatnonzero(np.abs(theta) >= math.radians(LEAST_DEG))
    if not high.size or not np.abs(theta[-ENDS:]).max() < math.radians(1):
        return None
    up = theta * math.copysign(1.0, theta[high[-1]])
    first = last = int(high[-1])
    while first and up[first] < up[first - 1] < block.theta_cr:
        first -= 1
    while last + 1 < len(up) and 0 < up[last + 1] < up[last]:
        last += 1
    side, fall = math.copysign(1.0, theta[last]), slice(first, last + 1)
    corner = (x + side * block.b * np.cos(theta) - block.h * np.sin(theta))[fall]
    lifts = lifted(theta, z, float(np.median(z[-ENDS:])), block)[fall].max()
    if last - first < STANDS or np.ptp(corner) > STAYS_M or lifts > STAYS_M:
        return None
    return math.degrees(up[first]), math.degrees(up[last + 1 :].max())


def means(folder: Path, near: float = 0.01) -> pd.DataFrame:
    """e and μ over the runs whose fit of the law `bouncing` may be used and leaves ε_θ of at most `near`.

    Columns parameter, n, n_known (with an interval), mean, low, high (95 % over resampled runs), spread,
    half95 (median half of the intervals of the runs), all three of those with an interval.
    """
    epsilon, parameters = (pd.read_csv(folder / f"tables/{name}.csv") for name in ("epsilon", "parameters"))
    good = epsilon[(epsilon["model"] == "bouncing") & epsilon["success"] & (epsilon["epsilon_theta"] <= near)]
    own = parameters[parameters["model"] == "bouncing"].merge(good[["test", "run"]], on=["test", "run"])
    rows, draw = [], np.random.default_rng(SEED)
    for name in ("e", "mu"):
        of_name = own[own["parameter"] == name]
        known = of_name.dropna(subset="stderr")
        value = known["value"].to_numpy()
        again = value[draw.integers(len(value), size=(RESAMPLES, len(value)))].mean(axis=1)
        half = ((known["ci95_high"] - known["ci95_low"]) / 2).median()
        low, high = np.percentile(again, [2.5, 97.5])
        rows.append((name, len(of_name), len(known), value.mean(), low, high, value.std(ddof=1), half))
    return pd.DataFrame(
        rows, columns=["parameter", "n", "n_known", "mean", "low", "high", "spread", "half95"]
    )


def main(product: str, size: str = "full") -> None:
    """Print what the campaign found, from its folder; or write and print how well each law foretells."""
    if Path(product).is_dir():
        print(clean_falls(Path(product)).to_string(), means(Path(product)).to_string(), sep="\n")
        return
    table = run(size)
    write_csv(table, Path(product))
    print(table.to_string())


if __name__ == "__main__":
    sys.exit(exit_code(lambda: main(*sys.argv[1:])))
