"""Three SIMULATED record files of a random scene, written by a program that knows nothing of freerock.

    python docs/tutorial/another_laboratory.py FOLDER [SEED]

A stone block on a compliant base, released once per record, as a laser's voltage in TDMS. The equations are
those of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024), integrated by SciPy; only NumPy, SciPy and
npTDMS are used. What a laboratory would note in its book is printed; the stiffness k and the damping λ of the
base, which it does not know, go to secret.txt beside the folder.
"""

import math
import sys
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, RootObject, TdmsWriter
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G, RATE = 9.81, 2000.0


def contact(k, lam, b, z, z_rate, theta, theta_rate):
    """Force and moment of the base: f = k z + λ z ż per metre of what is below the ground."""
    slope, spin = math.sin(theta), theta_rate * math.cos(theta)
    low, high = -b, b
    if slope > 0:
        low = max(low, -z / slope)
    elif slope < 0:
        high = min(high, -z / slope)
    if low >= high or (slope == 0 and z <= 0):
        return 0.0, 0.0
    force = moment = 0.0
    for u, weight in ((low, 1), ((low + high) / 2, 4), (high, 1)):
        depth = z + u * slope
        f = weight / 6 * (high - low) * (k * depth + lam * depth * (z_rate + u * spin))
        force, moment = force + f, moment + f * u * math.cos(theta)
    return force, moment


def rocking(block, k, lam, theta0, time):
    """θ [rad] of a block let go at θ₀, and how deep its lower corner lies [m]."""
    h, b, m = block["height"] / 2, block["width"] / 2, block["mass"]
    inertia = m * (block["height"] ** 2 + block["width"] ** 2) / 12 + m * h * h

    def rates(_, y):
        z, z_rate, theta, theta_rate = y
        force, moment = contact(k, lam, b, z, z_rate, theta, theta_rate)
        s, c = math.sin(theta), math.cos(theta)
        down = G - force / m - h * c * theta_rate**2  # z̈ + h sinθ θ̈
        turn = m * G * h * s - moment  # I θ̈ + m h sinθ z̈
        acceleration = (turn - m * h * s * down) / (inertia - m * (h * s) ** 2)
        return [z_rate, down - h * s * acceleration, theta_rate, acceleration]

    depth = at_rest(block, k, theta0)
    found = solve_ivp(
        rates, (0, time[-1]), [depth, 0, theta0, 0], "DOP853", time, rtol=1e-8, atol=1e-11, max_step=5e-3
    )
    return found.y[2], found.y[0] + b * np.abs(np.sin(found.y[2]))


def at_rest(block, k, theta):
    """Depth of the base centre where the base carries the block [m]."""
    width, weight = block["width"], block["mass"] * G
    return brentq(lambda z: contact(k, 0.0, width / 2, z, 0, theta, 0)[0] - weight, -width, width)


def reading(theta, sunk, block, beam_height):
    """Movement of a side face at the height of the beam; the block turns about its corners, which sink."""
    width = np.where(theta > 0, block["width"], 0.0)
    return (beam_height + sunk) * np.tan(theta) - width * (1 / np.cos(theta) - 1)


def record(block, k, lam, laser, theta0, draw):
    """Volts of one record: rest, tilt, hold, rocking, rest."""
    ramp = np.linspace(0, 1, int(1.5 * RATE))
    held = np.full(int(draw.uniform(1.6, 2.2) * RATE), theta0)
    theta, sunk = rocking(block, k, lam, theta0, np.arange(1, 12 * RATE) / RATE)
    moving = np.flatnonzero(np.abs(theta) > 1e-5)[-1]
    rest = np.zeros(int(2 * RATE))
    tilted = theta0 * ramp**2 * (3 - 2 * ramp)
    before = [at_rest(block, k, each) + block["width"] / 2 * abs(math.sin(each)) for each in tilted]
    before = np.concatenate([rest, before, np.full(held.size, before[-1])])
    theta = np.concatenate([rest, tilted, held, theta[: moving + 1], rest])
    sunk = np.concatenate([before, sunk[: moving + 1], rest])
    volts = 5 + 10 * reading(theta, sunk, block, laser["beam_height"]) / laser["range"]
    return volts + 0.002 * draw.standard_normal(volts.size)


def main(folder, seed=2026):
    draw = np.random.default_rng(int(seed))
    height = round(draw.uniform(0.22, 0.4), 3)
    width = round(height * draw.uniform(0.2, 0.3), 3)
    block = {"height": height, "width": width, "mass": round(2700 * height * width * 0.11, 2)}
    laser = {"beam_height": round(0.7 * height, 3), "range": 0.1}
    k, lam = 10 ** draw.uniform(6.4, 6.9), 10 ** draw.uniform(7.8, 8.1)
    folder = Path(folder)
    folder.mkdir(parents=True)
    for number in (1, 2, 3):
        theta0 = math.atan(width / height) * draw.uniform(0.5, 0.7)
        volts = record(block, k, lam, laser, theta0, draw)
        waveform = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0, "unit_string": "V"}
        root = RootObject({"description": "SIMULATED; nothing in it was measured."})
        with TdmsWriter(folder / f"stone_{number}.tdms") as writer:
            writer.write_segment([root, ChannelObject("Untitled", "laser", volts, waveform)])
    (folder.parent / "secret.txt").write_text(f"k = {k:.4g} N/m2, lambda = {lam:.4g} N s/m3\n")
    print(f"block: {height} m high, {width} m wide, {block['mass']} kg")
    print(
        f"laser: horizontal beam {laser['beam_height']} m above the base, 0 to 10 V over {laser['range']} m"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
