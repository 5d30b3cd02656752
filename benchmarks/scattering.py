"""A campaign whose impacts scatter by 2 %: three blocks on two foundations, with the paper's numbers.

python benchmarks/scattering.py FOLDER, then snakemake --directory FOLDER

writes records in volts of the second simulator (`freerock_bench.springs`), and their configuration.
"""

import sys
from pathlib import Path

import numpy as np
import yaml

from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2
from freerock_bench.scattered import BEAMS_M, FADES_S, KNOWN, RATE_HZ, RUNS, Run, Truth, inputs, volts_of
from freerock_bench.springs import Motion, Scene

ROOT = Path(__file__).parents[1]
SIGMA_R, KNOWLEDGE = 0.02, "callipers"
LABELS = {"config1": "Configuration #1", "config2": "Configuration #2", "config3": "Configuration #3"}


def released(truth: Truth, draw: np.random.Generator) -> Run:
    """A run that a hand lets go from the paper's angle, or from near it."""
    law, deltas = truth.of_run(draw), truth.sigma_r * draw.standard_normal(400)
    theta0 = float(RELEASE_ANGLES[truth.block_name] + np.radians(draw.uniform(-0.3, 0.3)))
    impacts = np.column_stack([1 + deltas, np.ones((400, 2))])
    scene = Scene(truth.block, law, False, theta0, draw.uniform(*FADES_S), impacts=impacts)
    return Run(law, deltas, Motion(scene, RATE_HZ / truth.clock))


def main(folder: Path) -> None:
    """Write raw/scattering and config."""
    raw, campaigns = folder / "raw/scattering", folder / "config/campaigns"
    for each in (raw, campaigns):
        each.mkdir(parents=True, exist_ok=True)
    u = KNOWN[KNOWLEDGE]
    of_laser = {name: u[name] for name in ("position_m", "scale_fraction", "sampling_rate_fraction")}
    parts: dict[str, dict] = {"blocks": {}, "lasers": {}}
    parts["foundations"] = {"marble": {"label": "Marble"}, "aerstop": {"label": "Aerstop CN20"}}
    lines = ["test,file,channel,block,foundation,laser,exclude,override,reason,note"]
    for i, (name, base) in enumerate((name, base) for name in BLOCKS for base in TABLE_2):
        draw, law = np.random.default_rng([7, i]), "hunt_crossley"
        known = inputs(BLOCKS[name], BEAMS_M[name], KNOWLEDGE, draw)
        truth = Truth(law, "guided", name, base, SIGMA_R, 0.0, {**TABLE_2[base][law]}, KNOWLEDGE, **known)
        volts, _ = volts_of(truth, [released(truth, draw) for _ in range(RUNS)], draw)
        rows = np.column_stack([np.arange(len(volts)) / RATE_HZ, volts])
        head = {"delimiter": ",", "header": "time [s],laser [V]", "comments": ""}
        np.savetxt(raw / f"{name}_{base}.csv", rows, fmt=["%.5f", "%.6f"], **head)
        block = {key: getattr(BLOCKS[name], key) for key in ("height_m", "width_m", "mass_kg")}
        off = {"height_m": u["height_m"], "width_m": u["width_m"], "mass_kg": u["mass"] * block["mass_kg"]}
        block["release_angle_deg"] = round(np.degrees(RELEASE_ANGLES[name]).item())
        parts["blocks"][name] = block | {"label": LABELS[name], "uncertainty": off}
        laser = {"beam": "horizontal", "position_m": BEAMS_M[name], "range_m": 0.1, "units": "V"}
        parts["lasers"][f"at_{name}"] = laser | {"uncertainty": of_laser}
        lines.append(f"{name}_{base},{name}_{base}.csv,,{name},{base},at_{name},,,,")
    paper = yaml.safe_load((ROOT / "config/campaigns/palermo_virtual.yaml").read_text(encoding="utf-8"))
    told = {"title": "Three blocks whose impacts scatter by 2 %", "origin": "simulated"}
    stated = told | {key: paper[key] for key in ("summary", "published")} | parts
    (campaigns / "scattering.yaml").write_text(yaml.safe_dump(stated, sort_keys=False), encoding="utf-8")
    (campaigns / "scattering.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    (folder / "config/config.yaml").write_text("campaigns: [scattering]\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
