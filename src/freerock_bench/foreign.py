"""What an analysis says of records of foreign physics, against what is true of them.

    snakemake --config campaigns=foreign
    python -m freerock_bench.foreign results/foreign docs/evidence.md

reads the products of the campaign `foreign` and the truths that lie apart from its records, writes
results/studies/foreign.csv and renews the table in the documentation, where it is named.
"""

import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.errors import FreerockError, exit_code
from freerock.identification.significance_levels import NORMAL_95
from freerock.products.groups import runs_of
from freerock.products.netcdf import open_fits, open_record
from freerock.products.verdict_with_fits import verdict_of_run
from freerock.tables.csvfile import read_csv, write_csv
from freerock_bench.document import in_markdown, renew

TRUTHS = Path("benchmarks/foreign/truths.json")
PRODUCT = Path("results/studies/foreign.csv")
SURE = 3.0  # standard errors; a number farther from the truth is wrong
SAME_IMPACT_S = 0.02
LEAST_R = 0.01  # a restitution is wrong only if it is off by more
TABLES = ("runs", "choice", "parameters", "restitution", "predictions")
COLUMNS = ["test", "about", "run", "verdict", "names", "named", "model", "explained", "choice"]
COLUMNS += ["k_error_percent", "k_error_stderrs", "lambda_error_percent", "lambda_error_stderrs"]
COLUMNS += ["n_r", "n_r_inside", "r_error", "r_wrong", "release_error_ms", "prediction_epsilon", "wrong"]
Row = dict[str, Any]
Tables = Mapping[str, pd.DataFrame]
Names = Mapping[str, tuple[str, ...]]  # of the reasons of each run


def score(folder: Path, truths: Mapping[str, Any]) -> pd.DataFrame:
    """Grade the products in the results folder of a campaign, as `grade` does.

    Raises
    ------
    FreerockError
        A table or dataset is missing, or a dataset can't be read.
    """
    tables = tables_of(folder)
    return grade(tables, {test: _names(folder, test) for test in truths}, truths)


def tables_of(folder: Path) -> dict[str, pd.DataFrame]:
    """The tables of a results folder that are graded, by name; raises FreerockError where one is missing."""
    paths = {name: folder / "tables" / f"{name}.csv" for name in TABLES}
    for path in paths.values():
        _there(path, "run `snakemake --config campaigns=foreign`, or name the folder of its results")
    return {name: read_csv(path) for name, path in paths.items()}


def _there(path: Path, remedy: str) -> Path:
    if not path.is_file():
        raise FreerockError(path, "there is no such file", remedy)
    return path


def grade(tables: Tables, names: Mapping[str, Names], truths: Mapping[str, Any]) -> pd.DataFrame:
    """Grade the tables of a campaign.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame
        Those of `TABLES`.
    names : mapping of str to mapping of str to tuple of str
        By test and number of the run, the names of its reasons.
    truths : mapping
        By test: about, right_names, right_choices, parameters [SI], and of each of its runs let_go_s, free_s
        and impacts_s [s] and restitution.

    Returns
    -------
    pandas.DataFrame
        A row per true run: verdict ("missed" where none was found) and names of its reasons; named (one is
        right); model selected, explained, choice ("right", "wrong", "none explains"); errors of k and λ [%,
        standard errors], NaN where they mean nothing; n_r, n_r_inside (restitutions, those inside their
        95 % interval), r_error (their median error), r_wrong (how many are off by `LEAST_R` and `SURE`
        standard errors); release_error_ms (beyond the time in which the hand leaves); prediction_epsilon
        (ε_θ of the run predicted from the other); wrong (what an ok stands over, joined by blanks).
    """
    rows = []
    for test, truth in truths.items():
        for i, run in enumerate(truth["runs"]):
            row: Row = {"test": test, "about": truth["about"], "run": str(i + 1)}
            rows.append(row | _run(tables, names[test], test, truth, run))
    return pd.DataFrame(rows, columns=COLUMNS)


def _names(folder: Path, test: str) -> dict[str, tuple[str, ...]]:
    """Of each run the names of its reasons."""
    record = open_record(folder / "records" / f"{test}.nc", samples=False)
    fits = open_fits(folder / "fits" / f"{test}.nc", samples=False)
    return {
        str(number): verdict_of_run(number, group, fits).names for number, group in runs_of(record).items()
    }


def _where(table: pd.DataFrame, **wanted: str) -> pd.DataFrame:
    """The rows in which these columns have these values."""
    for name, value in wanted.items():
        table = table[table[name] == value]
    return table


def _run(tables: Tables, names: Names, test: str, truth: Mapping[str, Any], run: Mapping[str, Any]) -> Row:
    found = _where(tables["runs"], test=test)
    found = found[(found["release_s"] > run["let_go_s"] - 1.0) & (found["release_s"] < run["free_s"] + 1.0)]
    if found.empty:
        return {"verdict": "missed", "names": "", "named": False, "choice": "none explains", "wrong": ""}
    seen = found.iloc[0]
    number, level = seen["run"], seen["verdict"]
    of_run = {name: _where(table, test=test, run=number) for name, table in tables.items()}
    told = names.get(number, ())
    row: Row = {
        "verdict": level,
        "names": " ".join(told),
        "named": level != "ok" and any(name in truth["right_names"] for name in told),
    }
    row |= _choice(of_run, truth) | _restitution(of_run["restitution"], float(seen["release_s"]), run)
    late = max(seen["release_s"] - run["free_s"], 0.0) + min(seen["release_s"] - run["let_go_s"], 0.0)
    row["release_error_ms"] = 1e3 * late
    wrong = [name for name in ("k", "lambda") if abs(row.get(f"{name}_error_stderrs", 0.0)) > SURE]
    wrong += ["r"] if row["r_wrong"] else []
    wrong += ["explained"] if row["choice"] == "wrong" else []
    return row | {"wrong": " ".join(wrong) if level == "ok" else ""}


