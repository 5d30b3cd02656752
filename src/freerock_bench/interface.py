"""The public interface: names that scripts, configurations and readers of products rely on, as one file.

    python -m freerock_bench.interface RESULTS docs/interface.json

writes it anew from the package and the products of an analysed campaign. `tests` refuse a name that is gone.
"""

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from pathlib import Path
from typing import Any

import freerock
from freerock.cli.subcommands import COMMANDS
from freerock.config.campaign import ConfigFile
from freerock.config.keys_of_campaign import CampaignFile
from freerock.config.record import Record
from freerock.config.reference import json_schema
from freerock.config.values import Section
from freerock.products.netcdf import open_fits, open_record
from freerock.tables.csvfile import read_csv

FILES: dict[str, type[Section]] = {"config.yaml": ConfigFile, "campaign": CampaignFile}
Names = dict[str, list[str]]


def of_package() -> dict[str, Names]:
    """Python names, commands and configuration keys; a key is its path, with * for a name of the user's."""
    keys = {name: sorted(set(_keys(json_schema(model)))) for name, model in FILES.items()}
    named = {name: getattr(freerock, name) for name in sorted(freerock.__all__)}
    return {
        "python": {"freerock": [*named]},
        "parameters": {name: _parameters(each) for name, each in named.items() if callable(each)},
        "commands": {"freerock": sorted(COMMANDS)},
        "keys": keys | {"campaign.csv": list(Record.model_fields)},
    }


def of_products(results: Path) -> dict[str, Names]:
    """Columns of the tables and variables of the datasets of an analysed campaign."""
    columns, variables = {}, {}
    for path in sorted((results / "tables").glob("*.csv")):
        columns[path.name] = [*read_csv(path)]
    for kind, opened in (("records", open_record), ("fits", open_fits)):
        found: set[str] = set()
        for path in sorted((results / kind).glob("*.nc")):
            found |= {str(name) for node in opened(path).subtree for name in node.variables}
        variables[kind] = sorted(found)
    return {"columns": columns, "variables": variables}


def gone(then: Mapping[str, Names], now: Mapping[str, Names]) -> list[str]:
    """Names of an earlier interface that a later one lacks, as `kind: file: name`."""
    return [
        f"{kind}: {where}: {name}"
        for kind, files in then.items()
        if kind in now
        for where, names in files.items()
        for name in names
        if name not in now[kind].get(where, [])
    ]


def _parameters(of: Callable[..., Any]) -> list[str]:
    """Parameters of a function or class; those with a default end with "="."""
    own = signature(of).parameters.values()
    return [each.name + "=" * (each.default is not each.empty) for each in own]


def _keys(schema: Mapping[str, Any], path: str = "", root: Mapping[str, Any] | None = None) -> Iterator[str]:
    root = root or schema
    if "$ref" in schema:
        named = root["$defs"][schema["$ref"].rpartition("/")[2]]
        yield from _keys(named, path, root)
    for part in (*schema.get("anyOf", ()), *schema.get("allOf", ())):
        yield from _keys(part, path, root)
    for name, inner in schema.get("properties", {}).items():
        yield f"{path}{name}"
        yield from _keys(inner, f"{path}{name}.", root)
    for inner in (schema.get("additionalProperties"), *schema.get("patternProperties", {}).values()):
        if isinstance(inner, dict):
            yield from _keys(inner, f"{path}*.", root)


if __name__ == "__main__":
    names = {"version": "1.0"} | of_package() | of_products(Path(sys.argv[1]))
    Path(sys.argv[2]).write_text(json.dumps(names, indent=1) + "\n", encoding="utf-8")
