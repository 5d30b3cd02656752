"""One harness of the Monte-Carlo studies: cases of known truth, each analysed, in one long table of numbers.

A study says which cases it has and what rows one case gives. Here they run on all cores, are counted, and the
table of coverage is written into the documentation; `figures.coverage` draws it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from freerock.identification.fit import Fit
from freerock.identification.levels import NORMAL_95
from freerock.models.laws import SYMBOLS
from freerock_bench.document import in_markdown, publish
from freerock_bench.virtual_run import Row, rows_of_all

NUMBERS = ["case", "parameter", "truth", "value", "stderr", "u", "inside_stderr", "inside"]


@dataclass(frozen=True)
class Study:
    """A Monte-Carlo study.

    Parameters
    ----------
    cases : callable
        Size ("full" or "small") → the cases, each drawn from a seed of its own.
    rows_of : callable
        Case → its rows, by `number_row`, with the study's own columns; none where nothing was fitted.
    columns : list of str
        The study's own columns.
    mark : (str, str)
        Lines of a document between which the table stands.
    """

    cases: Callable[[str], Sequence[Any]]
    rows_of: Callable[[Any], list[Row]]
    columns: list[str]
    mark: tuple[str, str] = ("", "")

    def run(self, size: str = "full") -> pd.DataFrame:
        """The long table of all cases: `NUMBERS`, then the study's own columns.

        Returns
        -------
        pandas.DataFrame
            A row per case, run and parameter: truth, value, stderr (of the noise), u (with all else that is
            known) in SI units; inside_stderr, inside: the 95 % interval of either holds the truth. NaN where
            a fit may not be used.
        """
        rows = rows_of_all(self.rows_of, self.cases(size))
        return pd.DataFrame(rows, columns=[*NUMBERS, *self.columns])

    def main(self, product: str, size: str, document: str = "") -> None:
        """Measure, write the product, and renew the table of a document where one is named."""
        publish(self.run, self.mark, self.markdown, product, size, document)

    def markdown(self, frame: pd.DataFrame) -> str:
        """A row per case and parameter."""
        heads = ["case", "number", "n", "error", "stderr", "u", "inside ± 1.96 stderr", "inside ± 1.96 u"]
        lines = []
        for row in coverage(frame).itertuples():
            cells = [row.case, SYMBOLS.get(row.parameter, row.parameter), row.n]
            cells += [f"{value:.2g} %" for value in (row.error, row.stderr, row.u)]
            lines.append([*cells, *(f"{value:.0f} %" for value in (row.inside_stderr, row.inside))])
        return in_markdown(heads, lines)


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
    """Rows of the parameters of a fit; their u holds what the law does not explain."""
    rows = []
    for at, name in enumerate(fit.parameters):
        if name in truth:
            stderr = float(fit.stderr[at]) if fit.success else math.nan
            u = math.hypot(stderr, float(fit.discrepancy[at]))
            rows.append(number_row(case, name, truth[name], float(fit.value[at]), stderr, u))
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
    rows = []
    for (case, parameter), own in known.groupby(["case", "parameter"], sort=False):
        off = own["value"] - own["truth"]
        percent = {"error": off, "stderr": own["stderr"], "u": own["u"]}
        rows.append(
            {
                "case": case,
                "parameter": parameter,
                "n": len(own),
                **{name: 100 * (each / own["truth"]).abs().median() for name, each in percent.items()},
                **{name: 100 * own[name].astype(float).mean() for name in ("inside_stderr", "inside")},
                "z": float(np.sqrt(np.mean((off / own["u"]) ** 2))),
            }
        )
    columns = ["case", "parameter", "n", "error", "stderr", "u", "inside_stderr", "inside", "z"]
    return pd.DataFrame(rows, columns=columns)
