"""The report of a campaign: one HTML file that opens without internet."""

import base64
import os
import re
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from freerock.config.review_log import Change
from freerock.files import write_text
from freerock.report.found import printed_records, printed_summary
from freerock.report.limitations import limits
from freerock.report.methods import PAGE_FILES, REFERENCES, bib, cited, methods, methods_markdown
from freerock.report.methods import html as html_of
from freerock.report.printed import printed_tables
from freerock.report.runs import (
    by_hand,
    changes_seen,
    listed,
    printed_choices,
    printed_runs,
    printed_tests,
)
from freerock.runs.verdict import VERDICTS
from freerock.tables.choices import laws_of_foundations
from freerock.tables.number_text import SIMULATED_NOTE

# Symbols with an index, in no name, as mat_foam.
INDEXED = re.compile(r"(?<![A-Za-z0-9_])(ε|t|θ|σ)_(θ|f|th|ex|cr|r)(?![A-Za-z0-9_])")


def write_report(
    path: str | Path,
    *,
    provenance: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    rates_hz: Sequence[float] = (),
    figures: Sequence[tuple[str, str | Path]] = (),
    pages: Mapping[str, str | Path] | None = None,
    changes: Sequence[Change] = (),
    texts: str | Path | None = None,
) -> None:
    """Write the report of a campaign.

    Parameters
    ----------
    path : path
        HTML file to write; replaced in one step.
    provenance : mapping
        inputs, config, software, git and other_software, as in provenance.json; config is the
        campaign's section.
    tables : mapping of str to pandas.DataFrame
        runs, choice, populations, restitution, summary and table1 to table3, as
        `freerock.tables.csvfile.read_csv` gives them.
    rates_hz : sequence of float
        Sampling rates of the records.
    figures : sequence of (str, path)
        Caption, its first line a title, and PNG file of each figure to show.
    pages : mapping of str to path, optional
        File of the quality pages by record, linked relative to `path`.
    changes : sequence of freerock.config.review_log.Change, optional
        What was changed, and looked at, at the review desk.
    texts : path, optional
        Path without suffix where the methods are written with citations, as .md, and what they cite, as .bib.
    """
    config, folder = provenance["config"], Path(path).parent
    environment = Environment(loader=FileSystemLoader(PAGE_FILES), autoescape=True, undefined=StrictUndefined)
    environment.filters |= {"indices": _indices, "cited": html_of}
    paragraphs = methods(config, rates_hz, provenance["software"], provenance["git"])
    names = [Path(file).stem for _, file in figures]
    shows = "foundation_effect" if len(tables["summary"]) > 1 else "comparison"
    first = names.index(shows) if shows in names else None
    ordered = sorted(enumerate(figures), key=lambda each: each[0] != first)
    shown = [_figure(caption, Path(file), folder, n) for n, (_, (caption, file)) in enumerate(ordered, 1)]
    html = environment.get_template("report.html.j2").render(
        _content(config, tables, changes),
        methods=paragraphs,
        references=[REFERENCES[key] for key in cited(paragraphs)],
        picture=None if first is None else shown[0],
        figures=shown if first is None else shown[1:],
        pages={test: os.path.relpath(page, folder) for test, page in (pages or {}).items()},
        inputs=provenance["inputs"],
        other_software=provenance.get("other_software", ()),
    )
    write_text(path, html)
    if texts:
        write_text(f"{texts}.md", methods_markdown(paragraphs))
        write_text(f"{texts}.bib", bib(paragraphs))


def _content(
    config: Mapping[str, Any], tables: Mapping[str, pd.DataFrame], changes: Sequence[Change]
) -> dict[str, Any]:
    """What the page shows of tables and configuration."""
    runs, choice = tables["runs"], tables["choice"]
    labels = {name: each["label"] for name, each in (config["blocks"] | config["foundations"]).items()}
    excluded, some = runs["excluded"].astype(bool), listed(runs)
    counted = runs["verdict"][~excluded].value_counts()
    doi = (config["published"] or {"doi": ""})["doi"]
    laws = laws_of_foundations(choice)
    return {
        "config": config,
        "simulated": config["origin"] == "simulated",
        "simulated_note": SIMULATED_NOTE,
        "summary": printed_summary(tables["summary"], runs, labels),
        "limits": limits(runs, choice, tables["populations"], labels),
        "verdicts": [(each, counted[each]) for each in VERDICTS if each in counted],
        "n_excluded": int(excluded.sum()),
        "n_to_look_at": int(((runs["verdict"] != "ok") & ~excluded).sum()),
        "n_lost": int((runs["run"].isna() & (runs["verdict"] == "fail")).sum()),
        "tables": list(printed_tables(tables, config["origin"], doi=doi, labels=labels).values()),
        "runs": printed_runs(some, choice, labels, len(runs)),
        "told": [row for row in some.itertuples() if row.reasons],
        "choices": printed_choices(choice, some),
        "tests": printed_tests(choice, some),
        "records": printed_records(tables["populations"], laws, labels),
        "by_hand": by_hand(changes, config),
        "looked": changes_seen(changes, runs),
    }


def _indices(text: str) -> Markup:
    """A text of the report's own with its indices below the line; no number leaves its = or %."""
    shown = re.sub(r" (?=[=≤] )|(?<=[=≤]) | (?=%)", "\N{NO-BREAK SPACE}", str(escape(text)))
    return Markup(INDEXED.sub(r"\1<sub>\2</sub>", shown))


def _figure(caption: str, file: Path, folder: Path, n: int) -> dict[str, Any]:
    """A figure with its number, from 1."""
    title, _, text = caption.replace(SIMULATED_NOTE, "").partition("\n")  # the page's head says it of all
    png = file.read_bytes()
    width, height = struct.unpack(">II", png[16:24])
    image = {"width": width, "height": height, "data": base64.b64encode(png).decode()}
    pdf = os.path.relpath(file.with_suffix(".pdf"), folder)
    return image | {"caption": f"Figure {n}. {title}", "text": text, "file": pdf}
