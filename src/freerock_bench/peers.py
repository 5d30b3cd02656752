"""Engines of other fields, each in a process of the environment that `make peers` sets up.

A driver in `benchmarks/peers` takes cases and answers with θ(t) and the best time of its runs.
"""

import json
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import GRAVITY
from freerock_bench.methods.problem import Problem

ROOT = Path(__file__).parents[2]  # of this package's checkout
DRIVERS = ROOT / "benchmarks/peers"
PYTHON = ROOT / ".venv-peers/bin/python"
LONGEST_S = 600.0  # of a driver with all its cases


class Answer(NamedTuple):
    """θ at the instants [rad], empty after a failure; best time of a run [s]; what the engine said."""

    theta: Floats
    seconds: float
    message: str


def installed() -> bool:
    """Whether `make peers` was run."""
    return PYTHON.exists() and DRIVERS.exists()


def solve(
    driver: str, problem: Problem, settings: Sequence[dict[str, Any]], time: Floats, rounds: int
) -> list[Answer]:
    """A problem by an engine, once for each setting.

    Parameters
    ----------
    driver : str
        A module of `benchmarks/peers`.
    problem : Problem
    settings : sequence of dict
        As the driver takes them.
    time : ndarray, shape (n_time,)
        Instants from 0 on, evenly spaced [s].
    rounds : int
        Most runs of each; one that takes longer than 2 s is not repeated.
    """
    block, parameters = problem.block, problem.parameters
    scene = {name: parameters.get(name, 0.0) for name in ("k", "c", "lambda")} | {
        "b": block.b,
        "h": block.h,
        "m": block.mass_kg,
        "g": GRAVITY,
        "theta0": problem.theta0,
        "z0": float(problem.start[0]) if parameters.get("k") else 0.0,
        "until_s": float(time[-1]),
        "every_s": float(time[1] - time[0]),
    }
    cases = [{"scene": scene, "setting": setting, "rounds": rounds} for setting in settings]
    done = subprocess.run(
        [PYTHON, DRIVERS / f"{driver}.py"],
        input=json.dumps(cases),
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        env=environment(PYTHON),
    )
    if not done.stdout:
        why = done.stderr.strip().rpartition("\n")[2] or "it ended without an answer"
        return [Answer(np.empty(0), np.nan, why)] * len(cases)
    return [
        Answer(np.array(each.get("theta", [])), each.get("seconds", np.nan), each.get("error", ""))
        for each in json.loads(done.stdout)
    ]


def environment(python: Path) -> dict[str, str]:
    """Variables for an engine: OpenSees' wheel has its libraries, but not where they look for each other."""
    inside = sorted(python.parents[1].glob("lib/python*/site-packages/openseespylinux/lib"))
    return os.environ | {"LD_LIBRARY_PATH": ":".join(map(str, inside))}
