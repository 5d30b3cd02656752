"""A figure of a campaign: what its module requires is read, drawn and saved."""

import inspect
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from types import ModuleType
from typing import Any

import pandas as pd

from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv
from freerock.tables.text import SIMULATED_NOTE

SLIDE = "slide"


def make_figure(
    figure: ModuleType,
    files: Mapping[str, str | Sequence[str]],
    settings: Mapping[str, Any],
    stem: str,
    target: str = "double_column",
) -> None:
    """Write a figure as `stem`.pdf and .png, the numbers drawn as .csv, its caption as .txt.

    For slides the figure has a page for each block, and for each foundation where it is of one block.
    The first line of the caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    figure : module
        One of `freerock.figures`. Its function `draw` names as its arguments what it takes of files and
        settings; its function `caption` says of the numbers drawn what no other campaign shares; its function
        `read` opens maps. Of records or fits it gets the first of each scene with a
        usable or fitted run; of these the variables of `OF_RECORDS` or `OF_FITS`, where it names them.
    files : mapping
        Paths: datasets of all tests under "records" or "fits", misfit maps under "maps", tables under their
        names.
    settings : mapping
        origin, labels, title, caption, and what the figure needs of scenes (of the datasets) and blocks.
    stem : str
    target : str
        What it is drawn for, see `freerock.figures.style`.
    """
    known = {name: _read(figure, name, paths, settings) for name, paths in files.items()}
    known |= {name: value for name, value in settings.items() if name != "scenes"}
    if "blocks" in settings:
        known["blocks"] = {name: Block(**block) for name, block in settings["blocks"].items()}
    asked = inspect.signature(figure.draw).parameters
    taken = {name: value for name, value in known.items() if name in asked}
    parts = [*_parts(taken)] if target == SLIDE else [taken]
    drawn = [figure.draw(**part, target=target) for part in parts]
    data = pd.concat([numbers for _, numbers in drawn], ignore_index=True).drop_duplicates()
    save([each for each, _ in drawn], data, stem, settings["origin"], target=target)
    own = figure.caption(data, settings["labels"])
    simulated = SIMULATED_NOTE if settings["origin"] == "simulated" else ""
    told = " ".join(filter(None, [settings["caption"], own, simulated]))
    write_text(f"{stem}.txt", f"{settings['title']}.\n{told}\n")


def _parts(taken: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """What a figure takes, for one page of a talk after the other: of each block, or foundation if it is of
    one block."""
    datasets = [each for value in taken.values() if isinstance(value, list) for each in value]
    tables = [value for value in taken.values() if isinstance(value, pd.DataFrame) and "block" in value]
    scenes = [_scene(each) for each in datasets]
    for table in () if scenes else tables:
        scenes += table[["block", "foundation"]].dropna().itertuples(index=False, name=None)
    blocks = dict.fromkeys(block for block, _ in scenes)
    pages = [{block} for block in blocks]
    if datasets and len(blocks) == 1:
        pages = [{block, foundation} for block, foundation in dict.fromkeys(scenes)]
    for page in pages or [set()]:
        yield {name: _of_page(value, page) for name, value in taken.items()}


def _scene(dataset: Any) -> tuple[str, str]:
    """Block and foundation of a dataset or a misfit map."""
    if hasattr(dataset, "attrs"):
        return dataset.attrs["block"], dataset.attrs["foundation"]
    return dataset.block, dataset.foundation


def _of_page(value: Any, page: set[str]) -> Any:
    """What of tables and datasets is shown on a page: of its block, and perhaps of its foundation alone."""
    if isinstance(value, list) and page:
        return [each for each in value if page <= {*_scene(each)}]
    if isinstance(value, pd.DataFrame) and "block" in value and page:
        kept = value["block"].isna() | value["block"].isin(page)  # of all records of a foundation: no block
        return value[kept]
    return value


def _read(figure: ModuleType, name: str, paths: str | Sequence[str], settings: Mapping[str, Any]) -> Any:
    """Datasets of one kind, or a table."""
    if name not in ("records", "fits"):
        return figure.read(paths) if name == "maps" else read_csv(str(paths))
    # figures of tables need no xarray, which takes a third of a second
    from freerock.products.groups import one_of_each, runs_of, usable_runs
    from freerock.products.netcdf import open_fits, open_record

    opened, usable = (open_record, usable_runs) if name == "records" else (open_fits, runs_of)
    shown = partial(opened, only=getattr(figure, f"OF_{name.upper()}", ()))
    return one_of_each(paths, settings["scenes"], shown, usable)
