"""Make the foreign records again: `python benchmarks/foreign/make.py [NAME…]`, a few minutes.

They go to raw/foreign, and what is true of them to benchmarks/foreign/truths.json, which no analysis reads.
Nothing of freerock is imported. Those of MuJoCo and Drake need `make peers`; without it they stay.
"""

import hashlib
import json
import math
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import laser
import numpy as np
import planar
import rigid
from scenes import ANGLES, BLOCKS, LASERS, SCENES

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RAW, TRUTHS = ROOT / "raw/foreign", HERE / "truths.json"
PEERS = ROOT / ".venv-peers/bin/python"
REST_S, TILT_S, HOLD_S, FADE_S, AFTER_S = 1.5, 1.0, 1.4, 0.012, 1.6
LEAST_RAD = 2e-3  # of swings whose impacts are told
LEAST_SHARE = 0.01  # of the energy at the release


def runs_of(scene):
    """Start, tilt, hold and fade [s] and angle [rad] of the releases; and the end of the record [s]."""
    length = TILT_S + HOLD_S + FADE_S + scene["free_s"] + AFTER_S
    runs = [[REST_S + i * length, TILT_S, HOLD_S, FADE_S, a] for i, a in enumerate(ANGLES[scene["block"]])]
    return runs, REST_S + length * len(runs)


def moved(scene, runs, until_s):
    """How far the target moves away [m], θ [rad], and what is known of impacts.

    Of a rigid block these are instants [s] and rates before and after, of a planar one its energies [J].
    """
    block, (height, _) = BLOCKS[scene["block"]], LASERS[scene["block"]]
    if scene["motion"] == "planar":
        found = planar.rock(
            block | scene["off"],
            scene["base"],
            scene["law"],
            scene["values"],
            runs,
            until_s,
            **scene["extra"],
        )
        x, z, theta, energy = found.T
        u, w = -block["width_m"] / 2 - scene["off"].get("centre_off_m", 0.0), -block["height_m"] / 2
        x, z = x + u * np.cos(theta) + w * np.sin(theta), z + w * np.cos(theta) - u * np.sin(theta)
        return laser.reading(x, z, theta, height), theta, energy
    if scene["motion"] == "rigid":
        theta, impacts = rigid.rock(block, scene["restitution"], runs, until_s, scene["radius"])
        x, z = rigid.left_corner(block, theta, scene["radius"])
        return laser.reading(x, z, theta, height), theta, impacts
    asked = block | scene["setting"] | {"laser_m": height, "runs": runs, "until_s": until_s}
    driver = HERE / f"engine_{scene['motion']}.py"
    done = subprocess.run(
        [PEERS, driver], input=json.dumps(asked), capture_output=True, text=True, check=True
    )
    x, theta = np.array(json.loads(done.stdout)).T
    return x - x[0], theta, []


def true_runs(block, theta, runs, known):
    """Of each release: when, from where, the impacts and what they leave: √(energy after / energy before).

    Energies are those at the tops of the swings; before the first impact it is that at the instant when the
    hand has left. Of an engine's box they are those of a rigid block.
    """
    b, h = block["width_m"] / 2, block["height_m"] / 2
    critical, radius = math.atan2(b, h), math.hypot(b, h)
    told = []
    for i, (start, tilt, hold, fade, _) in enumerate(runs):
        let_go = start + tilt + hold
        end = runs[i + 1][0] if i + 1 < len(runs) else theta.size / 1000
        first, last = round(1000 * let_go), round(1000 * end)
        part, time = theta[first:last], np.arange(first, last) / 1000
        # the rest may lean: sides are counted from there
        part = part - float(np.mean(part[-300:]))
        crossing = np.flatnonzero(part[:-1] * part[1:] < 0)
        ends = [0, *crossing, part.size - 1]
        places = [a + int(np.argmax(np.abs(part[a : z + 1]))) for a, z in pairwise(ends)]
        tops = [float(abs(part[place])) for place in places]
        if isinstance(known, np.ndarray):
            places[0] = math.ceil(1000 * fade)
            energy = known[first:last][places] - float(np.mean(known[first:last][-300:]))
        else:
            cosines = np.cos(np.maximum(critical - np.array(tops), 0.0))
            energy = 9.81 * radius * (cosines - math.cos(critical))
        # a bed with hysteresis may hold more energy at rest than in a low swing
        high = np.array(tops) > LEAST_RAD
        high &= energy > LEAST_SHARE * energy[0]
        kept = [j for j in range(len(crossing)) if all(high[: j + 2])]
        instants = [time[c] + 1e-3 * part[c] / (part[c] - part[c + 1]) for c in crossing[kept]]
        left = [math.sqrt(energy[j + 1] / energy[j]) for j in kept]
        if isinstance(known, list):
            for j, at in enumerate(instants):
                left[j] = next((after / before for t, before, after in known if abs(t - at) < 2e-3), left[j])
        told.append(
            {
                "let_go_s": round(let_go, 4),
                "free_s": round(let_go + fade, 4),
                "theta0_rad": round(float(part[0]), 6),
                "impacts_s": [round(float(t), 5) for t in instants],
                "restitution": [round(float(r), 5) for r in left],
            }
        )
    return told


def make(name, seed):
    """Write a record, and tell what is true of it."""
    scene = SCENES[name]
    runs, until_s = runs_of(scene)
    away, theta, known = moved(scene, runs, until_s)
    block, (_, range_m) = BLOCKS[scene["block"]], LASERS[scene["block"]]
    laser.write(RAW / f"{name}.{scene['format']}", laser.counts(away, range_m, seed))
    return {
        "origin": "simulated",
        "about": scene["about"],
        "made_by": scene["motion"],
        "block": block | scene.get("off", {}),
        "right_choices": scene["choices"],
        "parameters": scene["truth"],
        "runs": true_runs(block, theta, runs, known),
    }


def main(wanted):
    """Make some records or all, and the list of checksums."""
    RAW.mkdir(parents=True, exist_ok=True)
    truths = json.loads(TRUTHS.read_text()) if TRUTHS.exists() else {}
    for seed, (name, scene) in enumerate(SCENES.items(), 1):
        engine = scene["motion"] in ("mujoco", "drake")
        if (wanted and name not in wanted) or (engine and not PEERS.exists()):
            continue
        truths[name] = make(name, seed)
        print(name, [len(run["impacts_s"]) for run in truths[name]["runs"]], flush=True)
        truths = {name: truths[name] for name in SCENES if name in truths}
        TRUTHS.write_text(json.dumps(truths) + "\n", encoding="utf-8")
    files = [RAW / f"{name}.{scene['format']}" for name, scene in SCENES.items() if name in truths]
    lines = [f"{f.name},{hashlib.sha256(f.read_bytes()).hexdigest()},{f.stat().st_size}" for f in files]
    (RAW / "manifest.csv").write_text("\n".join(["file,sha256,bytes", *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
