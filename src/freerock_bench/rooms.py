"""Picture of the rooms: which imports how many modules of which, from the imports themselves.

    python -m freerock_bench.rooms docs/images/rooms.svg

A room imports only rooms that stand to the left of it: nothing lies right of the diagonal.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
from grimp import build_graph
from matplotlib import rc_context
from matplotlib.figure import Figure

from freerock.files import atomic

ROOT = Path(__file__).parents[2]


def rooms() -> list[str]:
    """Names of rooms, in the order in which one may import those before it (import-linter's contract)."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (layers,) = [each["layers"] for each in contracts["contracts"] if "layers" in each]
    names = [name for layer in reversed(layers) for name in layer.replace("|", ":").split(":")]
    return [name.strip().strip("()").rpartition(".")[2] for name in names]


def imports() -> pd.DataFrame:
    """How many modules of each room (row) import a module of each other room (column)."""
    names, graph = rooms(), build_graph("freerock", cache_dir=None)
    found = pd.DataFrame(0, index=names, columns=names)
    for module in graph.modules - {"freerock"}:
        imported = {_room(each) for each in graph.find_modules_directly_imported_by(module)}
        for other in imported & {*names} - {_room(module)}:
            found.loc[_room(module), other] += 1
    return found


def _room(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def draw(found: pd.DataFrame) -> Figure:
    """The matrix: a row says what a room imports."""
    n = len(found)
    figure = Figure(figsize=(7.0, 6.2), layout="constrained")
    ax = figure.subplots()
    counts = found.to_numpy(float)
    ax.imshow(np.where(counts > 0, np.log1p(counts), np.nan), cmap="Blues", vmin=-1.0, vmax=np.log1p(40))
    for (row, column), count in np.ndenumerate(found.to_numpy()):
        if count:
            ax.text(column, row, count, ha="center", va="center", fontsize=7)
    ax.plot([-0.5, n - 0.5], [-0.5, n - 0.5], color="0.6", linewidth=0.8)
    ax.set_xticks(range(n), found.columns, rotation=60, ha="right", fontsize=8)
    ax.set_yticks(range(n), found.index, fontsize=8)
    ax.set_title("modules of a room (row) that import one of another (column)", loc="left", fontsize=9)
    return figure


def main(picture: str) -> None:
    """Draw the picture; the same imports give the same bytes."""
    with rc_context({"svg.hashsalt": "rooms", "svg.fonttype": "none"}), atomic(Path(picture)) as part:
        draw(imports()).savefig(part, format="svg", metadata={"Date": None})


if __name__ == "__main__":
    main(*sys.argv[1:])
