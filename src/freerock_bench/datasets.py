"""The tables of variables and of columns on the site, with unit and meaning.

Variables are described in `products.names`, columns in `freerock.columns`; `datasets.yaml` says where a
variable is, and what a row of a table is.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from freerock.columns import Column
from freerock.columns import columns as listed
from freerock.products.names import VARIABLES
from freerock.rotation.flags import BY_HAND, FLAGS
from freerock_bench.document import in_markdown

DESCRIBED: dict[str, Any] = YAML(typ="safe", pure=True).load(Path(__file__).with_suffix(".yaml"))
SEVERAL = 4  # tables, from which on a column is described once for all
Cells = list[str]


def variables() -> str:
    """A table for each file and group: variable, dimensions, unit, content."""
    parts = []
    for where, by_dimensions in DESCRIBED["variables"].items():
        rows = [
            [f"`{name}`", dimensions, VARIABLES[name]["unit"], VARIABLES[name]["long_name"]]
            for dimensions, names in by_dimensions.items()
            for name in names.split()
        ]
        parts.append(_section(where, "", ["variable", "dimensions", "unit", "content"], rows))
    bits = ", ".join(f"{bit} {name.replace('_', ' ')}" for name, bit in (FLAGS | BY_HAND).items())
    return "\n\n".join([*parts, f"Bits of `flags`: {bits}; 0 is valid."])


def columns() -> str:
    """The columns that tables share, then a table for each file."""
    heads = ["column", "unit", "meaning"]
    shared = [each for each in listed() if len(each.files) >= SEVERAL]
    parts = [_section("Columns of several tables", "", heads, map(_cells, shared))]
    for table, of in DESCRIBED["rows"].items():
        own = [each for each in listed() if table in each.files]
        common = ", ".join(f"`{each.name}`" for each in own if each in shared)
        text = f"One row for each {of}. It has {common}, and:\n\n"
        rows = [_cells(each) for each in own if each not in shared]
        parts.append(_section(f"{table}.csv", text, heads, rows))
    return "\n\n".join(parts)


def _cells(column: Column) -> Cells:
    unit = f"`{column.unit}`" if column.unit == "unit" else column.unit
    return [f"`{column.name}`", unit, column.meaning]


def _section(title: str, text: str, heads: Cells, rows: Iterable[Cells]) -> str:
    return f"### {title}\n\n{text}{in_markdown(heads, rows)}"
