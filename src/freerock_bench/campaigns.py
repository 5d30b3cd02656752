"""Records of known truth, analysed as a campaign by the workflow, and its tables held against their truth.

Each record is a .npz as `scattered.save` writes it: volts; what is stated of block and laser, with its
uncertainty; what is true. It stands on a foundation of its own, so that nothing is shared between records.
"""

import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.significance_levels import NORMAL_95
from freerock.models.laws import Candidate
from freerock.tables.csvfile import read_csv, write_csv
from freerock_bench.document import in_markdown, renew

ROOT = Path(__file__).parents[2]
TABLES = ("runs", "reasons", "choice", "parameters", "restitution", "populations", "predictions", "epsilon")
SAME_RUN_S, SAME_IMPACT_S = 0.5, 0.02
COLUMNS = ["case", "parameter", "truth", "value", "stderr", "u", "inside", "test", "run", "law", "kinematics"]
COLUMNS += ["block", "foundation", "note"]
"""A row per case and number: truth, value, stderr (of the noise), u (with all else that is known) [SI];
whether the 95 % interval holds the truth. Of a question with yes and no, `inside` is the answer."""
Row = dict[str, Any]
Tables = Mapping[str, pd.DataFrame]


def analysed(folder: Path, records: Mapping[str, Path], cores: int = 1) -> Tables:
    """Tables of a campaign of records, by its workflow in a folder of its own; what is there is kept.

    Parameters
    ----------
    folder : Path
    records : mapping of str to Path
        By the name of the test.
    cores : int
    """
    _write(folder, records)
    targets = [f"results/bench/tables/{name}.csv" for name in TABLES]
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--directory", folder]
    command += ["--profile", ROOT / "profiles/default", "--cores", str(cores), *targets]
    done = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stdout[-3000:] + done.stderr[-3000:])
    return {name: read_csv(folder / target) for name, target in zip(TABLES, targets, strict=True)}


def _write(folder: Path, records: Mapping[str, Path]) -> None:
    """Configuration and record files; those that are there as they would be written stay untouched."""
    parts: dict[str, dict[str, Any]] = {"blocks": {}, "foundations": {}, "lasers": {}}
    lines = ["test,file,channel,block,foundation,laser,exclude,override,reason,note"]
    for test, path in records.items():
        record = np.load(path)
        known = {name.removeprefix("u_"): float(record[name]) for name in record if name.startswith("u_")}
        known["mass_kg"] = known.pop("mass") * float(record["stated_mass_kg"])
        block: dict[str, Any] = {
            name: float(record[f"stated_{name}"]) for name in ("height_m", "width_m", "mass_kg")
        }
        block["uncertainty"] = {name: known[name] for name in [*block]}
        laser = {"beam": "horizontal", "position_m": float(record["stated_position_m"]), "units": "V"}
        laser |= {"range_m": float(record["stated_range_m"])}
        laser["uncertainty"] = {name: known[name] for name in known if name not in block}
        parts["blocks"][f"block_{test}"], parts["lasers"][f"laser_{test}"] = block, laser
        parts["foundations"][f"bed_{test}"] = {}
        lines.append(f"{test},{test}.csv,laser,block_{test},bed_{test},laser_{test},,,,")
        head = f"SIMULATED\nSampling rate: {float(record['rate_hz']):g} Hz\nlaser [V]\n"
        _put(folder / f"raw/bench/{test}.csv", head + "\n".join(f"{x:.7f}" for x in record["volts"]) + "\n")
    stated = {"title": "Records of the bench", "origin": "simulated", **parts}
    _put(folder / "config/campaigns/bench.yaml", json.dumps(stated, indent=1) + "\n")
    _put(folder / "config/campaigns/bench.csv", "\n".join(lines) + "\n")
    _put(folder / "config/config.yaml", "campaigns: [bench]\n")


