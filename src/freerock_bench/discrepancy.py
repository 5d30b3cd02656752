"""Do k ± u, λ ± u and r ± u hold where the block moves as no law says, and r by energy of each impact?

Motions by integrations of their own (`imperfect`), each unlike every law in one way, with the noise of a
laser. The answer of the law with its rivals is held against the truth, with the standard error of the noise
alone and with the discrepancy of the law. How the parts of a run weigh was chosen on one half of the kinds,
and is shown on the other; how r by energy follows from them, on the first runs. The energy of each top is
known to the integration of a bed; √(E after / E before) is held against r by energy under the law.

    python -m freerock_bench.discrepancy results/studies/discrepancy.csv full docs/validation.md

measures on all cores (`small`: a run of each kind in a minute; `full`: twenty, in a quarter of an hour of
processor time) and renews the table in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.identification.fit import Fit
from freerock.models.block import GRAVITY, Block
from freerock.models.laws import LAWS
from freerock.populations.impact_energy import impact_energy
from freerock.runs.impacts import find_impacts
from freerock.selection.hypotheses import Hypotheses
from freerock.selection.hypothesis_search import identify_run
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock_bench.harness import Study, number_row, rows_of_fit
from freerock_bench.imperfect import on_bed, rigid, tops_on_bed
from freerock_bench.truths import ANGLES, place
from freerock_bench.virtual_run import RATE_HZ, SEED, Row, Truth, virtual_motion

SIZES = {"small": 1, "full": 20}  # runs of each kind; six make a round of blocks and foundations
SIGMA = math.radians(0.006)
STILL_S = (1.5, 1.5)
SCATTER = 0.03
R = (0.93, 0.97)
LEAST = 0.1  # of the height of the first swing: the true r is the mean over impacts of higher ones
LASTS_S = 6.0
FIRST = 6  # how r by energy follows from the parts of a run was chosen on runs before
LOWEST = 20 * SIGMA  # tops that count for r by energy
UNKNOWN = ("turns out of the plane, 0.6 %", "slips, μ = 0.2")  # whose integration knows no energies
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
COLUMNS = ["half", "run", "block", "foundation", "explained", "candidate", "impact"]


def cases(size: str) -> list[tuple[str, int]]:
    """Kind and number of each run, on blocks and foundations in turn."""
    return [(name, i) for i in range(SIZES[size]) for name in KINDS]


def rows_of(case: tuple[str, int]) -> list[Row]:
    """Rows of one run: k and lambda, or r of a rigid block, then r by energy of each impact under the law.

    The numbers are of the candidate named, or of the law as the paper has it where none is or has no such.
    """
    name, i = case
    kind, (configuration, foundation) = KINDS[name], place(i)
    block, angle, _ = CONFIGURATIONS[configuration]
    generator = np.random.default_rng([SEED, list(KINDS).index(name), i])
    theta0 = angle * generator.uniform(*ANGLES) * generator.choice([-1, 1])
    time_s = np.arange(0.0, LASTS_S, 1 / RATE_HZ)
    restitution, tops = kind.restitution or _as_it_is, None
    if kind.restitution is None:
        law, true = "hunt_crossley", scattered(FOUNDATIONS[foundation], generator)
        differs = kind.differs(block, true["k"], abs(theta0))
        if name in UNKNOWN or i < FIRST:
            theta = on_bed(block, true, theta0, time_s, **differs)
        else:
            theta, *tops = tops_on_bed(block, true, theta0, time_s, **differs)
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
    rows = rows_of_fit(name, fit, true)
    if tops and found.fits[law].success:
        rows += _by_energy(name, found.fits[law], block, *tops)
    own = {"half": kind.half, "run": i + 1, "block": configuration, "foundation": foundation}
    own |= {"explained": choice.explained, "candidate": fit.model}
    return [own | row for row in rows]


def scattered(soil: Mapping[str, float], generator: Any) -> dict[str, float]:
    """k and lambda somewhat off those of a foundation."""
    return {name: value * (1 + generator.uniform(-SCATTER, SCATTER)) for name, value in soil.items()}


def _by_energy(
    name: str, fit: Fit, block: Block, impacts: Floats, heights: Floats, energies: Floats
) -> list[Row]:
    """r by energy of the impacts whose tops are higher than `LOWEST`, against the integration's own."""
    high = int(np.argmax(np.append(heights, 0.0) < LOWEST)) - 1
    modelled = find_impacts(fit.time, fit.theta_model, 0.0, block, theta0=fit.values["theta0"])
    seen = modelled.time_s[:high]
    found = impact_energy(fit, block, seen)
    nearest = np.argmin(np.abs(impacts[:, None] - seen), axis=0)
    true = np.sqrt(energies[nearest + 1] / energies[nearest])
    return [
        number_row(name, "r_energy", *map(float, each)) | {"impact": j}
        for j, each in enumerate(
            zip(true, found.restitution, found.stderr, found.u_total, strict=True), start=1
        )
    ]


STUDY = Study(cases, rows_of, COLUMNS, MARK, ["half", "explained"])
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
