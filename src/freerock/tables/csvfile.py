"""Tables as CSV files: the same bytes for the same numbers, and names that stay texts when read back."""

import math
from pathlib import Path

import pandas as pd

from freerock.errors import FreerockError
from freerock.files import atomic

NAMES = ["campaign", "test", "run", "block", "foundation", "model"]  # 001 is one too
NAMES += ["parameter", "unit", "motion"]
# true or false, which an empty column does not say
YES_OR_NO = ["success", "excluded", "selected", "explains", "rejected"]


def write_csv(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a frame as CSV, the same bytes for the same numbers.

    Parameters
    ----------
    frame : pandas.DataFrame
        The table.
    path : path
        File to write; replaced in one step.
    """
    texts = {
        name: ["" if math.isnan(value) else f"{value:.10g}" for value in frame[name].tolist()]
        for name in frame.select_dtypes("float")
    }  # pandas' own float_format takes twice as long
    with atomic(path) as part:
        frame.assign(**texts).to_csv(part, index=False, float_format="%.10g", lineterminator="\n")


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read a table written by `write_csv`; names are texts, run numbers too.

    Parameters
    ----------
    path : path
        CSV file.

    Raises
    ------
    FreerockError
        There is no such file: a job that was killed has not ended yet, or someone deleted it.
    """
    text = dict.fromkeys((*NAMES, "reasons", "reason"), str)
    try:
        frame = pd.read_csv(path, dtype=text, keep_default_na=False, na_values=[""])  # NA is a name
    except FileNotFoundError:
        raise FreerockError(path, "there is no such file", "run snakemake again") from None
    frame = frame.fillna({column: "" for column in ("reasons", "reason") if column in frame})
    return frame.astype({column: bool for column in YES_OR_NO if column in frame and frame.empty})