def _put(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def graded(tables: Tables, records: Mapping[str, Path], case_of: Callable[[Any], str]) -> pd.DataFrame:
    """The long table of a campaign; `case_of` names the case of a record."""
    rows = []
    for test, path in records.items():
        truth = np.load(path)
        own = {name: table[table["test"] == test] for name, table in tables.items() if "test" in table}
        scene = {name: str(truth[f"true_{name}"]) for name in ("law", "foundation")} | {
            "case": case_of(truth)
        }
        scene |= {"test": test, "block": str(truth["true_block_name"])}
        scene["kinematics"] = str(truth["true_kinematics"]) if "true_kinematics" in truth else ""
        law, kinematics = scene["law"], scene["kinematics"]
        right = [Candidate(law, kinematics).name] if kinematics else []
        rows += [scene | row for row in rows_of_record(own, truth, right)]
    return pd.DataFrame(rows, columns=COLUMNS)


def rows_of_record(own: Tables, truth: Mapping[str, Any], right: Sequence[str]) -> Iterator[Row]:
    """Rows of a record; candidates that are right, none where no law is true."""
    found = {}
    for j, begins in enumerate(truth["begins_s"]):
        near = own["runs"][(own["runs"]["release_s"] - begins).abs() < SAME_RUN_S]
        level = str(near["verdict"].iloc[0]) if len(near) else "missed"
        note = str(near["reasons"].iloc[0]) if len(near) else ""
        for each in ("ok", "warn", "fail", "missed"):
            yield {"parameter": f"verdict {each}", "inside": level == each, "run": j + 1, "note": note}
        if len(near) and level != "fail":
            found[str(near["run"].iloc[0])] = j
    selected = [*own["choice"].loc[own["choice"]["status"] == "selected", "model"]]
    fitted = {*own["parameters"]["model"]}
    model = next(
        (name for name in (*(each for each in selected if each in right), *right) if name in fitted), ""
    )
    if right:
        yield from _choice(own["choice"], right)
    else:
        model = selected[0] if selected else ""
    yield from _parameters(own["parameters"][own["parameters"]["model"] == model], truth, found)
    if "true_sigma_r" in truth:
        true = float(truth["true_sigma_r"])
        for row in own["epsilon"][own["epsilon"]["model"] == model].head(1).itertuples():
            inside = row.sigma_r_low <= true <= row.sigma_r_high
            yield {"parameter": "σ_r", "truth": true, "value": row.sigma_r, "inside": inside}
    yield from _restitution(own["restitution"], own["runs"], truth, found)
    yield from _means(own["populations"], truth, model)
    for name, what in (("inside", "|θ_n|"), ("impact_inside", "impacts")):
        for row in own["predictions"].itertuples():
            yield {"parameter": f"{what} of the next run", "inside": bool(getattr(row, name)), "run": row.run}


def _choice(choice: pd.DataFrame, right: Sequence[str]) -> Iterator[Row]:
    """Whether the true law is named, in the set that the data can't tell apart, or neither."""
    for run, own in choice.groupby("run"):
        status = own.set_index("model")["status"]
        selected = [*status.index[status == "selected"]]
        among = {*selected, *status.index[status == "also_possible"]}
        explained = own[own["status"] == "selected"]["explains"].astype(str).eq("True").any()
        answers = {
            "true law first": bool({*selected} & {*right}),
            "true law in the set": bool(among & {*right}),
        }
        answers |= {"named alone, wrongly": not among & {*right} and bool(explained)}
        for parameter, answer in answers.items():
            yield {"parameter": parameter, "inside": answer, "run": run, "note": " ".join(selected)}


def _parameters(fits: pd.DataFrame, truth: Any, runs: Mapping[str, int]) -> Iterator[Row]:
    """Numbers of the fits of the true law."""
    fits = fits[fits["success"].astype(str) == "True"]
    for row in fits.itertuples():
        if row.parameter in ("theta0", "t0"):
            continue  # of the reading, not of the block
        key = f"run{runs.get(str(row.run), -1)}_{row.parameter}"
        if key in truth:
            yield number_row(str(row.parameter), float(truth[key]), row.value, row.stderr, row.u_total) | {
                "run": row.run
            }


def _restitution(
    table: pd.DataFrame, runs: pd.DataFrame, truth: Any, known: Mapping[str, int]
) -> Iterator[Row]:
    """r by energy of each impact, against the ratio of true energies."""
    release = {str(row.run): row.release_s for row in runs.itertuples()}
    for row in table[table["source"] == "experiment"].itertuples():
        if str(row.run) not in known or not math.isfinite(row.r_energy):
            continue
        j = known[str(row.run)]
        apart = np.abs(truth[f"run{j}_volts_impacts_s"] - release[str(row.run)] - row.time_s)
        at = int(np.argmin(apart))
        if apart[at] < SAME_IMPACT_S:
            true = float(truth[f"run{j}_volts_r_energy"][at])
            yield number_row("r of an impact", true, row.r_energy, row.r_energy_u, row.r_energy_u) | {
                "run": row.run
            }


def _means(table: pd.DataFrame, truth: Any, model: str) -> Iterator[Row]:
    """Means over the runs of a record, and the interval for its next run."""
    own = table[(table["level"] == "record") & (table["model"] == model)]
    for row in own.itertuples():
        if f"mean_{row.parameter}" in truth:
            true, n = float(truth[f"mean_{row.parameter}"]), {"note": f"{row.n_runs} runs"}
            yield (
                number_row(f"mean {row.parameter}", true, row.mean, row.stderr, row.u_total)
                | n
                | {"inside": row.total95_low <= true <= row.total95_high}
            )
        if f"next_{row.parameter}" in truth:
            true = float(truth[f"next_{row.parameter}"])
            inputs = NORMAL_95**2 * max(row.u_total**2 - row.stderr**2, 0.0)  # shared by all runs of a record
            half = math.sqrt(((row.next_high - row.next_low) / 2) ** 2 + inputs)
            inside = abs(true - (row.next_low + row.next_high) / 2) <= half
            yield {"parameter": f"next {row.parameter}", "truth": true, "value": row.mean, "inside": inside}


def number_row(parameter: str, truth: float, value: float, stderr: float, u: float) -> Row:
    """A number against its truth."""
    inside = abs(value - truth) <= NORMAL_95 * u if math.isfinite(u) else math.nan
    return {
        "parameter": parameter,
        "truth": truth,
        "value": value,
        "stderr": stderr,
        "u": u,
        "inside": inside,
    }


def summary(frame: pd.DataFrame) -> pd.DataFrame:
    """Of each case and parameter: n, percent inside, medians of |error| and u in per cent of the truth."""
    known = frame[frame["inside"].notna()].copy()
    percent = 100 / known["truth"].astype(float).abs()
    known["error_percent"] = (known["value"] - known["truth"]).abs() * percent
    known["u_percent"] = known["u"] * percent
    known["inside_percent"] = 100 * known["inside"].astype(float)
    groups = known.groupby(["case", "parameter"], sort=False)
    return groups.agg(
        n=("inside", "size"),
        inside_percent=("inside_percent", "mean"),
        error_percent=("error_percent", "median"),
        u_percent=("u_percent", "median"),
    ).reset_index()


def markdown(frame: pd.DataFrame) -> str:
    """A row per parameter, a column per case: share inside, number, median error."""
    cases, cells = list(frame["case"].unique()), {}
    for row in summary(frame).itertuples():
        error = f", {row.error_percent:.2g} %" if math.isfinite(row.error_percent) else ""
        cells[row.parameter, row.case] = f"{row.inside_percent:.0f} % of {row.n}{error}"
    rows = [[name, *(cells.get((name, each), "") for each in cases)] for name in frame["parameter"].unique()]
    return in_markdown(["share, number, median error", *cases], rows)


def finish(frame: pd.DataFrame, name: str, document: str = "") -> None:
    """Write the long table and its summary, print, and renew the table of a document where one is named."""
    write_csv(frame, Path("results/studies", f"{name}.csv"))
    print(markdown(frame))
    if document:
        write_csv(summary(frame), ROOT / "docs/evidence" / f"{name}.csv")
        renew(document, name, markdown(frame))


def worst(frame: pd.DataFrame, n: int = 10) -> str:
    """The numbers farthest from their truth, in u."""
    off = ((frame["value"] - frame["truth"]) / frame["u"]).astype(float).abs()
    rows = frame.assign(z=off).nlargest(n, "z")
    shown = ["z", "case", "test", "run", "law", "kinematics", "block", "foundation", "parameter"]
    return str(rows[shown].to_string())


def made(maker: Callable[[Any], Path], cases: Sequence[Any]) -> dict[str, Path]:
    """Records of cases by the names of their tests."""
    paths = [maker(case) for case in cases]
    return {path.stem: path for path in paths}


def listed(tables: Tables, records: Mapping[str, Path]) -> str:
    """Of each record where no law is true: the law selected and why, its reasons, k over the edge's."""
    lines = []
    for test, path in records.items():
        truth, own = np.load(path), {name: table[table["test"] == test] for name, table in tables.items()}
        chosen = own["choice"][own["choice"]["status"] == "selected"]
        fits = own["parameters"][own["parameters"]["parameter"] == "k"]
        lines.append(
            f"{test}: {', '.join(own['runs']['verdict'])}; {' '.join(sorted({*own['reasons']['reason']}))}"
        )
        lines += [
            f"    {model}: {why}" for model, why in {*zip(chosen["model"], chosen["reason"], strict=True)}
        ]
        for model, rows in fits.groupby("model"):
            over = rows["value"] / float(truth["edge_k"])
            known = ", ".join(
                f"{a:.3f} ± {b:.3f}"
                for a, b in zip(over, over * rows["u_total"] / rows["value"], strict=True)
            )
            lines.append(f"    {model}: k over the edge's {known}")
    return "\n".join(lines)
