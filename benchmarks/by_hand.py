"""A fit as a laboratory would write it: lmfit around SciPy's solve_ivp, and the paper's objective ε_θ.

    python -m freerock_bench.evidence by_hand                                     # this beside freerock
    python benchmarks/by_hand.py results/studies/by_hand/*/records/*.npz          # on the same records, alone

Block, angle and instant of the release are taken as measured; k and c or λ are fitted to the whole first run
of each record, from the values of table 2. It imports nothing of freerock.
"""

import csv
import math
import sys
import time
from pathlib import Path

import lmfit
import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G = 9.81
START = {"winkler": {"k": 6.77e6, "c": 2.17e4}, "hunt_crossley": {"k": 6.88e6, "lambda": 1.30e8}}


@njit(cache=True)
def contact(z, v, theta, w, b, law):
    """Force and moment of the bed: sums over Gauss's two places of the contact."""
    s, c = math.sin(theta), math.cos(theta)
    left, right = -b, b
    if s > 0:
        left = max(-b, -z / s)
    elif s < 0:
        right = min(b, -z / s)
    if right <= left or (s == 0 and z <= 0):
        return 0.0, 0.0
    force = moment = 0.0
    for node in (-(3**-0.5), 3**-0.5):
        u = 0.5 * (left + right) + 0.5 * (right - left) * node
        depth, rate = z + u * s, v + u * w * c
        f = 0.5 * (right - left) * (law[0] * depth + (law[1] + law[2] * depth) * rate)
        force, moment = force + f, moment + f * u * c
    return force, moment


@njit(cache=True)
def rates(t, y, m, inertia, b, h, pivoting, law):
    """Eqs. (1) of Spanos et al. 2017, or the same of a block that turns about its lower corner."""
    z, v, theta, w = y
    s, c = math.sin(theta), math.cos(theta)
    force, moment = contact(z, v, theta, w, b, law)
    side = pivoting * np.sign(theta)
    slide, bend = h * c + side * b * s, -h * s + side * b * c
    bracket = G - force / m
    turning = m * G * h * s - moment - m * slide * bend * w * w - m * h * s * bracket
    turning /= inertia + m * slide * slide
    return np.array([v, bracket - h * s * turning - h * c * w * w, w, turning])


def motion(record, law, values, time_s):
    """θ(t) of a law [rad]."""
    m, h, b = (float(record[f"stated_{name}"]) for name in ("mass_kg", "height_m", "width_m"))
    h, b = h / 2, b / 2
    soil = np.array([values["k"], values.get("c", 0.0), values.get("lambda", 0.0)])
    theta0 = float(record["run0_theta0_measured"])
    reach = b * math.sin(abs(theta0))
    depth = brentq(lambda z: contact(z, 0.0, theta0, 0.0, b, soil)[0] - m * G, -reach, reach + 0.02)
    given = (m, m * (b * b + h * h) / 3, b, h, float(record["true_kinematics"] == "pivoting"), soil)
    found = solve_ivp(
        rates,
        (0.0, time_s[-1]),
        [depth, 0.0, theta0, 0.0],
        "LSODA",
        time_s,
        args=given,
        rtol=1e-8,
        atol=1e-10,
    )
    return found.y[2]


def fitted(record, law):
    """Values, ε_θ and seconds of a fit of the first run."""
    time_s, theta = record["run0_time"], record["run0_theta"]
    time_s = np.maximum(time_s - time_s[0], 0.0)[::4]
    theta = theta[::4]
    parameters = lmfit.Parameters()
    for name, value in START[law].items():
        parameters.add("lambda_" if name == "lambda" else name, value=math.log(value), min=0.0, max=40.0)

    def residual(moved):
        values = {name.rstrip("_"): math.exp(each.value) for name, each in moved.items()}
        return motion(record, law, values, time_s) - theta

    begin = time.process_time()
    found = lmfit.minimize(residual, parameters, method="leastsq", max_nfev=200)
    spent = time.process_time() - begin
    values = {name.rstrip("_"): math.exp(each.value) for name, each in found.params.items()}
    return values, float(np.sum(found.residual**2) / np.sum(theta**2)), spent


def main(*paths):
    """Print a row per record, law and parameter."""
    out = csv.writer(sys.stdout)
    out.writerow(
        ["record", "sigma_r", "true_law", "law", "epsilon_theta", "seconds", "parameter", "truth", "value"]
    )
    for path in paths:
        record = np.load(path)
        true = str(record["true_law"])
        for law in START:
            if true == "housner":
                continue
            values, epsilon, spent = fitted(record, law)
            for name, value in values.items():
                truth = float(record[f"run0_{name}"]) if law == true else math.nan
                row = [
                    Path(path).stem,
                    float(record["true_sigma_r"]),
                    true,
                    law,
                    epsilon,
                    spent,
                    name,
                    truth,
                    value,
                ]
                out.writerow(row)
                sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
