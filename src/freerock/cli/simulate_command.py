"""A scene simulated: a virtual record, or θ(t) of models on a moving ground or a resting one.

example:
  freerock simulate examples/shake_table.yaml
  freerock simulate examples/virtual_record.yaml

A scene with a laser gives a record file (TDMS) of the virtual laboratory. Any other scene gives
θ(t) of each model (CSV, PDF, PNG), with or without ground motion.
"""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.config.keys_of_scene import load_scene


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("scene", metavar="SCENE.yaml", help="the scene, see config/README.md")
    add("--into", metavar="FOLDER", default="results/simulate", help="where the files go")


def run(chosen: Namespace) -> None:
    """Simulate a scene, as a record or as θ(t)."""
    path = Path(chosen.scene)
    scene = load_scene(path)  # refused before the numerical libraries are loaded
    stem = Path(chosen.into) / path.stem

    from freerock.figures.simulated_scene import draw
    from freerock.figures.style import save
    from freerock.virtual_lab.simulate_scene import scene_text, simulate_scene, write_scene_record

    if scene.laser:
        write_scene_record(scene, stem.with_suffix(".tdms"))
        print(f"written: {stem}.tdms (simulated)")
        return
    frame, responses = simulate_scene(scene, path.parent)
    save(*draw(frame), stem, origin="simulated")
    print(scene_text(scene, responses))
    print(f"\nwritten: {stem}.csv, .pdf, .png (simulated)")
