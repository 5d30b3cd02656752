"""Speed against accuracy of the tools of a laboratory, and what their errors do to an identification.

Configuration 2 on marble (Spanos et al. 2017, doi:10.1016/j.proeng.2017.09.024), released from 10°, by every
law. Each tool is compared with the golden solution of the law that it solves: where it knows the tensionless
rule only, with that. A laser gives the scale: σ_θ = 0.01°, 2 kHz. Engines of other fields are asked where
`make peers` has set them up.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from freerock.arrays import Floats
from freerock.config.yaml_lines import Yaml12
from freerock.errors import FreerockError
from freerock.models.laws import LAWS, MODEL_LABELS, MODELS, Rules
from freerock.models.simulate import Solver, simulate_fitted
from freerock.virtual_lab.published import BLOCKS, PUBLISHED_BLOCK, RELEASE_ANGLES, TABLE_2
from freerock_bench import peers
from freerock_bench.document import in_markdown
from freerock_bench.golden.files import read_golden
from freerock_bench.methods.by_name import METHODS
from freerock_bench.methods.housner import housner_eventless
from freerock_bench.methods.problem import NOISE_RAD, SAMPLING_HZ, Problem, Solution, errors, solution
from freerock_bench.timing import interleaved

SEED = 0
EVERY_S = 0.01  # between the instants compared
SPAN_S = {"full": 3.0, "small": 0.6}
ROUNDS = {"full": 5, "small": 1}
COLUMNS = ["model", "debonding", "method", "kind", "setting", "time_s", "epsilon", "max_error_rad", "outcome"]
COLUMNS += ["floor_epsilon", "parameter", "error_stderr", "note"]
HEADS = ["law", "tool", "setting", "a run of 3 s", "ε_θ", "over the noise", "error / standard errors", "note"]
UNITS = ((3600.0, "h"), (60.0, "min"), (1.0, "s"), (1e-3, "ms"))
Row = dict[str, Any]


STATED = yaml.load(Path(__file__).with_name("engines.yaml").read_bytes(), Yaml12)
TOOLS = METHODS | {"Runge–Kutta without events": housner_eventless}


def problem_of(model: str, debonding: str) -> Problem:
    """Configuration 2 on marble under a law."""
    block = BLOCKS[PUBLISHED_BLOCK]
    law = TABLE_2["marble"][model]
    return Problem(model, block, law, RELEASE_ANGLES[PUBLISHED_BLOCK], debonding or "geometric")


def run(size: str, folder: Path, cores: int) -> pd.DataFrame:
    """Time and error of every tool.

    Returns
    -------
    pandas.DataFrame
        Columns model, debonding (the law that the tool is compared with), method, kind ("freerock",
        "library", "time stepping", "engine"), setting, time_s (of a run), epsilon, max_error_rad, outcome;
        floor_epsilon (ε_θ of the laser's noise alone); parameter (r or k) and error_stderr, its shift in a
        fit whose simulations err as this one, in standard errors; note.

    Raises
    ------
    FreerockError
        The engines are not there, and the size is full.
    """
    if size == "full" and not peers.installed():
        raise FreerockError(peers.PYTHON, "the engines are not installed", "run make peers")
    time = np.arange(0.0, SPAN_S[size] + 0.5 * EVERY_S, EVERY_S)
    rows: list[Row] = []
    for model in ("housner", "winkler", "hunt_crossley"):
        problem = problem_of(model, "geometric")
        scale = Scale(problem, time)
        cases = list(_own(problem, size))
        for *_, call in cases:
            call(problem, time[:3])  # compiled before it is timed
        calls = [partial(call, problem, time) for *_, call in cases]
        timed = interleaved(calls, ROUNDS[size], 2.0, in_a_row=3)  # caches as in a fit, for all alike
        for (name, kind, setting, note, _), (found, seconds, _) in zip(cases, timed, strict=True):
            rows.append(_row(scale, name, kind, setting, note, found, seconds))
    if peers.installed():
        for engine in STATED["engines"]:
            rows += _asked(engine, size, time)
    return pd.DataFrame(rows, columns=COLUMNS)


def _own(problem: Problem, size: str) -> Iterator[tuple[str, str, str, str, Callable[..., Solution]]]:
    """Name, kind, setting, note and call of what runs without other engines."""
    for tool in STATED["tools"]:
        if tool.get("rigid", False) != (problem.model == "housner"):
            continue
        name, kind = tool["name"], tool["kind"]
        method = TOOLS[tool.get("method", name)]
        for value in tool["settings"][size]:
            setting = f"step {1e3 * value:g} ms" if kind == "time stepping" else f"rtol {value:g}"
            setting = tool.get("said", {}).get(value, setting)
            yield name, kind, setting, tool.get("note", ""), partial(_by_step, method, value)


def _by_step(method: Callable[..., Solution], value: float, problem: Problem, time: Floats) -> Solution:
    return method(problem, time, value)


def _asked(engine: dict[str, Any], size: str, time: Floats) -> Iterator[Row]:
    """Rows of an engine of another field."""
    problem = problem_of(engine["model"], engine["debonding"])
    if engine["driver"] == "mujoco_box":
        problem = replace(problem, parameters={"r": problem.block.restitution_housner})
    every = [(grid, values) for grid in engine["settings"][size] for values in product(*grid.values())]
    settings = [dict(zip(grid, values, strict=True)) for grid, values in every]
    answers = peers.solve(engine["driver"], problem, settings, time, ROUNDS[size])
    scale = Scale(problem, time)
    for setting, answer in zip(settings, answers, strict=True):
        found = solution(problem, time, answer.theta, math.nan, not answer.message)
        if answer.message:
            found = replace(found, outcome=answer.message)
        text = ", ".join(_worded(name, value) for name, value in setting.items())
        yield _row(scale, engine["name"], "engine", text, engine["note"], found, answer.seconds)


def _worded(name: str, value: float) -> str:
    if name.endswith("_s"):
        return f"{name.removesuffix('_s').replace('_', ' ')} {1e3 * value:g} ms"
    words = {"rtol": "rtol {:g}", "alpha": "HHT with α {:g}"}
    return words.get(name, f"{{:g}} {name}").format(value)


class Scale:
    """What an error of θ(t) means: against noise, and for a parameter fitted."""

    def __init__(self, problem: Problem, time: Floats) -> None:
        """The solution, and its derivatives at tight tolerance."""
        self.problem, self.time = problem, time
        self.true = self._golden()
        self.floor = NOISE_RAD**2 * time.size / float(self.true @ self.true)
        self.names = (*MODELS[problem.model], "theta0")
        columns = []
        for name in self.names:
            value = problem.parameters.get(name, problem.theta0)
            step = 1e-5 * abs(value)
            columns.append(
                (self._theta({name: value + step}, 0) - self._theta({name: value - step}, 0)) / (2 * step)
            )
        columns.append((self._theta({}, 1e-6) - self._theta({}, -1e-6)) / 2e-6)
        self.jacobian = np.stack(columns, axis=1)

    def _golden(self) -> Floats:
        """The golden solution; with another r, which has none, the closed form."""
        problem = self.problem
        if problem.parameters != TABLE_2["marble"][problem.model]:
            return self._theta({}, 0.0)
        rules = "" if problem.model == "housner" else f"{problem.debonding}_guided_"
        name = f"{PUBLISHED_BLOCK}_marble_{problem.model}_{rules or 'pivoting_'}free"
        return read_golden()[name].theta_rad[: self.time.size]

    def stderrs(self, error: Floats) -> float:
        """Shift of the first parameter, to first order, by an error of the simulation, in standard errors."""
        inverse = np.linalg.pinv(self.jacobian)
        # the samples compared are fewer than those of a record
        stderr = NOISE_RAD * math.sqrt(1 / (EVERY_S * SAMPLING_HZ)) * float(np.linalg.norm(inverse[0]))
        return abs(float(inverse[0] @ error)) / stderr

    def _theta(self, other: Mapping[str, float], later_s: float) -> Floats:
        problem = self.problem
        values = {**problem.parameters, "theta0": problem.theta0, **other}
        theta = simulate_fitted(
            problem.model,
            problem.block,
            {**{name: values[name] for name in MODELS[problem.model]}, "theta0": values["theta0"]},
            self.time - later_s,
            rules=Rules(problem.debonding),
            solver=Solver(1e-12),
        )
        return theta


def _row(scale: Scale, name: str, kind: str, setting: str, note: str, found: Solution, seconds: float) -> Row:
    epsilon, largest = errors(found.theta, scale.true)
    completed = found.outcome == "completed"
    return {
        "model": scale.problem.model,
        "debonding": "" if scale.problem.model == "housner" else scale.problem.debonding,
        "method": name,
        "kind": kind,
        "setting": setting,
        "time_s": seconds,
        "epsilon": epsilon,
        "max_error_rad": largest,
        "outcome": found.outcome,
        "floor_epsilon": scale.floor,
        "parameter": MODELS[scale.problem.model][0],
        "error_stderr": scale.stderrs(found.theta - scale.true) if completed else math.nan,
        "note": note,
    }


def markdown(frame: pd.DataFrame) -> str:
    """Rows of Markdown: of every tool its cheapest setting that errs less than a laser, else its best."""
    lines = []
    by_law = frame.sort_values("model", key=lambda model: model.map([*LAWS].index), kind="stable")
    for (model, method), rows in by_law.groupby(["model", "method"], sort=False):
        done = rows[rows["outcome"] == "completed"]
        if done.empty:
            lines.append([MODEL_LABELS[model], method, f"none: {rows['outcome'].iloc[0]}", *[""] * 5])
            continue
        enough = done[done["epsilon"] < done["floor_epsilon"]]
        row = (enough.sort_values("time_s") if len(enough) else done.sort_values("epsilon")).iloc[0]
        over = row["epsilon"] / row["floor_epsilon"]
        cells = [
            MODEL_LABELS[model],
            method,
            row["setting"],
            _seconds(row["time_s"]),
            f"{row['epsilon']:.0e}",
            f"**{over:.1g} ×**" if over >= 1 else f"{over:.0e} ×" if over < 0.01 else f"{over:.2g} ×",
            f"{row['error_stderr']:.2g} of {row['parameter']}",
            row["note"] if isinstance(row["note"], str) else "",
        ]
        lines.append(cells)
    return in_markdown(HEADS, lines)


def _seconds(value: float) -> str:
    size, unit = next((each for each in UNITS if value >= each[0]), UNITS[-1])
    return f"{value / size:.{0 if value >= 10 * size else 1}f} {unit}"
