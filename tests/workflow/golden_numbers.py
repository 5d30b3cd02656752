"""A digest of each number and text that an analysed campaign prints, compared with the one kept in `golden`.

    FREEROCK_WRITE=1 python -m pytest tests/workflow -k as_kept

writes the digests anew. Of a column of numbers a digest holds, for each parameter of each law, their count,
the logarithm of their mean size, and a mean whose weights differ from row to row: a change of 2 % of one of
them shows. Of texts it holds a checksum without their digits: the last digit of a rounded number may differ
from machine to machine. A curve may have a sample more there: of equal texts beside curves, one after the
other, one counts.
"""

import json
import math
import os
import re
import zlib
from itertools import groupby
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.tables.csvfile import read_csv

GOLDEN = Path(__file__).parent / "golden"
# From processor to processor a p-value of the shipped campaign differs by 1e-2, all else by up to 5e-3: but
# what is next to nothing, and the lower end of σ_r of a rigid law, which is rejected on a bed.
TOLERANCE = 2e-2
LEAST = {"share_percent": 0.1, "noise_p": 1e-9, "scatter_p": 1e-9}  # a smaller mean size counts as this
COUNTED = {("sigma_r_low", "housner")}  # columns and kinds of which the count alone is kept
OF_COUNT = 1e-3  # of the samples of curves
CURVES = 1000  # rows: a table that has more holds curves
DIGITS = re.compile(r"[-+]?(\d[\d.,]*(e[-+]?\d+)?|nan|inf)")
KINDS = ("model", "parameter", "quantity", "input", "source")  # columns whose values differ in unit or size


def digest_of(column, kinds):
    """Of numbers count, size and weighted mean for each kind of row, in order; of texts a checksum."""
    if column.dtype == bool or not pd.api.types.is_numeric_dtype(column):
        texts = [*map(str, column)]
        if len(texts) > CURVES:
            texts = [text for text, _ in groupby(texts)]
        return f"{zlib.crc32(DIGITS.sub('#', chr(10).join(texts)).encode()):08x}"
    values, weights, found = column.to_numpy(float), np.cos(np.linspace(0, 40, len(column))), []
    for kind in sorted({*kinds}):
        own = np.isfinite(values) & (kinds == kind)
        size = float(np.abs(values[own]).mean()) if own.any() else 0.0
        size = max(size, LEAST.get(column.name, 0.0)) if size and (column.name, kind) not in COUNTED else 0.0
        mean = float((weights * values)[own].mean()) / size if size else 0.0
        found += [int(own.sum()), round(math.log(size), 3) if size else 0.0, round(mean, 3)]
    return found


def digest(results):
    """Of each column of each table, and of the numbers of each figure."""
    found = {}
    for path in sorted([*results.glob("tables/*.csv"), *results.glob("figures/*.csv")]):
        table = read_csv(path)
        kinds = table[[name for name in KINDS if name in table]].astype(str).agg(" ".join, axis=1)
        own = kinds.to_numpy() if len(kinds) else np.full(len(table), "")
        found[f"{path.parent.name}/{path.name}"] = {
            name: digest_of(column, own) for name, column in table.items()
        }
    return found


def close(kept, found):
    """Whether two digests of a column agree."""
    if isinstance(kept, str) or isinstance(found, str) or len(kept) != len(found):
        return kept == found
    counts = np.allclose(kept[::3], found[::3], rtol=OF_COUNT, atol=0)
    return counts and all(np.allclose(kept[i::3], found[i::3], rtol=0, atol=TOLERANCE) for i in (1, 2))


def differences(results, name):
    """Columns whose digest is not the one kept under a name, each with both digests."""
    path, found = GOLDEN / f"{name}.json", digest(results)
    if os.environ.get("FREEROCK_WRITE"):
        path.write_text(as_lines(found), encoding="utf-8")
    kept = json.loads(path.read_text(encoding="utf-8"))
    pairs = {
        f"{file}: {column}": (kept.get(file, {}).get(column, ""), found.get(file, {}).get(column, ""))
        for file in sorted(kept | found)
        for column in kept.get(file, {}) | found.get(file, {})
    }
    return [f"{where}: {one} -> {other}" for where, (one, other) in pairs.items() if not close(one, other)]


def as_lines(digests):
    """JSON with a line for each column."""
    files = []
    for file, columns in digests.items():
        lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(each)}" for name, each in columns.items())
        files.append(f"{json.dumps(file)}: {{\n{lines}\n}}")
    return "{\n" + ",\n".join(files) + "\n}\n"
