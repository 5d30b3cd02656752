"""Figures of a campaign: what their modules require is read once, drawn and saved.

A figure is a module of `freerock.figures`; `config.figure_names` lists them.
"""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv
from freerock.tables.number_text import SIMULATED_NOTE


def make_figures(
    figures: Iterable[ModuleType],
    files: Mapping[str, str | Sequence[str]],
    settings: Mapping[str, Mapping[str, Any]],
    folder: str | Path,
) -> None:
    """Write figures in a folder as .pdf and .png, the numbers drawn as .csv, the captions as .txt.

    The first line of a caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    figures : iterable of module
        Of `freerock.figures`. Its function `draw` names as its arguments what it takes of files and
        settings; its function `caption` says of the numbers drawn what no other campaign shares. Of records
        or fits it gets the first of each scene with a usable or fitted run; of these the variables of
        `OF_RECORDS` or `OF_FITS`, where it names them.
    files : mapping
        Paths: datasets of all tests under "records" or "fits", tables under their names.
    settings : mapping
        By name of a figure: origin, labels, title, caption, and what the figure needs of scenes (of the
        datasets), blocks, set_ups and debonding.
    folder : path
    """
    figures = list(figures)
    read: dict[str, Any] = {}
    for figure in figures:
        name = figure.__name__.rpartition(".")[2]
        for kind in figure.FIGURE["reads"]:
            if kind in files and kind not in read:
                read[kind] = _read(kind, files[kind], figures, settings[name])
        _make(figure, read, settings[name], f"{folder}/{name}")


def _make(figure: ModuleType, read: Mapping[str, Any], settings: Mapping[str, Any], stem: str) -> None:
    known = {**read} | {name: value for name, value in settings.items() if name != "scenes"}
    if "blocks" in settings:
        known["blocks"] = {name: Block(**block) for name, block in settings["blocks"].items()}
    asked = inspect.signature(figure.draw).parameters
    taken = {name: value for name, value in known.items() if name in asked}
    drawn, data = figure.draw(**taken)
    save(drawn, data, stem, settings["origin"])
    own = figure.caption(data, settings["labels"])
    simulated = SIMULATED_NOTE if settings["origin"] == "simulated" else ""
    told = " ".join(filter(None, [settings["caption"], own, simulated]))
    write_text(f"{stem}.txt", f"{settings['title']}.\n{told}\n")


def _read(
    kind: str, paths: str | Sequence[str], figures: Iterable[ModuleType], settings: Mapping[str, Any]
) -> Any:
    """Datasets of one kind with what any of the figures takes of them, or a table."""
    taking = [figure for figure in figures if kind in figure.FIGURE["reads"]]
    if kind not in ("records", "fits"):
        return read_csv(str(paths))
    # figures of tables need no xarray, which takes a third of a second
    from freerock.products.groups import one_of_each, runs_of, usable_runs
    from freerock.products.netcdf import open_fits, open_record

    opened, usable = (open_record, usable_runs) if kind == "records" else (open_fits, runs_of)
    wanted = [getattr(figure, f"OF_{kind.upper()}", ()) for figure in taking]
    only = tuple(dict.fromkeys(name for names in wanted for name in names)) if all(wanted) else ()
    return one_of_each(paths, settings["scenes"], partial(opened, only=only), usable)
