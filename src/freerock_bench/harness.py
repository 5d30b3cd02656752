"""One harness of the Monte-Carlo studies: cases of known truth, each analysed, in one long table.

A study says which cases it has and what rows one case gives. Here they run on all cores, are counted, and
their table is written into the documentation.
"""

import math
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit
from freerock.identification.significance_levels import NORMAL_95
from freerock.models.free_parameters import SYMBOLS
from freerock.tables.csvfile import write_csv
from freerock_bench.document import in_markdown, renew
from freerock_bench.virtual_run import Row

NUMBERS = ["case", "parameter", "truth", "value", "stderr", "u", "inside_stderr", "inside"]
"""A row per case, run and parameter: truth, value, stderr (of the noise), u (with all else that is known) in
SI units; inside_stderr, inside: the 95 % interval of either holds the truth. NaN where no fit may be used."""


def covered(frame: pd.DataFrame) -> str:
    """Markdown with a row per case and parameter of a table of `NUMBERS`."""
    heads = ["case", "number", "n", "error", "stderr", "u", "inside ± 1.96 stderr", "inside ± 1.96 u"]
    lines = []
    for row in coverage(frame).itertuples():
        cells = [row.case, SYMBOLS.get(row.parameter, row.parameter), row.n]
        cells += [f"{value:.2g} %" for value in (row.error, row.stderr, row.u)]
        lines.append([*cells, *(f"{value:.0f} %" for value in (row.inside_stderr, row.inside))])
    return in_markdown(heads, lines)


@dataclass(frozen=True)
class Study:
    """A Monte-Carlo study.

    Parameters
    ----------
    cases : callable
        Size ("full" or "small") → the cases, each drawn from a seed of its own.
    rows_of : callable
        Case → its rows, which a module's `COLUMNS` name; none where nothing was fitted.
    columns : list of str
        Of the long table.
    mark : str
        Name of its table in a document.
    markdown : callable
        The long table → that of the document.
    """

    cases: Callable[[str], Sequence[Any]]
    rows_of: Callable[[Any], list[Row]]
    columns: list[str]
    mark: str = ""
    markdown: Callable[[pd.DataFrame], str] = covered

    def run(self, size: str = "full") -> pd.DataFrame:
        """The long table of all cases."""
        return pd.DataFrame(rows_of_all(self.rows_of, self.cases(size)), columns=self.columns)

    def main(self, product: str, size: str, document: str = "") -> None:
        """Measure, write the product, and renew the table of a document where one is named."""
        frame = self.run(size)
        write_csv(frame, Path(product))
        if document:
            renew(document, self.mark, self.markdown(frame))


def rows_of_all(function: Callable[[Any], list[Row]], cases: Sequence[Any]) -> list[Row]:
    """Rows of all cases, on all cores."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # as in the workflow's jobs
    with ProcessPoolExecutor(len(os.sched_getaffinity(0)), multiprocessing.get_context("spawn")) as pool:
        return [row for rows in pool.map(function, cases, chunksize=4) for row in rows]


def number_row(
    case: str, parameter: str, truth: float, value: float, stderr: float, u: float | None = None
) -> Row:
    """A number against its truth; without `u` the standard error is all that is known of it."""
    known, total = math.isfinite(stderr), stderr if u is None else u
    off = abs(value - truth)
    return {
        "case": case,
        "parameter": parameter,
        "truth": truth,
        "value": value if known else math.nan,
        "stderr": stderr,
        "u": total,
        "inside_stderr": off <= NORMAL_95 * stderr if known else math.nan,
        "inside": off <= NORMAL_95 * total if known else math.nan,
    }


def rows_of_fit(case: str, fit: Fit, truth: dict[str, float]) -> list[Row]:
    """Rows of the parameters of a fit; their u holds what the law does not explain, and known inputs."""
    rows = []
    for name, value, stderr, u in zip(fit.parameters, fit.value, fit.stderr, fit.u_total, strict=True):
        if name in truth:
            known = (float(stderr), float(u)) if fit.success else (math.nan, math.nan)
            rows.append(number_row(case, name, truth[name], float(value), *known))
    return rows


def coverage(frame: pd.DataFrame) -> pd.DataFrame:
    """Of each case and parameter over the rows with a number.

    Returns
    -------
    pandas.DataFrame
        Columns case, parameter; n; error, stderr, u: medians in per cent of the truth; inside_stderr, inside:
        shares in per cent; z: root mean square of error over u.
    """
    known = frame.dropna(subset=["inside"])
    off, percent = known["value"] - known["truth"], 100 / known["truth"].abs()
    sizes = {"error": off.abs(), "stderr": known["stderr"], "u": known["u"]}
    shares = {name: 100 * known[name].astype(float) for name in ("inside_stderr", "inside")}
    square = (off / known["u"]) ** 2
    known = known.assign(**{name: each * percent for name, each in sizes.items()}, **shares, z=square)
    taken = {name: (name, "median") for name in sizes} | {name: (name, "mean") for name in (*shares, "z")}
    groups = known.groupby(["case", "parameter"], sort=False)
    found = groups.agg(n=("z", "size"), **taken).reset_index()
    return found.assign(z=np.sqrt(found["z"]))
