"""A digest of each number and text that an analysed campaign prints, compared with the one kept in `golden`.

    FREEROCK_WRITE=1 python -m pytest tests/workflow -k as_kept

writes the digests anew. Of a column of numbers a digest holds count, logarithm of the size, and a mean whose
weights differ from row to row; both of each parameter in its own unit. Of texts it holds a checksum without
their digits: the last of a rounded number may differ from machine to machine.
"""

import json
import math
import os
import re
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from freerock.tables.csvfile import read_csv

GOLDEN = Path(__file__).parent / "golden"
TOLERANCE = 3e-3  # of the size: without AVX the shipped campaign differs by up to 1.3e-3
DIGITS = re.compile(r"[-+]?(\d[\d.,]*(e[-+]?\d+)?|nan|inf)")
KINDS = ("parameter", "quantity", "input")  # columns whose values differ in unit


def digest_of(column, kinds):
    """Of numbers count, size and weighted mean, averaged over kinds of row; of texts a checksum."""
    if column.dtype == bool or not pd.api.types.is_numeric_dtype(column):
        return f"{zlib.crc32(DIGITS.sub('#', chr(10).join(map(str, column))).encode()):08x}"
    values = column.to_numpy(float)
    there, weights = np.isfinite(values), np.cos(np.arange(len(values)))
    sizes, means = [], []
    for kind in np.unique(kinds[there]):
        own = there & (kinds == kind)
        if size := np.abs(values[own]).mean():
            sizes.append(math.log(size))
            means.append((weights * values)[own].mean() / size)
    return [int(there.sum()), *(round(float(np.mean(each)), 6) if each else 0.0 for each in (sizes, means))]


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
    if isinstance(kept, str) or isinstance(found, str):
        return kept == found
    return kept[0] == found[0] and np.allclose(kept[1:], found[1:], rtol=0, atol=TOLERANCE)


def differences(results, name):
    """Columns whose digest is not the one kept under a name, with both."""
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
