"""The identified law of a foundation as a program for another engine, which is run if it is installed.

A program is a template of `snippets` with the numbers of a campaign below it, and needs nothing of freerock.
It holds θ(t) of the law it stands for, as freerock solves it, and prints how far the engine is from it.

example:
  freerock export palermo_virtual --to drake --python .venv-peers/bin/python

Writes a program for each block and foundation, which needs the engine but not freerock.
Its head states the law and, if the engine is installed, ε_θ between engine and law.
"""

import json
import math
import os
import re
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.config.campaign import Campaign, load_config
from freerock.errors import FreerockError
from freerock.files import write_text

if TYPE_CHECKING:
    import pandas as pd

    from freerock.arrays import Floats

SNIPPETS = Path(__file__).with_name("snippets")
PEERS = Path(".venv-peers/bin/python")  # as `make peers` sets it up in a checkout
SPAN_S, EVERY_S = 3.0, 0.01  # of the motion compared
LONGEST_S = 600.0  # of a program
STATED_EPSILON = re.compile(r"^epsilon_theta ([\d.e+-]+)$", re.M)


@dataclass(frozen=True)
class Engine:
    """An engine, the law that it solves, and its setting.

    Parameters
    ----------
    name : str
        As printed.
    law, debonding : str
        What its contacts are: a foundation's law and the rule of contact.
    how : str
        What stands for the bed.
    setting : dict
        As the snippet takes it.
    """

    name: str
    law: str
    debonding: str
    how: str
    setting: dict[str, float]


ENGINES = {
    "opensees": Engine(
        "OpenSees", "winkler", "geometric", "gap springs with dashpots", {"springs": 100, "step_s": 5e-4}
    ),
    "drake": Engine(
        "Drake",
        "hunt_crossley",
        "tensionless",
        "points of Hunt and Crossley's contact, dissipation λ/k",
        {"points": 200, "rtol": 1e-6},
    ),
    "mujoco": Engine(
        "MuJoCo", "winkler", "tensionless", "strips of soft contacts", {"strips": 100, "step_s": 5e-4}
    ),
}


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="NAME", help="an analysed campaign")
    add("--to", required=True, choices=[*ENGINES], help="the engine")
    add("--into", metavar="FOLDER", help="by default exports/NAME")
    add("--python", metavar="FILE", help="a Python that has the engine; by default .venv-peers or this one")


def run(chosen: Namespace) -> None:
    """Write the programs, run each, and print ε_θ."""
    import numpy as np

    from freerock.tables.csvfile import read_csv

    name, engine = chosen.campaign, ENGINES[chosen.to]
    campaign = load_config(campaigns=[name]).campaigns[name]
    tables = Path("results", name, "tables")
    if not (tables / "populations.csv").exists():
        raise FreerockError(tables, "holds no populations.csv", f"run snakemake --config campaigns={name}")
    read = {each: read_csv(tables / f"{each}.csv") for each in ("populations", "choice", "runs")}
    python = Path(chosen.python) if chosen.python else PEERS if PEERS.exists() else Path(sys.executable)
    folder = Path(chosen.into or f"exports/{name}")
    written = 0
    for scene in scenes(campaign, engine, read):
        path = folder / f"{scene.block}_{scene.foundation}_{chosen.to}.py"
        if not campaign.blocks[scene.block].block.is_uniform:
            print(f"{path}: left out: no program takes a stated centre of mass or inertia", file=sys.stderr)
            continue
        if not np.isfinite(_solved(campaign, engine, scene)[0]).all():
            print(f"{path}: left out: the block overturns under this law", file=sys.stderr)
            continue
        folder.mkdir(parents=True, exist_ok=True)
        write_text(path, program(campaign, chosen.to, scene, "not measured: this file was not run"))
        found = measured(path, python)
        write_text(path, program(campaign, chosen.to, scene, found))
        print(f"{path}: ε_θ {found}")
        written += 1
    if not written:
        what = f"no mean of the law {engine.law} in populations.csv, which {engine.name} solves"
        raise FreerockError(tables, what, "add the law to fits.models, or take another engine")


@dataclass(frozen=True)
class ExportedScene:
    """A block on a foundation, its law, and where its numbers come from.

    Parameters
    ----------
    values, u_total : mapping
        Parameters of the law and their total standard uncertainties, SI.
    theta0 : float
        Angle of release [rad].
    source : str
        Whose mean the values are.
    """

    block: str
    foundation: str
    values: Mapping[str, float]
    u_total: Mapping[str, float]
    theta0: float
    source: str


