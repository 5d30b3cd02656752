"""Do k ± u, λ ± u and r ± u hold where the block moves as no law says?

Motions by integrations of their own (`studies.imperfect`), each unlike every law in one way, with the noise
of a laser. The answer of the law with its rivals is held against the truth, with the standard error of the
noise alone and with the discrepancy of the law. How the parts of a run weigh was chosen on one half of the
kinds, and is shown on the other.

    python -m freerock_bench.discrepancy results/studies/discrepancy.csv full docs/validation.md

measures on all cores (`small`: a run of each kind in a minute; `full`: twenty, in twelve minutes of processor
time) and renews the table in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.levels import NORMAL_95
from freerock.models.block import GRAVITY, Block
from freerock.models.laws import LAWS
from freerock.selection.hypotheses import Hypotheses
from freerock.selection.hypothesis_search import identify_run
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.document import publish
from freerock_bench.imperfect import on_bed, rigid
from freerock_bench.truths import ANGLES, place
from freerock_bench.virtual_run import RATE_HZ, SEED, Row, Truth, rows_of_all, virtual_motion

SIZES = {"small": 1, "full": 20}  # runs of each kind; six make a round of blocks and foundations
SIGMA = math.radians(0.006)
STILL_S = (1.5, 1.5)
SCATTER = 0.03
R = (0.93, 0.97)
LEAST = 0.1  # of the height of the first swing: the true r is the mean over impacts of higher ones
LASTS_S = 6.0
MARK = ("<!-- discrepancy -->\n\n", "\n\n<!-- end of the discrepancy -->")
Differs = Callable[[Block, float, float], dict[str, Any]]  # of block, k and release angle: of `on_bed`


@dataclass(frozen=True)
class Kind:
    """What no law says of a motion.

    Parameters
    ----------
    half : str
        "set" where the method was chosen on it, "shown" where not, "law" of the law itself.
    differs : callable
        (block, k [N/m²], θ₀ [rad]) → arguments of `on_bed`; of a rigid block those of `rigid`.
    restitution : callable, optional
        Of a rigid block: (rate before the impact [rad/s], r) → restitution.
    fades : float
        Share by which the angle read is less from the fourth second on.
    """

    half: str
    differs: Differs = lambda block, k, theta0: {}
    restitution: Callable[[float, float], float] | None = None
    fades: float = 0.0


def _as_it_is(rate: float, r: float) -> float:
    return r


def _weight_moment(block: Block) -> float:
    return block.mass_kg * GRAVITY * block.b


def middle_depth(block: Block, k: float, theta0: float) -> float:
    """Geometric mean of the depths of a corner at rest and at the release [m]."""
    weight = block.mass_kg * GRAVITY
    return math.sqrt(weight / (2 * block.b * k) * math.sqrt(2 * weight * math.sin(theta0) / k))


KINDS = {
    "Hunt and Crossley's law": Kind("law"),
    "edges rounded by 0.7 mm": Kind("set", lambda block, k, theta0: {"base": {"radius_m": 7e-4}}),
    "mass 0.1 mm off centre": Kind("set", lambda block, k, theta0: {"off_m": 1e-4}),
    "a cable rubs": Kind("set", lambda block, k, theta0: {"friction_nm": 0.002 * _weight_moment(block)}),
    "force by the depth to the 1.05": Kind(
        "set", lambda block, k, theta0: {"power": 0.05, "middle_m": middle_depth(block, k, theta0)}
    ),
    "no contact in the middle 30 %": Kind("set", lambda block, k, theta0: {"base": {"feet": 0.3}}),
    "damping grows with amplitude, ±20 %": Kind("set", lambda block, k, theta0: {"by_amplitude": 0.2}),
    "rigid, r falls with the rate": Kind("set", restitution=lambda rate, r: r + 0.01 - 0.03 * abs(rate)),
    "rigid, r ± 0.01 by the side": Kind("set", restitution=lambda rate, r: r + math.copysign(0.01, rate)),
    "edges rounded by 2 mm": Kind("shown", lambda block, k, theta0: {"base": {"radius_m": 2e-3}}),
    "mass 0.4 mm off centre": Kind("shown", lambda block, k, theta0: {"off_m": 4e-4}),
    "base hollow by 0.05 mm": Kind("shown", lambda block, k, theta0: {"base": {"hollow_m": 5e-5}}),
    "damping by the depth to the 1.2": Kind(
        "shown", lambda block, k, theta0: {"damping_power": 0.2, "middle_m": middle_depth(block, k, theta0)}
    ),
    "air, by the square of the rate": Kind(
        "shown", lambda block, k, theta0: {"air_nms2": 0.003 * _weight_moment(block)}
    ),
    "mat hardens by 1 % a second": Kind("shown", lambda block, k, theta0: {"hardens_per_s": 0.01}),
    "the bed can't pull": Kind("shown", lambda block, k, theta0: {"tensionless": 1.0}),
    "turns out of the plane, 0.6 %": Kind("shown", fades=0.006),
    "slips, μ = 0.2": Kind("shown", lambda block, k, theta0: {"grip": 0.2}),
    "rigid, rolls over edges of 1 mm": Kind(
        "shown", lambda block, k, theta0: {"radius_m": 1e-3}, restitution=_as_it_is
    ),
    "rigid, in air": Kind(
        "shown",
        lambda block, k, theta0: {"air_nms2": 0.003 * _weight_moment(block)},
        restitution=_as_it_is,
    ),
}
COLUMNS = ["kind", "half", "run", "block", "foundation", "explained", "candidate", "parameter"]
COLUMNS += ["error_percent", "stderr_percent", "discrepancy_percent", "inside_stderr", "inside"]


def run(size: str = "full") -> pd.DataFrame:
    """Every kind on blocks and foundations in turn.

    Parameters
    ----------
    size : str
        "full", or "small" for a run of each kind.

    Returns
    -------
    pandas.DataFrame
        A row per run and parameter, k and lambda, or r of a rigid block: kind; half ("set", "shown" or
        "law"); run; block, foundation; explained (some candidate leaves only noise); candidate, the one
        named, or the law as the paper has it where none is or has no such numbers; error, stderr and
        discrepancy in per cent of the truth; inside_stderr (95 % interval of the standard error holds the
        truth), inside (that with the discrepancy does). NaN of a fit that may not be used.
    """
    cases = [(name, i) for i in range(SIZES[size]) for name in KINDS]
    return pd.DataFrame(rows_of_all(rows_of, cases), columns=COLUMNS)


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one run."""
    name, i = case
    kind, (configuration, foundation) = KINDS[name], place(i)
    block, angle, _ = CONFIGURATIONS[configuration]
    generator = np.random.default_rng([SEED, list(KINDS).index(name), i])
    theta0 = angle * generator.uniform(*ANGLES) * generator.choice([-1, 1])
    time_s = np.arange(0.0, LASTS_S, 1 / RATE_HZ)
    restitution = kind.restitution or _as_it_is
    if kind.restitution is None:
        law, true = "hunt_crossley", scattered(FOUNDATIONS[foundation], generator)
        theta = on_bed(block, true, theta0, time_s, **kind.differs(block, true["k"], abs(theta0)))
    else:
        law, r = "housner", generator.uniform(*R)
        differs = kind.differs(block, 0.0, 0.0)
        theta, impacts = rigid(block, lambda rate: restitution(rate, r), theta0, time_s, **differs)
        high = impacts[:, 0] ** 2 > LEAST * impacts[0, 0] ** 2
        true = {"r": float(impacts[high, 1].mean())}
    theta = theta * (1 - kind.fades * np.minimum(time_s / 4, 1))
    motion = virtual_motion(Truth(law, block, true, theta0, SIGMA), generator, (time_s, theta), STILL_S)
    assert motion is not None  # given, not simulated
    hypotheses = Hypotheses((law,), ("guided",), {each: LAWS[each].free for each in LAWS})
    found = identify_run(block, motion, hypotheses)
    choice = found.choice(hypotheses)
    fit = found.fits.get(choice.selected, found.fits[law])
    fit = fit if {*true} <= {*fit.parameters} else found.fits[law]
    key = {"kind": name, "half": kind.half, "run": i + 1, "block": configuration, "foundation": foundation}
    key |= {"explained": choice.explained, "candidate": fit.model}
    return [key | _judged(fit.values[each], fit, each, true[each]) for each in true]


