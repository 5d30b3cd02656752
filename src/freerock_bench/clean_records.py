"""Clean records of `springs`, which share nothing with the laws that are fitted, and what is true of them.

Block, foundation and kind come in turn; angle, finger, hold and soil are drawn from the record's own seed.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from freerock.arrays import Floats
from freerock.errors import FreerockError
from freerock.models.laws import LAWS, Candidate
from freerock.rotation.sensor import Laser
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.analysed import Measured, measured
from freerock_bench.springs import Motion, Scene, energy, on_corners, read, standing
from freerock_bench.truths import place, table_2
from freerock_bench.virtual_run import SEED, Row

RATE_HZ = 2000.0
V_PER_M, ZERO_V = 100.0, 5.0
REST_S, LONGEST_S = 2.0, 12.0
KINDS = ("guided", "pivoting", "worn", "rigid")
SEEN = np.linspace(-0.4, 0.4, 4001)  # angles among which a beam's is sought [rad]


@dataclass(frozen=True, eq=False)
class CleanRecord:
    """A record without noise and what is true of it.

    Parameters
    ----------
    scene : Scene
    laser : Laser
    names : tuple of str
        Block, foundation and kind.
    candidate : str
        The one that holds the truth.
    volts, theta, moving : ndarray, shape (n_time,)
        Reading [V], rotation [rad], and 1 where the block moves freely or as the finger leaves.
    let_go_s : float
        When the finger begins to leave, since the start.
    path : ndarray, shape (12, n)
        States since then, as of `springs.Motion`.
    """

    scene: Scene
    laser: Laser
    names: tuple[str, str, str]
    candidate: str
    volts: Floats
    theta: Floats
    moving: Floats
    let_go_s: float
    path: Floats

    @property
    def parameters(self) -> dict[str, float]:
        """What a fit may find: of the law, and the distance of the corners [SI]."""
        left, right = self.scene.ends
        return {**self.scene.law, "width": right - left}

    @property
    def release_s(self) -> float:
        """Half of the finger is gone."""
        return self.let_go_s + self.scene.fade_s / 2

    @property
    def theta0(self) -> float:
        """The held angle."""
        return float(self.peaks[0])

    @property
    def impacts_s(self) -> Floats:
        """Instants at which the block stands upright [s], each with a top after it."""
        return np.asarray(self.let_go_s + self._passes[: len(self._tops)] / RATE_HZ)

    @cached_property
    def peaks(self) -> Floats:
        """Angle of the hold and of the tops after it, as the beam shows them by the geometry of a corner that
        does not sink [rad]."""
        rigid = Scene(self.scene.block, {"r": 1.0}, True, self.scene.theta0)
        known = read(on_corners(rigid, SEEN), rigid, self.laser.position)
        return np.interp(read(self.path[:, [0, *self._tops]], self.scene, self.laser.position), known, SEEN)

    @property
    def block_peaks(self) -> Floats:
        """The same angles, of the block itself [rad]."""
        return np.asarray(self.path[2, [0, *self._tops]])

    @cached_property
    def energies(self) -> Floats:
        """Of the block on its bed above rest, when the finger has left it and at its tops [J]."""
        free = int(np.ceil(self.scene.fade_s * RATE_HZ))
        rests = energy(standing(self.scene)[:, None], self.scene)
        return energy(self.path[:, [free, *self._tops]], self.scene) - rests

    @cached_property
    def _passes(self) -> Any:
        theta = self.path[2]
        return np.flatnonzero(theta[1:] * theta[:-1] < 0)

    @cached_property
    def _tops(self) -> list[int]:
        theta = self.path[2]
        return [int(i + np.argmax(np.abs(theta[i:j]))) for i, j in pairwise(self._passes + 1)]

    def first_run(self, volts: Floats) -> tuple[Row, Measured | None]:
        """Level and names of the verdict on the record's run, and the run; none of a refused record."""
        try:
            found = measured(np.arange(len(volts)) / RATE_HZ, volts, self.laser, self.scene.block)
        except FreerockError as error:
            return {"level": "fail", "names": str(error.what)}, None
        verdict = found.run.verdict
        return {"level": verdict.level, "names": " ".join(verdict.names)}, found


def kind_of(i: int) -> str:
    """Kind of the i-th record: six of each in turn, twenty-four make a round."""
    return KINDS[i // 6 % len(KINDS)]


def law_of(i: int) -> str:
    """The law of the i-th record."""
    if kind_of(i) == "rigid":
        return "housner"
    return "winkler" if kind_of(i) == "pivoting" and i // 24 % 2 else "hunt_crossley"


@lru_cache(64)
def truth_of(i: int) -> CleanRecord:
    """The i-th record without noise."""
    draw = np.random.default_rng([SEED, 35, i])
    (name, foundation), kind, law = place(i), kind_of(i), law_of(i)
    block, angle, laser = CONFIGURATIONS[name]
    soil = {key: value * draw.uniform(0.9, 1.1) for key, value in table_2(law, foundation).items()}
    if kind == "rigid":
        soil = {"r": table_2("housner", foundation)["r"] ** draw.uniform(1.0, 1.5)}
    worn_m = block.width_m / 2 * (1 - draw.uniform(0.92, 0.98)) if kind == "worn" else 0.0
    theta0 = angle * draw.uniform(0.6, 1.0) * draw.choice([-1, 1])
    base = {"left_m": worn_m, "right_m": worn_m}
    scene = Scene(block, soil, kind in ("pivoting", "rigid"), float(theta0), draw.uniform(3e-3, 12e-3), base)
    hold = round(1e3 * draw.uniform(1.5, 2.5)) * round(RATE_HZ / 1e3)
    motion = Motion(scene, RATE_HZ, LONGEST_S)
    rest, n = hold - 1, motion.states.shape[1]  # the run ends with a sample at rest
    states, begins = motion.record(round(REST_S * RATE_HZ), hold, rest)
    way = read(states, scene, laser.position)
    kinematics = "pivoting" if kind == "pivoting" else LAWS[law].kinematics[0]
    return CleanRecord(
        scene,
        laser,
        (name, foundation, kind),
        Candidate(law, kinematics, kind == "worn").name,
        ZERO_V + V_PER_M * (way - way[0]),
        states[2],
        np.repeat([0.0, 1.0, 0.0], [begins, n, rest]),
        begins / RATE_HZ,
        motion.states,
    )
