"""Writes trajectories.csv: configuration 2 on marble by quadrature of the contact law and SciPy's DOP853.

Nothing of freerock is used, so that the models are checked against another program.
"""

import csv
import math
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

B, H, MASS, G = 0.035, 0.14, 5.84, 9.81
INERTIA = MASS * ((2 * B) ** 2 + (2 * H) ** 2) / 12 + MASS * H**2
LAWS = {"hunt_crossley": (6.88e6, 0.0, 1.30e8), "winkler": (6.77e6, 2.17e4, 0.0)}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def force_and_moment(law, z, rate, theta, spin):
    """Gauss quadrature of f = k z + c ż + λ z ż over the part of the base that is below ground."""
    k, c, lam = law
    slope = math.sin(theta)
    low, high = -B, B
    if slope and -B < -z / slope < B:
        low, high = (-z / slope, B) if slope > 0 else (-B, -z / slope)
    elif z <= 0:
        return 0.0, 0.0
    u = (high + low) / 2 + (high - low) / 2 * NODES
    depth, speed = z + u * slope, rate + u * spin * math.cos(theta)
    pressure = (k * depth + c * speed + lam * depth * speed) * (high - low) / 2 * WEIGHTS
    return pressure.sum(), (pressure * u).sum() * math.cos(theta)


def derivatives(time_s, state, law):
    _, rate, theta, spin = state
    force, moment = force_and_moment(law, *state)
    sin, cos = math.sin(theta), math.cos(theta)
    accelerations = np.linalg.solve(
        [[MASS, MASS * H * sin], [MASS * H * sin, INERTIA]],
        [MASS * G - force - MASS * H * spin**2 * cos, MASS * G * H * sin - moment],
    )
    return [rate, accelerations[0], spin, accelerations[1]]


def trajectory(law, time, theta0):
    """Rotation [rad] from rest at theta0 [rad] in vertical equilibrium, at the given instants [s]."""
    depth = brentq(
        lambda z: force_and_moment((law[0], 0.0, 0.0), z, 0, theta0, 0)[0] - MASS * G,
        -B * math.sin(theta0),
        B,
    )
    start = [depth, 0.0, theta0, 0.0]
    solution = solve_ivp(
        derivatives, (0, time[-1]), start, "DOP853", time, args=(law,), rtol=1e-12, atol=1e-15, max_step=2e-3
    )
    return solution.y[2]


if __name__ == "__main__":
    time = np.round(np.arange(0, 5.001, 0.02), 2)
    columns = [trajectory(law, time, math.radians(10)) for law in LAWS.values()]
    with open(Path(__file__).with_name("trajectories.csv"), "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["time_s", *(f"theta_{name}_rad" for name in LAWS)])
        writer.writerows(zip(time, *(np.round(column, 13) for column in columns), strict=True))
