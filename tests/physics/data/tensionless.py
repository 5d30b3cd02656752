"""Writes tensionless.csv: configuration 3 on Aerstop under the tensionless rule, by SciPy's DOP853.

The law is that of `plain_law`, which the compiled integrator does not use.
"""

import math
from pathlib import Path

import numpy as np
from plain_law import accelerations
from scipy.integrate import solve_ivp

from freerock.models.block import Block
from freerock.models.block_on_bed import State, static_depth
from freerock.models.laws import Foundation, Rules

BLOCK = Block(0.14, 0.07, 2.98)
LAWS = {"winkler": (4.50e6, 4.05e4, 0.0), "hunt_crossley": (2.86e6, 0.0, 8.16e7)}


def motion(law, time, theta0):
    """θ from rest at theta0 in vertical equilibrium, shape (n_time,) [rad]."""

    def rates(_, state):
        a, turn = accelerations(BLOCK, Foundation(*law), State(*state), Rules("tensionless"))
        return state[1], a, state[3], turn

    start = [static_depth(BLOCK, Foundation(*law), theta0), 0.0, theta0, 0.0]
    return solve_ivp(
        rates, (0, time[-1]), start, "DOP853", t_eval=time, rtol=1e-13, atol=1e-16, max_step=2e-3
    ).y[2]


if __name__ == "__main__":
    time = np.arange(101) * 0.02
    columns = [time, *(motion(law, time, math.radians(20)) for law in LAWS.values())]
    header = ",".join(["time_s", *(f"theta_{name}_rad" for name in LAWS)])
    path = Path(__file__).with_name("tensionless.csv")
    np.savetxt(path, np.column_stack(columns), fmt="%.13g", delimiter=",", header=header, comments="")