def scattered(soil: Mapping[str, float], generator: Any) -> dict[str, float]:
    """k and lambda somewhat off those of a foundation."""
    return {name: value * (1 + generator.uniform(-SCATTER, SCATTER)) for name, value in soil.items()}


def _judged(value: float, fit: Any, parameter: str, truth: float) -> Row:
    """One number against its truth."""
    at = fit.parameters.index(parameter)
    error, stderr, law = value - truth, float(fit.stderr[at]), float(fit.discrepancy[at])
    known = math.isfinite(stderr)
    both = math.hypot(stderr, law)
    return {
        "parameter": parameter,
        "error_percent": 100 * error / truth if known else math.nan,
        "stderr_percent": 100 * stderr / truth,
        "discrepancy_percent": 100 * law / truth,
        "inside_stderr": abs(error) <= NORMAL_95 * stderr if known else math.nan,
        "inside": abs(error) <= NORMAL_95 * both if known else math.nan,
    }


def coverage(frame: pd.DataFrame) -> pd.DataFrame:
    """Of each kind and parameter, over the runs with a number: how many, and in per cent the shares explained
    and inside (before and after), the median error, standard error and uncertainty with the discrepancy."""
    known = frame.dropna(subset=["error_percent"])
    u = np.hypot(known["stderr_percent"], known["discrepancy_percent"])
    rows = [
        {
            "kind": name,
            "half": own["half"].iloc[0],
            "parameter": parameter,
            "n": len(own),
            "explained": 100 * own["explained"].astype(bool).mean(),
            "before": 100 * own["inside_stderr"].astype(float).mean(),
            "after": 100 * own["inside"].astype(float).mean(),
            "error": own["error_percent"].abs().median(),
            "stderr": own["stderr_percent"].median(),
            "u": u[own.index].median(),
        }
        for (name, parameter), own in known.groupby(["kind", "parameter"], sort=False)
    ]
    return pd.DataFrame(rows)


