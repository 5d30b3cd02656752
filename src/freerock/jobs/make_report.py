"""The report of a campaign, and what made its products, with the checksums of all."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from freerock.config.review_log import read_changes
from freerock.files import sha256, write_json, write_text
from freerock.products.provenance import provenance_of_campaign
from freerock.products.root_text import root_text
from freerock.report.document import figures_tex, paper_tex
from freerock.report.page import write_report
from freerock.tables.csvfile import read_csv


def make_report(
    settings: Mapping[str, Any],
    datasets: Mapping[str, Sequence[str | Path]],
    tables: Mapping[str, str | Path],
    figures: Sequence[tuple[str | Path, str | Path]],
    pages: Mapping[str, str | Path],
    output: Mapping[str, str],
    *,
    products: Iterable[str] = (),
    changes: str | Path | None = None,
) -> None:
    """Write the report of a campaign, its provenance, and LaTeX of all figures and of the paper's.

    Parameters
    ----------
    settings : mapping
        campaign, its section of the configuration as plain values.
    datasets : mapping of str to (path, path)
        Record and fit dataset of each test.
    tables : mapping of str to path
        CSV file by name of the table.
    figures : sequence of (path, path)
        Captions and PNG files, in the order of the report.
    pages : mapping of str to path
        Quality page of each test.
    output : mapping of str to path
        html, provenance, captions, paper, methods and references, the files to write.
    products : iterable of path
        All other products of the campaign, whose checksums go into the provenance.
    changes : path, optional
        Log of what was changed at the review desk.
    """
    own = provenance_of_campaign(settings["campaign"], datasets)
    rates = [float(root_text(record, "sampling_rate_hz", "0")) for record, _ in datasets.values()]
    told = {Path(png).stem: Path(text).read_text(encoding="utf-8").rstrip("\n") for text, png in figures}
    captions = {name: (text.partition("\n")[0], text.partition("\n")[2]) for name, text in told.items()}
    frames = {name: read_csv(path) for name, path in tables.items()}
    write_text(output["captions"], figures_tex(captions))
    write_text(output["paper"], paper_tex(captions, len(frames["summary"])))
    write_report(
        output["html"],
        provenance=own,
        tables=frames,
        rates_hz=[rate for rate in rates if rate],
        figures=[(told[Path(png).stem], png) for _, png in figures],
        pages=pages,
        changes=read_changes(changes) if changes else (),
        texts=Path(output["methods"]).with_suffix(""),
    )
    made = sorted({*products, *(path for name, path in output.items() if name != "provenance")})
    write_json(output["provenance"], own | {"products": {path: sha256(path) for path in made}})
