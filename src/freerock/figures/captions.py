"""Titles and captions of figures, read without their modules: Snakemake starts without Matplotlib."""

import tomllib
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any


def caption_of(module: str) -> dict[str, Any]:
    """What a figure is called, what it shows, and what is read for it.

    Parameters
    ----------
    module : str
        Full name of the module that draws it, as `freerock.figures.backbone`.

    Returns
    -------
    dict
        caption; of a figure of a campaign also title and reads: records, fits, tables by name,
        blocks, set_ups.
    """
    package, _, name = module.rpartition(".")
    found: dict[str, Any] = _table(package)[name]
    return found


def drawn_tables() -> list[str]:
    """Names of the tables that the figures of a campaign read."""
    read = {each for name in FIGURES for each in caption_of(f"freerock.figures.{name}")["reads"]}
    return sorted(read - {"records", "fits", "blocks", "set_ups"})


@cache
def _table(package: str) -> dict[str, Any]:
    spec = find_spec(package)
    assert spec is not None and spec.origin is not None, package
    return tomllib.loads(Path(spec.origin).with_name("captions.toml").read_text(encoding="utf-8"))


FIGURES = (*_table("freerock.figures"),)
"""Figures of a campaign, in the order of the report."""