def markdown(frame: pd.DataFrame) -> str:
    """A row per kind: coverage before and after, and the typical error and width of each parameter."""
    lines = [
        "| motion | chosen or shown on it | explained | | error | stderr | u | inside ± 1.96 stderr "
        "| inside ± 1.96 u |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    table = coverage(frame)
    for _, rows in table.groupby("kind", sort=False):
        for i, row in enumerate(rows.itertuples()):
            first = [row.kind, {"law": "the law itself"}.get(row.half, row.half), f"{row.explained:.0f} %"]
            cells = [*(first if i == 0 else ["", "", ""]), {"lambda": "λ"}.get(row.parameter, row.parameter)]
            cells += [f"{value:.2g} %" for value in (row.error, row.stderr, row.u)]
            cells += [f"{row.before:.0f} %", f"{row.after:.0f} %"]
            lines.append(f"| {' | '.join(map(str, cells))} |")
    for half in ("set", "shown"):
        for explained, which in ((False, "runs that nothing explains"), (True, "runs that a law explains")):
            own = frame[(frame["half"] == half) & (frame["explained"].astype(bool) == explained)]
            told = coverage(own)
            n, means = len(own.drop_duplicates(["kind", "run"])), ["", ""]
            if len(told):
                means = [f"{told[name].mean():.0f} %" for name in ("before", "after")]
            cells = [f"**{half}: {n} {which}, mean of the kinds**", *[""] * 6, *means]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main(product: str, size: str, document: str = "") -> None:
    """Measure, write the product, and renew the table of a document."""
    publish(run(size), product, document, MARK, markdown)


if __name__ == "__main__":
    main(*sys.argv[1:])
