"""Does r by energy ± u hold where the block moves as no law says?

The beds of `studies.discrepancy`, whose integrations know the energy of each top. Fitted is Hunt and
Crossley's law; its restitution by energy is held against √(E after / E before) of the motion, with the
standard error of the noise alone and with what the law does not explain.

    python -m freerock_bench.energies results/studies/energies.csv full docs/validation.md

measures (`small`: a run of each kind; `full`: twelve, in four minutes of processor time) and renews the table
in the documentation, where it is named.
"""

import sys

import numpy as np
import pandas as pd

from freerock.identification.fit import fit_run
from freerock.identification.levels import NORMAL_95
from freerock.populations.impact_energy import impact_energy
from freerock.runs.impacts import find_impacts
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.discrepancy import KINDS, LASTS_S, SIGMA, STILL_S, scattered
from freerock_bench.document import publish
from freerock_bench.imperfect import tops_on_bed
from freerock_bench.truths import ANGLES, place
from freerock_bench.virtual_run import RATE_HZ, SEED, Row, Truth, rows_of_all, virtual_motion

SIZES = {"small": 1, "full": 12}  # runs of each kind; six make a round of blocks and foundations
FIRST = 6  # the way that r follows from the parts was chosen on runs before
LAW = "hunt_crossley"
LOWEST = 20 * SIGMA  # tops that count
OTHERS = ("turns out of the plane, 0.6 %", "slips, μ = 0.2")  # whose integration knows no energies
BEDS = [name for name, kind in KINDS.items() if kind.restitution is None and name not in OTHERS]
COLUMNS = ["kind", "half", "run", "block", "foundation", "explained", "impact", "true_r"]
COLUMNS += ["error", "stderr", "u", "inside_stderr", "inside"]
MARK = ("<!-- energies -->\n\n", "\n\n<!-- end of the energies -->")


def run(size: str = "full") -> pd.DataFrame:
    """Every kind on blocks and foundations in turn.

    Parameters
    ----------
    size : str
        "full", or "small" for a run of each kind.

    Returns
    -------
    pandas.DataFrame
        A row per impact whose tops are higher than 20 σ: kind, half, run, block, foundation; explained (the
        law leaves only noise); impact, from 1; true_r; error of r by energy, its standard error and total
        uncertainty, of noise and law; inside_stderr and inside: the 95 % interval of either holds the truth.
    """
    cases = [(name, i) for i in range(FIRST, FIRST + SIZES[size]) for name in BEDS]
    return pd.DataFrame(rows_of_all(rows_of, cases), columns=COLUMNS)


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one run; none where the law's fit may not be used."""
    name, i = case
    kind, (configuration, foundation) = KINDS[name], place(i)
    block, angle, _ = CONFIGURATIONS[configuration]
    generator = np.random.default_rng([SEED, list(KINDS).index(name), i])
    theta0 = angle * generator.uniform(*ANGLES) * generator.choice([-1, 1])
    time_s, soil = np.arange(0.0, LASTS_S, 1 / RATE_HZ), scattered(FOUNDATIONS[foundation], generator)
    differs = kind.differs(block, soil["k"], abs(theta0))
    theta, impacts, heights, energies = tops_on_bed(block, soil, theta0, time_s, **differs)
    motion = virtual_motion(Truth(LAW, block, soil, theta0, SIGMA), generator, (time_s, theta), STILL_S)
    assert motion is not None  # given, not simulated
    fit = fit_run(LAW, block, motion)
    if not fit.success:
        return []
    high = int(np.argmax(np.append(heights, 0.0) < LOWEST)) - 1
    start = fit.values["theta0"]
    seen = find_impacts(fit.time, fit.theta_model, 0.0, block, theta0=start).time_s[:high]
    found = impact_energy(fit, block, seen)
    nearest = np.argmin(np.abs(impacts[:, None] - seen), axis=0)
    true = np.sqrt(energies[nearest + 1] / energies[nearest])
    error = found.restitution - true
    frame = pd.DataFrame(
        {
            "kind": name,
            "half": kind.half,
            "run": i + 1,
            "block": configuration,
            "foundation": foundation,
            "explained": not np.any(fit.discrepancy > 0),
            "impact": np.arange(1, len(seen) + 1),
            "true_r": true,
            "error": error,
            "stderr": found.stderr,
            "u": found.u_total,
            "inside_stderr": np.abs(error) <= NORMAL_95 * found.stderr,
            "inside": np.abs(error) <= NORMAL_95 * found.u_total,
        }
    )
    rows: list[Row] = frame.dropna().to_dict("records")
    return rows


def markdown(frame: pd.DataFrame) -> str:
    """A row per kind: how many runs and impacts, typical error and width, coverage before and after."""
    lines = [
        "| motion | runs | explained | impacts | error of r | stderr | u "
        "| inside ± 1.96 stderr | inside ± 1.96 u |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, own in frame.groupby("kind", sort=False):
        runs = own.drop_duplicates("run")
        medians = [f"{own[key].abs().median():.2g}" for key in ("error", "stderr", "u")]
        shares = [f"{100 * own[key].mean():.0f} %" for key in ("inside_stderr", "inside")]
        cells = [name, len(runs), f"{100 * runs['explained'].mean():.0f} %", len(own), *medians, *shares]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    for explained, which in ((False, "runs that the law does not explain"), (True, "runs that it explains")):
        own = frame[frame["explained"].astype(bool) == explained]
        means = own.groupby("kind")[["inside_stderr", "inside"]].mean().mean()
        n = len(own.drop_duplicates(["kind", "run"]))
        shares = [f"{100 * means[key]:.0f} %" for key in ("inside_stderr", "inside")]
        cells = [f"**{which}, mean of the kinds**", n, "", len(own), "", "", "", *shares]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def main(product: str, size: str, document: str = "") -> None:
    """Measure, write the product, and renew the table of a document."""
    publish(run(size), product, document, MARK, markdown)


if __name__ == "__main__":
    main(*sys.argv[1:])
