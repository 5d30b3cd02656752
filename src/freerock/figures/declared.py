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
        caption; of a figure of a campaign also title and reads: records, fits, tables by
        name, blocks.
    """
    found = find_spec(module)
    assert found is not None and found.origin is not None, module
    for node in ast.parse(Path(found.origin).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "FIGURE":
            assert isinstance(node.value, ast.Dict), module
            return {_constant(key): _constant(value) for key, value in _pairs(node.value)}
    raise ValueError(f"{module} declares no FIGURE")


def _pairs(node: ast.Dict) -> list[tuple[ast.expr, ast.expr]]:
    return [(key, value) for key, value in zip(node.keys, node.values, strict=True) if key is not None]


def _constant(node: ast.expr) -> Any:
    """A text, or a list of texts."""
    if isinstance(node, ast.List):
        return [_constant(each) for each in node.elts]
    assert isinstance(node, ast.Constant), ast.unparse(node)
    return node.value