def _choice(of_run: Tables, truth: Mapping[str, Any]) -> Row:
    """The candidate named, its parameters against the truth, and its prediction."""
    selected = _where(of_run["choice"], status="selected")
    if selected.empty:
        return {"model": "", "explained": False, "choice": "none explains"}
    model, explained = selected.iloc[0]["model"], str(selected.iloc[0]["explains"]) == "True"
    right = "right" if model in truth["right_choices"] else "wrong"
    row: Row = {"model": model, "explained": explained, "choice": right if explained else "none explains"}
    fitted = _where(of_run["parameters"], model=model).set_index("parameter")
    for name, true in truth["parameters"].items():
        if name in fitted.index:
            off = float(fitted.loc[name, "value"]) - true
            row[f"{name}_error_percent"] = 100 * off / true
            row[f"{name}_error_stderrs"] = off / float(fitted.loc[name, "stderr"])
    predicted = _where(of_run["predictions"], model=model, basis="other runs")
    return row | ({"prediction_epsilon": predicted.iloc[0]["epsilon_theta"]} if len(predicted) else {})


def _restitution(measured: pd.DataFrame, release_s: float, run: Mapping[str, Any]) -> Row:
    """The measured restitutions against the true ones of the same impacts."""
    measured = _where(measured, source="experiment")
    times, true = np.array(run["impacts_s"]), np.array(run["restitution"])
    if measured.empty or not times.size:
        return {"n_r": 0, "n_r_inside": 0, "r_error": math.nan, "r_wrong": 0}
    at: Floats = measured["time_s"].to_numpy(float) + release_s
    nearest = np.abs(at[:, None] - times).argmin(axis=1)
    same = np.abs(at - times[nearest]) < SAME_IMPACT_S
    off = (measured["r"].to_numpy(float) - true[nearest])[same]
    stderr = measured["r_stderr"].to_numpy(float)[same]
    return {
        "n_r": off.size,
        "n_r_inside": int(np.sum(np.abs(off) < NORMAL_95 * stderr)),
        "r_error": float(np.median(np.abs(off))) if off.size else math.nan,
        "r_wrong": int(np.sum((np.abs(off) > SURE * stderr) & (np.abs(off) > LEAST_R))),
    }


def table(frame: pd.DataFrame) -> str:
    """Rows of Markdown: one per record, of its two runs."""
    heads = ["record", "what it is", "verdicts", "rightly named", "choice", "k [%] (standard errors)", "λ"]
    heads += ["r_i inside, median error", "release [ms]", "prediction ε_θ"]
    records = []
    for test, rows in frame.groupby("test", sort=False):
        warned = rows[rows["verdict"] != "ok"]
        cells = [
            f"`{test}`",
            rows["about"].iloc[0],
            ", ".join(rows["verdict"]),
            f"{int(warned['named'].sum())} of {len(warned)}" if len(warned) else "",
            "; ".join(dict.fromkeys(map(_chosen, rows["model"].fillna(""), rows["choice"]))),
            _off(rows, "k"),
            _off(rows, "lambda"),
            _r(rows),
            ", ".join(f"{x:+.1f}" for x in rows["release_error_ms"].dropna()),
            ", ".join(f"{x:.1g}" for x in rows["prediction_epsilon"].dropna()),
        ]
        records.append(cells)
    return in_markdown(heads, records)


def _chosen(model: str, choice: str) -> str:
    return f"{model}, {choice}" if model else "none"


def _off(rows: pd.DataFrame, name: str) -> str:
    pairs = rows[[f"{name}_error_percent", f"{name}_error_stderrs"]].dropna().itertuples(index=False)
    return ", ".join(f"{percent:+.2g} ({errors:+.1f})" for percent, errors in pairs)


def _r(rows: pd.DataFrame) -> str:
    n = int(rows["n_r"].sum())
    return f"{int(rows['n_r_inside'].sum())} of {n}, {rows['r_error'].max():.1g}" if n else "none"


def counts(frame: pd.DataFrame) -> str:
    """What is counted over all runs, in a sentence or two; and each ok over a wrong number."""
    ok = frame["verdict"] == "ok"
    given, wrong = frame["choice"] != "none explains", frame["choice"] == "wrong"
    false = frame[frame["wrong"] != ""]
    lines = [
        f"{frame['test'].nunique()} records, {len(frame)} runs: {int(ok.sum())} `ok`, "
        f"{int((~ok).sum())} others, {int(frame['named'].sum())} of them for the right reason. "
        f"{int(given.sum())} are explained, {int(wrong.sum())} of them by a wrong law. "
        f"`ok` with a wrong number or law: {f'{len(false)}:' if len(false) else 'none.'}"
    ]
    listed = [f"- `{row.test}`, run {row.run}: {row.wrong} ({row.model})." for row in false.itertuples()]
    return "\n".join([*lines, "", *listed] if listed else lines)


def main(results: str = "results/foreign", document: str = "") -> None:
    """Grade, write the product, print, and renew the table of a document."""
    truths = _there(TRUTHS, "run it in the checkout of freerock")
    frame = score(Path(results), json.loads(truths.read_text(encoding="utf-8")))
    write_csv(frame, PRODUCT)
    text = f"{table(frame)}\n\n{counts(frame)}"
    print(text)
    if document:
        renew(_there(Path(document), "name the page that has the table"), "foreign", text)


if __name__ == "__main__":
    sys.exit(exit_code(lambda: main(*sys.argv[1:])))
