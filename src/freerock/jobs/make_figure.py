"""A figure of a campaign: what its module requires is read, drawn and saved."""

import inspect
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv
from freerock.tables.number_text import SIMULATED_NOTE


def make_figure(
    figure: ModuleType,
    files: Mapping[str, str | Sequence[str]],
    settings: Mapping[str, Any],
    stem: str | Path,
) -> None:
    """Write a figure as .pdf and .png, the numbers drawn as .csv, the caption as .txt.

    The first line of a caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    figure : module
        Of `freerock.figures`. Its function `draw` names as its arguments what it takes of files and
        settings; its function `caption` says of the numbers drawn what no other campaign shares. Of records
        or fits it gets the first of each scene with a usable or fitted run; of these the variables of
        `OF_RECORDS` or `OF_FITS`, where it names them.
    files : mapping
        Paths: datasets of all tests under "records" or "fits", tables under their names.
    settings : mapping
        origin, labels, title, caption, and what the figure needs of scenes (of the datasets), blocks,
        set_ups and debonding.
    stem : path
        Of the files to write, without suffix.
    """
    known = {name: _read(name, paths, figure, settings) for name, paths in files.items()}
    known |= {name: value for name, value in settings.items() if name != "scenes"}
    if "blocks" in settings:
        known["blocks"] = {name: Block(**block) for name, block in settings["blocks"].items()}
    asked = inspect.signature(figure.draw).parameters
    drawn, data = figure.draw(**{name: value for name, value in known.items() if name in asked})
    save(drawn, data, stem, settings["origin"])
    simulated = SIMULATED_NOTE if settings["origin"] == "simulated" else ""
    told = [settings["caption"], figure.caption(data, settings["labels"]), simulated]
    write_text(f"{stem}.txt", f"{settings['title']}.\n{' '.join(filter(None, told))}\n")


def _read(kind: str, paths: str | Sequence[str], figure: ModuleType, settings: Mapping[str, Any]) -> Any:
    """A table, or the datasets that a figure shows with what it takes of them."""
    if kind not in ("records", "fits"):
        return read_csv(str(paths))
    # figures of tables need no xarray, which takes a third of a second
    from freerock.products.groups import one_of_each, runs_of, usable_runs
    from freerock.products.netcdf import open_fits, open_record

    opened, usable = (open_record, usable_runs) if kind == "records" else (open_fits, runs_of)
    only = getattr(figure, f"OF_{kind.upper()}", ())
    return one_of_each(paths, settings["scenes"], partial(opened, only=only), usable)
