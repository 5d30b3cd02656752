"""Pages of a figure: none higher than a journal's, and for a talk one for each block."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import pandas as pd

Scene = tuple[str, str]
"""A block on a foundation."""
Drawn = TypeVar("Drawn", bound=tuple[Any, ...])

HIGHEST_MM = 220.0  # of a figure in a journal, with its caption below


def pages(draw: Callable[..., Drawn], taken: Mapping[str, Any], talk: bool = False) -> list[Drawn]:
    """Draw a figure on as few pages as keep each within a journal's page.

    Pages divide the blocks; of one block, or where pages of one block are still too high, its foundations.

    Parameters
    ----------
    draw : callable
        Draws what it is given by name; returns a figure and its numbers.
    taken : mapping
        Tables, lists of datasets and mappings by block: what the figure takes, by the name of its argument.
    talk : bool
        Whether to draw a page for each block, whatever their height.

    Returns
    -------
    list of (Figure, pandas.DataFrame)
    """
    scenes = _scenes(taken)
    blocks = list(dict.fromkeys(block for block, _ in scenes))

    def divided(n: int) -> list[Drawn]:
        parts = [{*part.tolist()} for part in np.array_split(blocks, n)] if n <= len(blocks) else []
        of_blocks = [[scene for scene in scenes if scene[0] in part] for part in parts]
        return [draw(**_of_page(taken, {*page})) for page in of_blocks or [[scene] for scene in scenes]]

    if talk and scenes:
        of_datasets = len(blocks) == 1 and any(isinstance(each, list) for each in taken.values())
        return divided(len(blocks) + of_datasets)
    drawn = [draw(**taken)]
    while (n := _needed(drawn)) > len(drawn) < len(scenes):
        drawn = divided(n)
    return drawn


def _needed(drawn: Sequence[tuple[Any, ...]]) -> int:
    """Pages that their heights require; at least one more where one of several is too high."""
    heights_mm = [25.4 * figure.get_figheight() for figure, *_ in drawn]
    if max(heights_mm) <= HIGHEST_MM:
        return len(drawn)
    return max(len(drawn) + 1, int(np.ceil(sum(heights_mm) / HIGHEST_MM)))


def _scenes(taken: Mapping[str, Any]) -> list[Scene]:
    """Blocks on foundations of the datasets, or else of the tables."""
    datasets = [each for value in taken.values() if isinstance(value, list) for each in value]
    scenes = [_scene(each) for each in datasets]
    for table in () if scenes else taken.values():
        if isinstance(table, pd.DataFrame) and "block" in table:
            scenes += table[["block", "foundation"]].dropna().itertuples(index=False, name=None)
    if not scenes and "set_ups" in taken:
        scenes = [(block, "") for block in taken["set_ups"]]
    return list(dict.fromkeys(scenes))


def _scene(dataset: Any) -> Scene:
    """Block and foundation of a dataset or a misfit map."""
    of = dataset.attrs if hasattr(dataset, "attrs") else vars(dataset)
    return of["block"], of["foundation"]


def _of_page(taken: Mapping[str, Any], page: set[Scene]) -> dict[str, Any]:
    """What is shown on a page: datasets of its scenes, rows and set-ups of its blocks."""
    blocks = {block for block, _ in page}

    def shown(name: str, value: Any) -> Any:
        if isinstance(value, list):
            return [each for each in value if _scene(each) in page]
        if isinstance(value, pd.DataFrame) and "block" in value:
            return value[value["block"].isna() | value["block"].isin(blocks)]  # no block: of a foundation
        return {each: value[each] for each in value if each in blocks} if name == "set_ups" else value

    return {name: shown(name, value) for name, value in taken.items()}
