"""The tables of variables and of columns on the site, with unit and meaning.

Variables are described in `products.names`. Columns are those of docs/interface.json and of the code;
`datasets.yaml` states what they mean, and their units by the endings of their names.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from freerock.planning import plan
from freerock.products.names import VARIABLES
from freerock.rotation.flags import BY_HAND, FLAGS
from freerock.tables.columns import RARE_CANDIDATES_COLUMNS, RARE_IMPACTS
from freerock_bench.document import in_markdown

ROOT = Path(__file__).parents[2]
DESCRIBED: dict[str, Any] = YAML(typ="safe", pure=True).load(Path(__file__).with_suffix(".yaml"))
ROWS, COMMON = DESCRIBED["rows"], DESCRIBED["common"]
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


def tables() -> dict[str, list[str]]:
    """Columns of each table, in the order of `ROWS`."""
    listed = json.loads((ROOT / "docs/interface.json").read_text(encoding="utf-8"))["columns"]
    own = {
        "plan.csv": plan.COLUMNS,
    }
    found = {name: (listed | own)[name] for name in ROWS}
    rare = {"candidates.csv": RARE_CANDIDATES_COLUMNS, "pulls.csv": RARE_IMPACTS}
    return found | {name: [*found[name], *rare[name]] for name in rare}


def columns() -> str:
    """The columns that tables share, then a table for each file."""
    heads = ["column", "unit", "meaning"]
    parts = [_section("Columns of several tables", "", heads, [column("", name) for name in COMMON])]
    for table, names in tables().items():
        shared = ", ".join(f"`{name}`" for name in names if name in COMMON)
        text = f"One row for each {ROWS[table]}. It has {shared}, and:\n\n"
        rows = [column(table, name) for name in names if name not in COMMON]
        parts.append(_section(table, text, heads, rows))
    return "\n\n".join(parts)


def column(table: str, name: str) -> Cells:
    """Name, unit and meaning of a column of a table; its unit is what its ending says, or that of the row."""
    unit = next((unit for end, unit in DESCRIBED["units"].items() if name.endswith(end)), "")
    if table and name in DESCRIBED["in_unit_of_row"].split() and "unit" in tables()[table]:
        unit = "`unit`"
    own = DESCRIBED["own"].get(table, {})
    return [f"`{name}`", unit, own.get(name) or (COMMON | DESCRIBED["meanings"])[name]]


def _section(title: str, text: str, heads: Cells, rows: Iterable[Cells]) -> str:
    return f"### {title}\n\n{text}{in_markdown(heads, rows)}"
