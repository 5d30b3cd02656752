"""What a figure's module declares, read without importing it: Snakemake starts without Matplotlib."""

import ast
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any


@cache
def declared(module: str) -> dict[str, Any]:
    """The literal `FIGURE` of a module.

    Parameters
    ----------
    module : str
        Its full name, as `freerock.figures.backbone`.

    Returns
    -------
    dict
        caption; of a figure of a campaign also title and reads: records, fits, maps (of the misfit), tables
        by name, blocks.
    """
    found = find_spec(module)
    assert found is not None and found.origin is not None, module
    for node in ast.parse(Path(found.origin).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "FIGURE":
            return dict(ast.literal_eval(node.value))
    raise ValueError(f"{module} declares no FIGURE")