def scenes(
    campaign: Campaign, engine: Engine, tables: Mapping[str, "pd.DataFrame"]
) -> Iterator[ExportedScene]:
    """Each block on each foundation of a campaign, as far as the engine's law has a mean there.

    The mean over all blocks on a foundation comes before that of a record.
    """
    means = tables["populations"].query("model == @engine.law")
    for block, foundation in dict.fromkeys((each.block, each.foundation) for each in campaign.records):
        on = means[means["foundation"] == foundation]
        own = on[on["level"] == "foundation"]
        if own.empty:
            own = on[(on["level"] == "record") & (on["block"] == block)]
            own = own[own["test"] == own["test"].iloc[0]] if len(own) else own
        runs = tables["runs"].query("block == @block and foundation == @foundation")
        angle = runs["theta0_deg"].abs().median()
        if own.empty or not math.isfinite(angle):
            continue
        chosen = tables["choice"].query("foundation == @foundation and status == 'selected'")
        first = own.iloc[0]
        source = (
            f"mean of {first['n_runs']} runs of {first['n_records']} records on {foundation}; "
            f"the law is the choice of {(chosen['model'] == engine.law).sum()} of {len(chosen)} runs there"
        )
        values = dict(zip(own["parameter"], own["mean"].astype(float), strict=True))
        u_total = dict(zip(own["parameter"], own["u_total"].astype(float), strict=True))
        yield ExportedScene(block, foundation, values, u_total, math.radians(float(angle)), source)


def program(campaign: Campaign, to: str, scene: ExportedScene, epsilon: str) -> str:
    """Text of a program for an engine."""
    from jinja2 import StrictUndefined, Template

    from freerock.models.contact import Foundation, static_depth

    engine, block = ENGINES[to], campaign.blocks[scene.block].block
    theta, other = _solved(campaign, engine, scene)
    numbers = {name: scene.values.get(name, 0.0) for name in ("k", "c", "lambda")}
    numbers |= {"b": block.b, "h": block.h, "m": block.mass_kg, "g": block.g, "theta0": scene.theta0}
    numbers["z0"] = static_depth(block, Foundation.of(scene.values), scene.theta0)
    numbers |= {"until_s": SPAN_S, "every_s": EVERY_S}
    text = Path(__file__).with_name("program.py.j2").read_text(encoding="utf-8")
    made: str = Template(
        text, trim_blocks=True, keep_trailing_newline=True, undefined=StrictUndefined
    ).render(
        campaign=campaign,
        engine=engine,
        scene=scene,
        degrees=math.degrees(scene.theta0),
        span_s=SPAN_S,
        epsilon=epsilon,
        other=other,
        snippet=_template(to),
        numbers=json.dumps(numbers, indent=4),
        setting=json.dumps(engine.setting),
        theta=json.dumps([float(f"{value:.9g}") for value in theta]),
    )
    return made


def _template(to: str) -> str:
    """The template of an engine with the functions that it shares with others."""
    shared = (SNIPPETS / "common.py").read_text(encoding="utf-8").split('"""\n', 1)[1]
    text = (SNIPPETS / f"to_{to}.py").read_text(encoding="utf-8")
    head, mark, after = re.sub(r"^from common import .*\n", "", text, flags=re.M).partition("\n\ndef ")
    return f"{head.rstrip()}\n\n\n{shared.strip()}\n{mark}{after}".rstrip() + "\n"


def _solved(campaign: Campaign, engine: Engine, scene: ExportedScene) -> tuple["Floats", float]:
    """θ(t) of the law under the engine's rule, and ε_θ of the rule of the fits against it."""
    import numpy as np

    from freerock.identification.epsilon_theta import epsilon_theta
    from freerock.models.laws import Rules
    from freerock.models.simulate import Solver, simulate_theta

    time = np.arange(0.0, SPAN_S + 0.5 * EVERY_S, EVERY_S)
    block = campaign.blocks[scene.block].block
    rules = [Rules(rule) for rule in (engine.debonding, campaign.fits.debonding)]
    given = engine.law, block, scene.values, time
    tight = Solver(1e-10)
    found = [simulate_theta(*given, theta0=scene.theta0, rules=each, solver=tight)[0] for each in rules]
    return found[0], float(epsilon_theta(time, found[1], found[0]))


def measured(path: Path, python: Path) -> str:
    """What a program prints of its distance from the law, or why nothing."""
    try:
        done = subprocess.run(
            [python, path], env=environment(python), capture_output=True, text=True, timeout=LONGEST_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"not measured: {error}"
    found = STATED_EPSILON.search(done.stdout)
    if found and not done.returncode:
        return f"{float(found[1]):.2g}, measured"
    why = (done.stderr.strip().rpartition("\n")[2] or "it ended without an answer").rstrip(".")
    return f"not measured: {why}"


def environment(python: Path) -> dict[str, str]:
    """Variables for an engine: OpenSees' wheel has its libraries, but not where they look for each other."""
    inside = sorted(python.parents[1].glob("lib/python*/site-packages/openseespylinux/lib"))
    return os.environ | {"LD_LIBRARY_PATH": ":".join(map(str, inside))}
