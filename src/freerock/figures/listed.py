"""Returns the figures of a campaign from `figures.toml`, their titles and captions, without their modules.

So Snakemake starts without Matplotlib.
"""

import tomllib
from pathlib import Path
from typing import Any

_LISTED = tomllib.loads(Path(__file__).with_name("figures.toml").read_text(encoding="utf-8"))
FIGURES = (*_LISTED,)
"""Figures of a campaign, in the order of the report."""
_NO_TABLES = ("records", "fits", "blocks", "set_ups")


def entry_of(figure: str) -> dict[str, Any]:
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
    found: dict[str, Any] = _LISTED[figure]
    return found


def tables_of(figure: str) -> list[str]:
    """Names of the tables that a figure reads."""
    return [each for each in entry_of(figure)["reads"] if each not in _NO_TABLES]
