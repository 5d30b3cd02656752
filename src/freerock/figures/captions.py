"""Titles and captions of figures, read without their modules: Snakemake starts without Matplotlib."""

import tomllib
from pathlib import Path
from typing import Any

_CAPTIONS = tomllib.loads(Path(__file__).with_name("captions.toml").read_text(encoding="utf-8"))
FIGURES = (*_CAPTIONS,)
"""Figures of a campaign, in the order of the report."""


def caption_of(module: str) -> dict[str, Any]:
    """What a figure is called, what it shows, and what is read for it.

    Parameters
    ----------
    module : str
        Full name of the module that draws it, as `freerock.figures.backbone`.

    Returns
    -------
    dict
        title, caption and reads: records, fits, tables by name, blocks, set_ups.
    """
    found: dict[str, Any] = _CAPTIONS[module.rpartition(".")[2]]
    return found


def drawn_tables() -> list[str]:
    """Names of the tables that the figures of a campaign read."""
    read = {each for caption in _CAPTIONS.values() for each in caption["reads"]}
    return sorted(read - {"records", "fits", "blocks", "set_ups"})
