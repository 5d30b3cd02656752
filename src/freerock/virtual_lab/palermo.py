"""The virtual Palermo campaign: three blocks on two foundations, three releases each, and their truth.

    python -m freerock.virtual_lab raw/palermo_virtual

writes six records with the blocks of table 1 and the foundations of table 2 of Spanos et al. 2017
(doi:10.1016/j.proeng.2017.09.024). Nothing in them was measured.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from freerock.rotation.sensor import Laser
from freerock.virtual_lab.added_noise import AddedNoise
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock.virtual_lab.virtual_record import Recording, VirtualRecord, VirtualRelease, simulate_record

LASERS = {  # one that suits each block
    "config1": Laser("horizontal", 0.22, 0.1),
    "config2": Laser("horizontal", 0.20, 0.1),
    "config3": Laser("horizontal", 0.10, 0.1),
}
# Block, release angle [rad] and laser.
CONFIGURATIONS = {name: (block, RELEASE_ANGLES[name], LASERS[name]) for name, block in BLOCKS.items()}
MOST_IMPACTS = 200  # of a release that scatter
FOUNDATIONS = {name: models["hunt_crossley"] for name, models in TABLE_2.items()}


def palermo_releases(
    angle: float, parameters: Mapping[str, float], generator: Any, *, number: int = 3, sigma_r: float = 0.0
) -> list[VirtualRelease]:
    """Releases as an operator does them: angles within ±0.3°, parameters within ±3 %, both uniform.

    Holds and pauses last 1.5 to 2.5 s, tilts 1.2 to 2 s, the finger fades over 5 to 20 ms, and a hand gets
    into the beam up to twice a tilt. The rate after each impact is multiplied by 1 + `sigma_r` g, g normal.
    """

    def draw(low: float, high: float, digits: int = 4) -> float:
        return float(round(generator.uniform(low, high), digits))

    releases = []
    for _ in range(number):
        tilt = draw(1.2, 2.0)
        releases.append(
            VirtualRelease(
                theta0=round(angle + draw(-math.radians(0.3), math.radians(0.3), 6), 6),
                parameters={
                    name: float(f"{value * (1 + draw(-0.03, 0.03, 6)):.6g}")
                    for name, value in parameters.items()
                },
                tilt_s=tilt,
                held_s=draw(1.5, 2.5),
                fade_s=draw(0.005, 0.020),
                pause_s=draw(1.5, 2.5),
                blocked_s=[
                    (start, round(start + draw(0.05, 0.3), 4))
                    for start in (draw(0.1, 0.8) for _ in range(generator.randint(3)))
                ],
                impacts=(sigma_r * generator.standard_normal(MOST_IMPACTS)).round(6).tolist()
                if sigma_r
                else (),
            )
        )
    return releases


def palermo_records() -> Iterator[tuple[str, VirtualRecord]]:
    """Simulate the virtual Palermo campaign: the name of each test and its record."""
    seed = 2017
    for configuration, (block, angle, laser) in CONFIGURATIONS.items():
        for foundation, parameters in FOUNDATIONS.items():
            seed += 1
            generator = np.random.RandomState(seed)
            releases = palermo_releases(angle, parameters, generator, sigma_r=0.01)
            zero_v = round(generator.uniform(4.8, 5.2), 3)
            noise = AddedNoise(mains_hz=round(generator.uniform(49.98, 50.02), 3))
            how = Recording(zero_v=zero_v, noise=noise)
            record = simulate_record(block, laser, "hunt_crossley", releases, seed=seed, recording=how)
            yield f"{configuration}_{foundation}", record
