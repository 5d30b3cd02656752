"""A figure of a campaign: what its module asks for is read, drawn and saved."""

import inspect
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import Any

from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.products.groups import one_of_each, runs_of, usable_runs
from freerock.products.netcdf import open_fits, open_record
from freerock.tables.csvfile import read_csv
from freerock.tables.paper import SIMULATED_NOTE


def make_figure(
    figure: ModuleType,
    files: Mapping[str, str | Sequence[str]],
    settings: Mapping[str, Any],
    stem: str,
    target: str = "double_column",
) -> None:
    """Write a figure as `stem`.pdf and .png, the numbers drawn as .csv, its caption as .txt.

    The first line of the caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    figure : module
        One of `freerock.figures`. Its function `draw` names as its arguments what it takes of files and
        settings; its function `caption` says of the numbers drawn what no other campaign shares; its function
        `read` opens maps. Of records or fits it gets the first of each scene with a
        usable or fitted run.
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
    drawn, data = figure.draw(
        **{name: value for name, value in known.items() if name in asked}, target=target
    )
    save(drawn, data, stem, settings["origin"], target=target)
    own = figure.caption(data, settings["labels"])
    simulated = SIMULATED_NOTE if settings["origin"] == "simulated" else ""
    told = " ".join(filter(None, [settings["caption"], own, simulated]))
    write_text(f"{stem}.txt", f"{settings['title']}.\n{told}\n")


def _read(figure: ModuleType, name: str, paths: str | Sequence[str], settings: Mapping[str, Any]) -> Any:
    """Datasets of one kind, or a table."""
    if name == "records":
        return one_of_each(paths, settings["scenes"], open_record, usable_runs)
    if name == "fits":
        return one_of_each(paths, settings["scenes"], open_fits, runs_of)
    return figure.read(paths) if name == "maps" else read_csv(str(paths))
