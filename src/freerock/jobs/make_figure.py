"""A figure of a campaign: what it shows is read, drawn and saved."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from freerock.figures.listed import entry_of
from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.tables.csvfile import read_csv
from freerock.tables.number_text import SIMULATED_NOTE


def make_figure(
    figure: ModuleType, settings: Mapping[str, Any], files: Mapping[str, Sequence[str | Path]], stem: Path
) -> None:
    """Write a figure as `stem`.pdf and .png, the numbers drawn as .csv, the caption as .txt.

    The first line of a caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    figure : module
        Draws it, with functions draw and caption; its entry in `freerock.figures.listed` has its name. Where
        it reads datasets, `READS` names the variables that it reads of each kind.
    settings : mapping
        origin, labels, scenes (of the datasets), blocks and set_ups: plain values.
    files : mapping
        By kind, of what the figure reads: records and fits, the datasets of all tests, and tables, as CSV.
        Of each scene the first dataset with a usable or fitted run is drawn.
    stem : path
        Files to write, without suffix.
    """
    scenes, origin, labels = (settings[name] for name in ("scenes", "origin", "labels"))
    known: dict[str, Any] = {Path(path).stem: read_csv(path) for path in files["tables"]}
    if files["records"] or files["fits"]:
        known |= _datasets(figure, files, scenes)
    known["blocks"] = {name: Block(**block) for name, block in settings["blocks"].items()}
    known["set_ups"] = settings["set_ups"]
    told = entry_of(figure.__name__.rpartition(".")[2])
    drawn, data = figure.draw(*(known[each] for each in told["reads"]), origin, labels)
    save(drawn, data, stem, origin)
    note = SIMULATED_NOTE if origin == "simulated" else ""
    about = " ".join(filter(None, [told["caption"], figure.caption(data, labels), note]))
    write_text(Path(f"{stem}.txt"), f"{told['title']}.\n{about}\n")


def _datasets(
    figure: ModuleType, files: Mapping[str, Sequence[str | Path]], scenes: Sequence[str]
) -> dict[str, Any]:
    """Records and fits that a figure reads: the first of each scene with a usable or fitted run."""
    # with xarray, which loads in 0.1 s and which figures of tables do not need
    from freerock.products.contents import one_of_each, runs_of, usable_runs
    from freerock.products.netcdf import open_fits, open_record

    kinds = {"records": (open_record, usable_runs), "fits": (open_fits, runs_of)}
    return {
        kind: one_of_each(files[kind], scenes, partial(opened, only=figure.READS[kind]), usable)
        for kind, (opened, usable) in kinds.items()
        if files[kind]
    }
