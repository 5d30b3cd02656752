"""What the report says about each record: its file, what was found in it, fits, curves of its runs."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from freerock.arrays import Floats
from freerock.models.free_parameters import symbol_of
from freerock.models.laws import MODEL_LABELS, law_of
from freerock.products.choices import choices_of
from freerock.products.groups import fits_of, impacts_of, reasons_in, release_angle_of, runs_of
from freerock.report.charts import run_curves
from freerock.runs.verdict import VERDICTS, in_one_line
from freerock.tables.number_text import fixed, quantity, value_text

SCENE = ("block", "foundation")


@dataclass(frozen=True)
class Listed:
    """The records of a campaign that the page lists one by one.

    Parameters
    ----------
    tests : frozenset of str
    n_records : int
        Of the campaign.
    """

    tests: frozenset[str]
    n_records: int

    def rows(self, table: pd.DataFrame) -> pd.DataFrame:
        """The rows of these records, and those of no single record."""
        if "test" not in table:
            return table
        return table[table["test"].isna() | table["test"].isin(self.tests)]

    def notes(self, name: str) -> Sequence[str]:
        """Where the rows of all records are, below a table that lacks some."""
        return [f"{self.told} All: tables/{name}.csv."] if self.told else []

    @property
    def told(self) -> str:
        """How many records are listed, and which; empty where all are."""
        n = len(self.tests)
        most = "the one whose runs most need" if n == 1 else "those whose runs most need"
        return f"Listed: {n} of {self.n_records} records, {most} a look." if n < self.n_records else ""


def listed_records(runs: pd.DataFrame, most: int) -> Listed:
    """The records that the page lists, those with the worst verdicts first, until they have so many runs.

    Parameters
    ----------
    runs : pandas.DataFrame
        Tidy table; an excluded run needs no look.
    most : int
        Runs; the last record is listed with all of its own.
    """
    records = _need(runs).groupby(runs["test"], sort=False).agg(["max", "size"])
    ranked = records.sort_values("max", ascending=False, kind="stable")
    before = ranked["size"].cumsum() - ranked["size"]
    return Listed(frozenset(ranked.index[before < most]), len(ranked))


def charted(runs: pd.DataFrame, most: int) -> set[tuple[str, int]]:
    """The runs whose charts go into the page: the worst verdicts first, then the first run of each record.

    Parameters
    ----------
    runs : pandas.DataFrame
        Tidy table; an excluded run needs no look.
    most : int
        How many at most.

    Returns
    -------
    set of (str, int)
        Test and run.
    """
    found = runs.dropna(subset=["run"]).astype({"run": int})
    ranked = found.assign(rank=-_need(found)).sort_values(["rank", "run"], kind="stable")
    return {(row.test, row.run) for row in ranked.head(most).itertuples()}


def _need(runs: pd.DataFrame) -> "pd.Series[int]":
    """How much each run needs a look: by its verdict, an excluded one not at all."""
    return runs["verdict"].map(VERDICTS.index).where(~runs["excluded"].astype(bool), 0)


def sections_of(
    provenance: Mapping[str, Any],
    runs: pd.DataFrame,
    opened: Callable[[str, bool], tuple[xr.DataTree, xr.DataTree]],
    wanted: Collection[tuple[str, int]],
    pages: Mapping[str, str],
) -> list[dict[str, Any]]:
    """The sections of all records, in the order of the campaign's CSV.

    Parameters
    ----------
    provenance : mapping
        inputs, and config, the campaign's section.
    runs : pandas.DataFrame
        Tidy table.
    opened : callable
        As for `freerock.report.page.write_report`.
    wanted : collection of (str, int)
        Test and run of the curves to be drawn.
    pages : mapping of str to str
        Links to quality pages by test.
    """
    verdicts = {(row.test, str(row.run)): (row.verdict, row.reasons) for row in runs.itertuples()}
    drawn = {test for test, _ in wanted}
    sections = []
    for line in provenance["config"]["records"]:
        test = line["test"]
        record, fits = opened(test, test in drawn)
        time = record.dataset["time"].values if "time" in record.dataset else np.empty(0)
        fitted, groups = runs_of(fits), _fits(fits)
        found = []
        for number, run in runs_of(record).items():
            drawn_here = (test, number) in wanted
            curves = run_curves(record, number, fitted.get(number)) if drawn_here else None
            told = _run(number, run, verdicts[test, str(number)], time)
            found.append(told | {"fits": groups.get(number, []), "curves": curves})
        worst = max((verdicts[key][0] for key in verdicts if key[0] == test), key=VERDICTS.index)
        own = {"verdict": worst, "samples": len(time), "page": pages.get(test, ""), "runs": found}
        sections.append(_section(record, line, provenance) | own)
    return sections


def _section(record: xr.DataTree, line: Mapping[str, Any], provenance: Mapping[str, Any]) -> dict[str, Any]:
    """File, block, foundation and settings of a record."""
    attrs, config = record.attrs, provenance["config"]
    file = f"{config['raw']}/{line['file']}"
    names = (config[f"{kind}s"].get(attrs[kind], {}).get("label", attrs[kind]) for kind in SCENE)
    return {
        "test": line["test"],
        **{kind: attrs[kind] for kind in SCENE},
        "names": ", ".join(names),
        "reasons": in_one_line(reasons_in(attrs)),
        "file": file,
        "sha256": provenance["inputs"].get(file, ""),
        "lasers": [name.strip() for name in line["laser"].split(";")],
        "by_hand": {key: line[key] for key in ("exclude", "override", "reason", "note") if line.get(key)},
        "rate_hz": float(attrs.get("sampling_rate_hz", math.nan)),
    }


def _run(number: int, run: xr.DataTree, found: tuple[str, str], time: Floats) -> dict[str, Any]:
    verdict, reasons = found
    known = {name: run.dataset[name].item() for name in ("release", "fit_start", "end")}
    sigma = math.degrees(run.dataset["sigma_theta"].item())
    return {
        "number": number,
        "verdict": verdict + (", excluded" if run.attrs["excluded"] else ""),
        "kind": "excluded" if run.attrs["excluded"] else verdict,
        "reasons": reasons,
        "theta0": quantity(*release_angle_of(run)),
        "sigma": quantity(sigma, digits=2),
        "impacts": impacts_of(run),
        "instants": [fixed(instant, 3) for instant in known.values()],
        "samples": [int(time.searchsorted(known[name])) for name in ("fit_start", "end")],
    }


def _fits(fits: xr.DataTree) -> dict[int, list[dict[str, Any]]]:
    """The fits of each run."""
    groups, rejected = dict[int, list[dict[str, Any]]](), dict[int, set[str]]()
    for run, choice in choices_of(fits):
        rejected[run] = set(choice["candidate"].values[choice["status"].values == "rejected"].tolist())
    for run, model, fit in fits_of(fits):
        groups.setdefault(run, []).append(_fit(model, fit) | {"rejected": model in rejected.get(run, ())})
    return groups


def _fit(model: str, fit: xr.Dataset) -> dict[str, Any]:
    names, units = fit["parameter"].values.astype(str), fit["unit"].values.astype(str)
    found = zip(names, fit["value"].values, fit["u_total"].values, units, strict=True)
    known = fit.attrs
    return {
        "model": MODEL_LABELS[model],
        "parameters": [f"{symbol_of(name)} = {value_text(value, u, unit)}" for name, value, u, unit in found],
        "without_inputs": "input" not in fit,
        "epsilon": quantity(100 * fit["epsilon_theta"].item()),
        "success": bool(known["success"]),
        "rtol": float(known["rtol"]) if law_of(model).is_foundation else math.nan,
        "integrator_error": float(known["integrator_error"]),
        "residual": quantity(known["residual_over_sigma"]),
        "message": known["message"],
    }
