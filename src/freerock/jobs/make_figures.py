"""The figures of a campaign: what they show is read once, drawn and saved."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from freerock.figures.captions import caption_of
from freerock.figures.in_order import FIGURES
from freerock.figures.style import save
from freerock.files import write_text
from freerock.models.block import Block
from freerock.products.groups import one_of_each, runs_of, usable_runs
from freerock.products.netcdf import open_fits, open_record
from freerock.tables.csvfile import read_csv
from freerock.tables.number_text import SIMULATED_NOTE

OF_RECORDS = ("time", "theta", "theta0", "release", "end", "frequency", "noise_density")  # shown
OF_FITS = ("time", "theta", "theta_model", "residual", "epsilon_theta")


def make_figures(
    settings: Mapping[str, Any],
    record_files: Sequence[str | Path],
    fit_files: Sequence[str | Path],
    tables: Sequence[str | Path],
    folder: str | Path,
) -> None:
    """Write each figure as .pdf and .png, the numbers drawn as .csv, the caption as .txt.

    The first line of a caption is the figure's title, the second says what is drawn, of which runs and with
    which errors.

    Parameters
    ----------
    settings : mapping
        origin, labels, scenes (of the datasets), blocks and set_ups: plain values.
    record_files, fit_files : sequence of path
        Datasets of all tests: drawn is the first of each scene with a usable or fitted run.
    tables : sequence of path
        CSV files.
    folder : path
        Of the files to write.
    """
    scenes, origin, labels = (settings[name] for name in ("scenes", "origin", "labels"))
    known: dict[str, Any] = {Path(path).stem: read_csv(path) for path in tables}
    known["records"] = one_of_each(record_files, scenes, partial(open_record, only=OF_RECORDS), usable_runs)
    known["fits"] = one_of_each(fit_files, scenes, partial(open_fits, only=OF_FITS), runs_of)
    known["blocks"] = {name: Block(**block) for name, block in settings["blocks"].items()}
    known["set_ups"] = settings["set_ups"]
    note = SIMULATED_NOTE if origin == "simulated" else ""
    for module in FIGURES:
        name = module.__name__.rpartition(".")[2]
        title, about, reads = (caption_of(module.__name__)[key] for key in ("title", "caption", "reads"))
        drawn, data = module.draw(*(known[each] for each in reads), origin, labels)
        save(drawn, data, Path(folder, name), origin)
        told = " ".join(filter(None, [about, module.caption(data, labels), note]))
        write_text(Path(folder, f"{name}.txt"), f"{title}.\n{told}\n")
