"""Inputs drawn from their own uncertainty: is the truth still named, are the numbers as certain as told?

Records of `integrated`, which share nothing with the laws that are fitted, go as volts the whole way to
verdict and fits. Block, laser and clock are off by normal draws of what is stated of them: by callipers, by a
rule, or exact. In two further parts the corners are worn, or the base is off level, beyond that.

    python -m freerock_bench.drawn results/studies/drawn.csv full docs/validation.md

measures (`small`: two records of each part, instruments and kinematics; `full`: 36 and 18, in half an hour of
processor time; `long`: 1 200 and 600, in a night) and renews the tables in the documentation, where it is
named.
"""

import math
import sys
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.config.defaults import FitSettings
from freerock.errors import FreerockError
from freerock.identification.fit import Fit
from freerock.identification.inputs_with_priors import at_end
from freerock.identification.levels import NORMAL_95
from freerock.identification.start import posed
from freerock.models.laws import CANDIDATES, LAWS, Candidate
from freerock.models.published import TABLE_2
from freerock.rotation.laboratory import Laboratory
from freerock.runs.motion import Motion
from freerock.selection.allowed_hypotheses import BY_DEFAULT
from freerock.selection.choice import Choice
from freerock.virtual_lab.palermo import CONFIGURATIONS
from freerock_bench.analysed import Analysed, analysed
from freerock_bench.document import in_markdown
from freerock_bench.harness import Study, rows_of_fit
from freerock_bench.integrated import Scene, Truth, recorded
from freerock_bench.truths import laboratory_of, place
from freerock_bench.virtual_run import SEED, Row, converted, correlated

INSTRUMENTS = {  # standard uncertainties, of the mass by its share
    "caliper": {"height_m": 3e-5, "width_m": 3e-5, "mass_kg": 2e-4, "position_m": 2e-4},
    "rule": {"height_m": 3e-4, "width_m": 3e-4, "mass_kg": 1e-3, "position_m": 6e-4},
}
INSTRUMENTS["caliper"] |= {"scale_fraction": 5e-4, "sampling_rate_fraction": 2e-5}
INSTRUMENTS["rule"] |= {"scale_fraction": 1e-3, "sampling_rate_fraction": 6e-5}
RATE_HZ = 1000.0
SIGMA_V, COUNT_V = 2e-3, 20.0 / 2**24
SLOW, SLOW_S, SLOW_OF = 0.25, 0.05, 4  # share of slow noise, its time, and every how manieth record has it
SCATTER, ANGLES = 0.1, (0.6, 1.0)
DAMPED = (1.0, 1.5)  # times the damping of table 2: of a rigid block the power of its r
LEVELLED_DEG = 0.02  # of the foundation, in all records whose inputs are not exact
BEYOND = (3.0, 10.0)  # standard uncertainties by which corners are worn and the base is off level
TURNS = ("hunt_crossley", "winkler", "housner")  # laws in turn; a round of scenes of each
KINEMATICS = ("guided", "pivoting")
PARTS = {  # records of each instruments and kinematics in a part, over its share of the size
    "drawn": 1.0,
    "exact": 0.5,
    "worn": 0.5,
    "tilted": 0.5,
}
SIZES = {"small": 2, "full": 36, "long": 1200}  # of each instruments and kinematics; eighteen make a round
CAUSES = {"worn": "width_m", "tilted": "levelled_deg"}
NAMES = ("k", "c", "lambda", "r")
INPUTS = ("height_m", "width_m", "position_m", "scale_fraction", "sampling_rate_fraction", "levelled_deg")
COLUMNS = ["part", "instruments", "kinematics", "law", "block", "foundation", "record", "beyond"]
COLUMNS += ["expected", "level", "names", "truth", "selected", "explained", "named", "held", "cause"]
COLUMNS += [f"{name}_{what}" for name in NAMES for what in ("z", "z_stderr", "error")]
COLUMNS += [f"pull_{name}" for name in INPUTS]
OUTCOMES = ("named", "in the set", "not explained", "warned, truth excluded", "ok, truth excluded")
MARK = ("<!-- drawn -->\n", "<!-- end of the drawn -->\n")


