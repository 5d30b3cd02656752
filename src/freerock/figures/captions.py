"""Titles and captions of figures, read without their modules: Snakemake starts without Matplotlib."""

import tomllib
from pathlib import Path
from typing import Any

_CAPTIONS = tomllib.loads(Path(__file__).with_name("captions.toml").read_text(encoding="utf-8"))
FIGURES = (*_CAPTIONS,)
"""Figures of a campaign, in the order of the report."""
_NO_TABLES = ("records", "fits", "blocks", "set_ups")


def caption_of(figure: str) -> dict[str, Any]:
    """What a figure is called, what it shows, and what is read for it.

    Parameters
    ----------
    figure : str
        Its name, one of `FIGURES`.

    Returns
    -------
    dict
        title, caption and reads: records, fits, tables by name, blocks, set_ups.
    """
    found: dict[str, Any] = _CAPTIONS[figure]
    return found


def tables_of(figure: str) -> list[str]:
    """Names of the tables that a figure reads."""
    return [each for each in caption_of(figure)["reads"] if each not in _NO_TABLES]
