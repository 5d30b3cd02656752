"""Records of known truth, analysed as a campaign by the workflow, and its tables held against their truth.

Each record is a .npz as `scattered.save` writes it: volts; what is stated of block and laser, with its
uncertainty; what is true. It stands on a foundation of its own, so that nothing is shared between records.
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import chdir
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.config import step_settings as settings
from freerock.config.campaign import Campaign, load_config
from freerock.config.record import Record
from freerock.identification.significance_levels import NORMAL_95
from freerock.jobs.descriptions import described
from freerock.jobs.make_fits import make_fits
from freerock.jobs.make_record import make_record
from freerock.jobs.make_tables import make_tables
from freerock.models.laws import Candidate
from freerock.tables.csvfile import read_csv
from freerock.tables.tidy_tables import R_ENERGY, R_ENERGY_U
from freerock_bench.document import in_markdown

ROOT = Path(__file__).parents[2]
TABLES = ["runs", "reasons", "choice", "parameters", "restitution", "populations", "predictions"]
TABLES += ["epsilon", "paper"]
SAME_RUN_S, SAME_IMPACT_S = 0.5, 0.02
HELD_OUT = "error of held-out peaks"  # of a candidate; of the selected one, `inside`
COLUMNS = ["case", "parameter", "truth", "value", "stderr", "u", "inside", "test", "run", "scene", "note"]
"""A row per case and number: truth, value, stderr (of the noise), u (with all else that is known) [SI];
whether the 95 % interval holds the truth. Of a question with yes and no, `inside` is the answer. The scene is
law, kinematics, block and foundation."""
SCENE = ("law", "kinematics", "block_name", "foundation")
Row = dict[str, Any]
Tables = Mapping[str, pd.DataFrame]


def study(
    folder: Path,
    make: Callable[[Path, Any], Path],
    cases: Sequence[Any],
    case_of: Callable[[Any], str],
    cores: int = 1,
) -> pd.DataFrame:
    """The long table of a study: records of cases, made where they are not there, analysed, graded.

    Parameters
    ----------
    folder : Path
        Of records and results; what is there is kept.
    make : callable
        Of a folder and a case: writes its record, and returns the path.
    cases : sequence
    case_of : callable
        Of a record: its case in the table.
    cores : int
    """
    with ProcessPoolExecutor(cores) as pool:
        paths = [*pool.map(make, [folder / "records"] * len(cases), cases)]
    records = {path.stem: path for path in paths}
    _write(folder, records)
    return graded(analysed(folder, "bench", cores), records, case_of)


def analysed(folder: Path, campaign: str, cores: int = 1) -> Tables:
    """Tables of the campaign of a folder, by the jobs of the workflow; products that are there are kept."""
    with chdir(folder):
        section = load_config("config/config.yaml", [campaign])[campaign]
        told, out = {campaign: settings.descriptions(section)}, Path("results", campaign)
        for kind in ("records", "fits"):
            (out / kind).mkdir(parents=True, exist_ok=True)
        with ProcessPoolExecutor(cores) as pool:
            [*pool.map(partial(_analyse, out, section, told), section.records)]
        of_tables: dict[str, Any] = {"blocks": settings.geometries(section), "published": None}
        of_tables |= {"release_angles_deg": settings.release_angles(section)}
        of_tables |= {"debonding": section.fits.debonding}
        tests = [each.test for each in section.records]
        records, fits = ([out / kind / f"{test}.nc" for test in tests] for kind in ("records", "fits"))
        make_tables(of_tables, records, fits, out / "tables")
        return {name: read_csv(out / f"tables/{name}.csv") for name in TABLES}


def _analyse(out: Path, section: Campaign, told: Mapping[str, Any], record: Record) -> None:
    """Write the dataset of a record and its fits."""
    made, fits = (out / kind / f"{record.test}.nc" for kind in ("records", "fits"))
    if not made.exists():
        make_record(described(settings.record_settings(section, record, ""), told), made)
    if not fits.exists():
        make_fits(described(settings.fit_settings(section, record), told), made, fits)


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
        law, kinematics, *where = (str(truth[f"true_{name}"]) for name in SCENE)
        of = {"case": case_of(truth), "test": test, "scene": " ".join([law, kinematics, *where])}
        right = [Candidate(law, kinematics, width).name for width in (False, True)] if kinematics else []
        rows += [of | row for row in rows_of_record(of_test(tables, test), truth, right)]
    return pd.DataFrame(rows, columns=COLUMNS)


def of_test(tables: Tables, test: str) -> Tables:
    """The rows of a record."""
    return {name: table[table["test"] == test] for name, table in tables.items()}


def rows_of_record(own: Tables, truth: Mapping[str, Any], right: Sequence[str]) -> Iterator[Row]:
    """Rows of a record; candidates that are right, with the width freed or not, none where no law is true."""
    found = {}
    for j, begins in enumerate(truth["begins_s"]):
        near = own["runs"][(own["runs"]["release_s"] - begins).abs() < SAME_RUN_S]
        level = str(near["verdict"].iloc[0]) if len(near) else "missed"
        own_reasons = own["reasons"][own["reasons"]["run"].isin(near["run"])]["reason"].unique()
        note = " ".join([level, *own_reasons])
        yield {"parameter": "verdict ok", "inside": level == "ok", "run": j + 1, "note": note}
        yield {"parameter": "run is used", "inside": level in ("ok", "warn"), "run": j + 1}
        if len(near) and level != "fail":
            found[str(near["run"].iloc[0])] = j
    selected = [*own["choice"].loc[own["choice"]["status"] == "selected", "model"]]
    model = (selected or [*right] or [""])[0]
    if right:
        yield from _choice(own["choice"], right)
    else:
        yield {"parameter": "law selected", "note": model}
    yield from _parameters(own["parameters"][own["parameters"]["model"] == model], truth, found)
    for row in own["paper"][own["paper"]["model"] == model].itertuples():
        key = f"run{found.get(str(row.run), -1)}_{row.parameter}"
        if key in truth:
            numbers = {"truth": float(truth[key]), "value": row.value, "run": row.run}
            yield {"parameter": f"{row.parameter} by the paper's objective"} | numbers
    if "true_sigma_r" in truth:
        true = float(truth["true_sigma_r"])
        for row in own["epsilon"][own["epsilon"]["model"] == model].head(1).itertuples():
            inside = row.sigma_r_low <= true <= row.sigma_r_high
            yield {"parameter": "σ_r", "truth": true, "value": row.sigma_r, "inside": inside}
    yield from _restitution(own["restitution"], own["runs"], truth, found)
    yield from _means(own["populations"], truth, model)
    for name, what in (("inside", "|θ_n|"), ("impact_inside", "impacts")):
        for row in own["predictions"].itertuples():
            yield {"parameter": f"left-out {what}", "inside": bool(getattr(row, name)), "run": row.run}


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
            "named alone, wrongly": not among & {*right} and bool(explained),
        }
        for parameter, answer in answers.items():
            note = {"note": " ".join(selected)} if parameter == "true law first" else {}
            yield {"parameter": parameter, "inside": answer, "run": run} | note


def _parameters(fits: pd.DataFrame, truth: Any, runs: Mapping[str, int]) -> Iterator[Row]:
    """Numbers of the fits of the law that is selected."""
    fits = fits[fits["success"].astype(str) == "True"]
    for row in fits.itertuples():
        key = f"run{runs.get(str(row.run), -1)}_{row.parameter}"
        if key in truth and row.parameter not in ("theta0", "t0"):  # those are of the reading
            numbers = row.value, row.stderr, row.u_total
            yield number_row(str(row.parameter), float(truth[key]), *numbers) | {"run": row.run}


def _restitution(
    table: pd.DataFrame, runs: pd.DataFrame, truth: Any, known: Mapping[str, int]
) -> Iterator[Row]:
    """r by energy of each impact, against the ratio of true energies."""
    release = {str(row.run): row.release_s for row in runs.itertuples()}
    for row in table[table["source"] == "experiment"].itertuples():
        j = known.get(str(row.run), -1)
        r, u = getattr(row, R_ENERGY), getattr(row, R_ENERGY_U)
        if f"run{j}_volts_true_r" not in truth or not math.isfinite(r):
            continue
        apart = np.abs(truth[f"run{j}_volts_impacts_s"] - release[str(row.run)] - row.time_s)
        at = int(np.argmin(apart))
        if apart[at] < SAME_IMPACT_S:
            true = float(truth[f"run{j}_volts_true_r"][at])
            yield number_row("r of an impact", true, r, u, u) | {"run": row.run}


def _means(table: pd.DataFrame, truth: Any, model: str) -> Iterator[Row]:
    """Means over the runs of a record, and the interval for its next run."""
    own = table[(table["level"] == "record") & (table["model"] == model)]
    for row in own.itertuples():
        if f"mean_{row.parameter}" in truth:
            true = float(truth[f"mean_{row.parameter}"])
            told = {"inside": row.total95_low <= true <= row.total95_high, "note": f"{row.n_runs} runs"}
            yield number_row(f"mean {row.parameter}", true, row.mean, row.stderr, row.u_total) | told
        if f"next_{row.parameter}" in truth:
            true = float(truth[f"next_{row.parameter}"])
            inputs = NORMAL_95**2 * max(row.u_total**2 - row.stderr**2, 0.0)  # shared by all runs of a record
            half = math.sqrt(((row.next_high - row.next_low) / 2) ** 2 + inputs)
            inside = abs(true - (row.next_low + row.next_high) / 2) <= half
            yield {"parameter": f"next {row.parameter}", "truth": true, "value": row.mean, "inside": inside}


def number_row(parameter: str, truth: float, value: float, stderr: float, u: float) -> Row:
    """A number against its truth."""
    inside = abs(value - truth) <= NORMAL_95 * u if math.isfinite(u) else math.nan
    known = {"truth": truth, "value": value, "stderr": stderr, "u": u, "inside": inside}
    return {"parameter": parameter} | known


def markdown(frame: pd.DataFrame) -> str:
    """A row per parameter, a column per case: share inside, number, median error in per cent of the truth."""
    known = frame[(frame["inside"].notna() & frame["value"].isna()) | frame["truth"].notna()]
    cases, cells = list(frame["case"].unique()), {}
    for (name, case), own in known.groupby(["parameter", "case"]):
        inside = 100 * own["inside"].astype(float).mean()
        error = 100 * (own["value"] / own["truth"].astype(float) - 1).abs().median()
        share = f"{inside:.0f} % of " if math.isfinite(inside) else ""
        cells[name, case] = f"{share}{len(own)}" + (f", {error:.2g} %" if math.isfinite(error) else "")
    names = [each for each in frame["parameter"].unique() if any((each, case) in cells for case in cases)]
    rows = [[name, *(cells.get((name, each), "") for each in cases)] for name in names]
    return in_markdown(["share inside, number, median error", *cases], rows)