def cases(n: int) -> list[tuple[str, str, str, int]]:
    """Part, instruments, kinematics and number of each record."""
    return [
        (part, instruments, kinematics, i)
        for i in range(n)
        for part, share in PARTS.items()
        for instruments in (["exact"] if part == "exact" else INSTRUMENTS)
        for kinematics in KINEMATICS
        if i < max(2, math.ceil(share * n))
    ]


def rows_of(case: tuple[str, str, str, int]) -> list[Row]:
    """The row of one record.

    part, instruments, kinematics, law, block, foundation, record; beyond (standard uncertainties by which
    corners or base are off); expected (the pull that this makes, as far as the noise lets it be seen); level
    and names of the verdict; truth, the candidate that holds it; selected, explained; named (the truth is),
    held (it is named or also possible); cause (worn corners or tilt are told); of each parameter under the
    candidate that is named the error over u_total, over stderr, and relative; the pull of each input in the
    fit of the truth.
    """
    part, instruments, kinematics, i = case
    draw = np.random.default_rng([SEED, zlib.crc32(f"{part} {instruments} {kinematics}".encode()), i])
    (configuration, foundation), law = place(i), TURNS[i // 6 % len(TURNS)]
    stated = stated_laboratory(configuration, instruments)
    true = stated.at(stated.inputs, draw.standard_normal(len(stated.inputs)))
    beyond = float(draw.uniform(*BEYOND)) if part in ("worn", "tilted") else 0.0
    truth, parameters = true_record(true, stated, (law, kinematics, foundation), (part, beyond), draw)
    own = kinematics if kinematics in LAWS[law].kinematics else LAWS[law].kinematics[0]
    candidate = Candidate(law, own, part == "worn").name
    row: Row = {"part": part, "instruments": instruments, "kinematics": kinematics, "law": law}
    row |= {"block": configuration, "foundation": foundation, "record": i, "beyond": beyond}
    row["truth"] = candidate
    volts = measured(truth, i, draw)
    (laser,) = stated.lasers.values()
    time_s = np.arange(len(volts)) / RATE_HZ
    try:
        result = analysed(time_s, volts, laser, stated.block, laboratory=stated)
    except FreerockError as error:
        return [row | {"level": "fail", "names": str(error.what), "named": False, "held": False}]
    return [row | judged(result, candidate, parameters, part, beyond)]


def stated_laboratory(configuration: str, instruments: str) -> Laboratory:
    """What is stated of a block of table 1 and its laser."""
    u = dict(INSTRUMENTS.get(instruments) or dict.fromkeys(INSTRUMENTS["rule"], 0.0))
    block, _, laser = CONFIGURATIONS[configuration]
    u["mass_kg"] *= block.mass_kg
    if instruments in INSTRUMENTS:
        u["levelled_deg"] = LEVELLED_DEG / math.sqrt(3)
    return laboratory_of(configuration, block, laser, u)


def true_record(
    true: Laboratory, stated: Laboratory, place: tuple[str, str, str], off: tuple[str, float], draw: Any
) -> tuple[Truth, dict[str, float]]:
    """A record of the true laboratory, and the true parameters."""
    (law, kinematics, foundation), (part, beyond) = place, off
    block, (laser,) = true.block, true.lasers.values()
    u = {each.name: each.u for each in stated.inputs}
    b, tilt, angle = block.width_m / 2, true.tilt, _angle(stated)
    if part == "worn":
        b -= beyond * u["width_m"] / 2
    if part == "tilted":
        tilt = math.radians(beyond * u["levelled_deg"]) * draw.choice([-1, 1])
    soil, damped = dict(TABLE_2[foundation][law]), draw.uniform(*DAMPED)
    if law == "housner":
        soil["r"] **= damped
    else:
        soil["k"] *= draw.uniform(1 - SCATTER, 1 + SCATTER)
        soil[LAWS[law].ratios[0]] *= damped
    scene = Scene(
        block,
        b,
        (soil.get("k", 0.0), soil.get("c", 0.0), soil.get("lambda", 0.0)),
        kinematics == "pivoting",
        angle * draw.uniform(*ANGLES) * draw.choice([-1, 1]),
        draw.uniform(3e-3, 12e-3),
        round(draw.uniform(1.5, 2.5), 3),
        soil.get("r", math.nan),
        tilt,
    )
    truth = recorded(scene, laser, RATE_HZ / true.clock)
    zero = truth.volts[0]
    return replace(truth, volts=zero + (truth.volts - zero) / true.scales[0]), soil


def _angle(stated: Laboratory) -> float:
    return next(angle for block, angle, _ in CONFIGURATIONS.values() if block == stated.block)


def measured(truth: Truth, i: int, draw: Any) -> Floats:
    """Volts with noise, through a converter of 24 bits."""
    n = len(truth.volts)
    noise = draw.standard_normal(n)
    if i % SLOW_OF == 0:
        noise = noise + SLOW * correlated(n, SLOW_S, RATE_HZ, draw)
    return converted(truth.volts + SIGMA_V * noise, COUNT_V, draw)


def judged(
    result: Analysed, candidate: str, parameters: dict[str, float], part: str, beyond: float = 0.0
) -> Row:
    """What is said of a record, against its truth."""
    verdict, found, motion = result
    row: Row = {"level": verdict.level, "names": " ".join(verdict.names), "named": False, "held": False}
    if motion is None or not found.fits:
        return row | {"selected": "", "explained": False}
    choice = found.choice(BY_DEFAULT)
    possible = (choice.selected, *choice.also_possible) if choice.explained else ()
    row |= {"selected": choice.selected, "explained": choice.explained}
    row |= {"named": candidate in possible[:1], "held": candidate in possible}
    row["cause"] = _is_told(part, result, choice)
    if part in CAUSES:
        model = replace(CANDIDATES[candidate], width=False).name
        row["expected"] = beyond * _seen(model, parameters, motion, CAUSES[part])
    if choice.selected:
        row |= _errors(found.fits[choice.selected], parameters)
    if candidate in found.fits:
        row |= _pulls(found.fits[candidate])
    return row


def _seen(model: str, parameters: dict[str, float], motion: Motion, name: str) -> float:
    """Pull of an input that is off by one of its standard uncertainties, as the noise lets it be seen."""
    assert motion.laboratory is not None
    problem = posed(model, (motion.laboratory.block,), (motion,), FitSettings())
    best = at_end(problem, parameters, None)
    n, at = int(best.free.sum()), [each.name for each in best.nuisances.sources].index(name)
    rows = np.vstack([best.whitened.rows[:, 1:], best.prior[1]])
    scale = np.linalg.norm(rows, axis=0)
    covariance = np.linalg.pinv((rows / scale).T @ (rows / scale), hermitian=True)
    return math.sqrt(max(1 - covariance[n + at, n + at] / scale[n + at] ** 2, 0.0))


def _is_told(part: str, result: Analysed, choice: Choice) -> bool:
    """Whether worn corners, or the tilt, are named: freed, or by a note on the input."""
    notes = " ".join(result.verdict.texts)
    if part == "worn" and choice.selected and CANDIDATES[choice.selected].width:
        return True
    return (part == "tilted" and "tilt" in result.found.widened) or CAUSES.get(part, "-") in notes


def _errors(fit: Fit, parameters: dict[str, float]) -> Row:
    row: Row = {}
    for each in rows_of_fit("", fit, parameters):
        name, off = each["parameter"], each["value"] - each["truth"]
        row |= {f"{name}_z": off / each["u"], f"{name}_z_stderr": off / each["stderr"]}
        row[f"{name}_error"] = off / each["truth"]
    return row


def _pulls(fit: Fit) -> Row:
    known = fit.contributions
    if known is None:
        return {}
    both = zip(known.inputs, known.pulls.tolist(), strict=True)
    return {f"pull_{each.name}": pull for each, pull in both if each.name in INPUTS}


def pulls_of(frame: pd.DataFrame) -> Floats:
    """Pulls of all inputs of the records whose inputs are drawn, and nothing else is wrong."""
    columns = [f"pull_{name}" for name in INPUTS]
    found = frame.loc[frame["part"] == "drawn", columns].to_numpy(float).ravel()
    return np.asarray(found[np.isfinite(found)])


def told(frame: pd.DataFrame) -> pd.DataFrame:
    """Of each part, instruments and kinematics: how many records, and the share of each `OUTCOMES`."""
    rows = []
    for key, own in frame.groupby(["part", "instruments", "kinematics"], sort=False):
        row: Row = dict(zip(("part", "instruments", "kinematics"), key, strict=True)) | {"n": len(own)}
        ok, held, named = own["level"] == "ok", own["held"].astype(bool), own["named"].astype(bool)
        explained = own["explained"].fillna(False).astype(bool)
        row |= {"named": named.mean(), "in the set": (held & ~named).mean()}
        row |= {"not explained": (~explained & ~held).mean()}
        row |= {"warned, truth excluded": (explained & ~held & ~ok).mean()}
        row |= {"ok, truth excluded": (explained & ~held & ok).mean()}
        row["cause"] = own["cause"].fillna(False).astype(bool).mean()
        for name in NAMES:
            z = own[f"{name}_z"].astype(float).dropna()
            row |= {f"{name}_n": len(z), f"{name}_inside": (z.abs() < NORMAL_95).sum()}
            row |= {f"{name}_square": float(z @ z)}
        rows.append(row)
    return pd.DataFrame(rows)


def markdown(frame: pd.DataFrame) -> str:
    """What is named and covered by part, and the pulls by input."""
    heads = ["part", "instruments", "kinematics", "records", "truth named", "in the set", "none explains"]
    heads += ["truth excluded: warned", "ok", "cause named", "k", "c, λ", "r", "r.m.s. z"]
    named, pulled = list[list[object]](), list[list[object]]()
    for row in told(frame).to_dict("records"):
        cells = [row["part"], row["instruments"], row["kinematics"], row["n"]]
        cells += [f"{100 * row[name]:.0f} %" for name in OUTCOMES]
        cells += [f"{100 * row['cause']:.0f} %" if row["part"] in ("worn", "tilted") else ""]
        for names in (("k",), ("c", "lambda"), ("r",)):
            inside, n = (sum(row[f"{name}_{what}"] for name in names) for what in ("inside", "n"))
            cells.append(f"{inside} of {n}" if n else "")
        n = sum(row[f"{name}_n"] for name in NAMES)
        rms = math.sqrt(sum(row[f"{name}_square"] for name in NAMES) / n) if n else math.nan
        named.append([*cells, f"{rms:.2f}"])
    drawn = frame[frame["part"] == "drawn"]
    columns = {name: drawn[f"pull_{name}"].astype(float).dropna().to_numpy() for name in INPUTS}
    for name, pulls in (columns | {"all": pulls_of(frame)}).items():
        if len(pulls):
            beyond = [f"{100 * np.mean(np.abs(pulls) > limit):.1f} %" for limit in (2, 3)]
            pulled.append([name, len(pulls), f"{np.mean(pulls):+.2f}", f"{np.std(pulls):.2f}", *beyond])
    of_pulls = in_markdown(["pull of", "n", "mean", "s.d.", "beyond 2", "beyond 3"], pulled)
    return "\n".join(["", in_markdown(heads, named), "", of_pulls, "", ""])


STUDY = Study(lambda size: cases(SIZES[size]), rows_of, COLUMNS, MARK, markdown)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
