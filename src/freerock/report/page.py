"""The report of a campaign: one HTML file that opens without internet."""

import base64
import io
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from PIL import Image

from freerock.config.review_log import Change
from freerock.figures.looks import on_screen, scripts_folder
from freerock.files import write_text
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, LAWS, law_of
from freerock.report import tables as made
from freerock.report.beside_published import beside_published
from freerock.report.facts import counts, facts, free_besides, settings
from freerock.report.findings import findings, laws_of_foundations
from freerock.report.key_figure import key_figure
from freerock.report.methods import PAGE_FILES, REFERENCES, bib, cited, methods, methods_markdown
from freerock.report.methods import html as html_of
from freerock.report.numbers import plain
from freerock.report.records import Listed, charted, listed_records, sections_of
from freerock.report.scene_choices import unexplained
from freerock.report.scene_evidence import explained, scenes_of, together
from freerock.runs.verdict import VERDICTS
from freerock.tables.number_text import SEEN_NOTE, SIMULATED_NOTE
from freerock.tables.printed_tables import PUBLISHED_NOTE, named, of_other_laws, printed_tables

MOST_LISTED = 120  # runs with rows and fits in the page, up to 6 kB each; all stand in the tables
MOST_CHARTED = 24  # runs with charts in the page, about 80 kB each: more would make it slow to open
MOST_FIGURES = 12  # in the page, about 100 kB each; the others are linked
CHAPTERS = dict.fromkeys(("set_up", "comparison", "residuals"), "results")  # by the name of a figure's file
CHAPTERS |= {"restitution": "restitution"}
FURTHER = "further"  # chapter of the other figures
PUBLISHED = PUBLISHED_NOTE.partition(":")[0]
COLOURS = 64  # of a figure in the page: lines, text and their smooth edges need no more

INDEXED = re.compile(r"(?<![A-Za-z0-9_])(ε|t|θ)_(θ|f|th|ex)(?![A-Za-z0-9_])")  # in no name, as mat_foam
SPOKEN = {"ε_θ": "discrepancy", "t_f": "final time"}  # where no index can be

BOKEH = ("bokeh.min.js", "bokeh-api.min.js")
IMPACTS = ("impact_time", "restitution", "restitution_stderr")
RELEASE = ("release", "theta0", "theta0_stderr", "theta0_u", "sigma_theta")
SHOWN_OF_RECORD = ("time", "theta", *RELEASE, "fit_start", "end", "n_impacts", *IMPACTS)  # shown of a record
OF_MODEL = ("parameter", "value", "stderr", "u_total", "unit", "epsilon_theta", "input")
OF_CHOICE = ("candidate", "status")
SHOWN_OF_FITS = ("time", "theta", "theta_model", "residual", *OF_MODEL, *OF_CHOICE, *IMPACTS[:2])


def write_report(
    path: str | Path,
    *,
    provenance: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    blocks: Mapping[str, Block],
    opened: Callable[[str, bool], tuple[xr.DataTree, xr.DataTree]],
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
        runs, epsilon, choice, candidates, populations, foundations, predictions, budget,
        restitution_comparison and table1 to table3, as `freerock.tables.csvfile.read_csv` gives them.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    opened : callable
        Opens the record and the fit dataset of a test, opened(test, samples); the latter without its samples
        where that is False. One pair is looked at after the other, of them `SHOWN_OF_RECORD` and
        `SHOWN_OF_FITS`.
    figures : sequence of (str, path)
        Caption, its first line a title, and PNG file of each figure to show, numbered as the page shows them.
    pages : mapping of str to path, optional
        File of the quality pages by record, linked relative to `path`.
    changes : sequence of freerock.config.review_log.Change, optional
        What was changed, and looked at, at the review desk.
    texts : path, optional
        Path without suffix where the methods are written with citations, as .md, and what they cite, as .bib.
    """
    folder = Path(path).parent
    linked = {test: os.path.relpath(page, folder) for test, page in (pages or {}).items()}
    shown = listed_records(tables["runs"], MOST_LISTED)
    wanted = charted(shown.rows(tables["runs"]), MOST_CHARTED)
    sections = sections_of(provenance, tables["runs"], opened, wanted, linked)
    environment = Environment(loader=FileSystemLoader(PAGE_FILES), autoescape=True, undefined=StrictUndefined)
    environment.filters |= {"indices": _indices, "spoken": _spoken, "cited": html_of}
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}  # keys in their order
    content = _content(provenance, tables, blocks, shown)
    compared = tables["restitution_comparison"]
    if content["yielding"]:
        compared = compared[compared["foundation"].isin(content["yielding"])]
    known = facts(tables["runs"], sections, compared, blocks)
    tested = " ".join(map(plain, content["findings"][0].sentences))
    made_with = provenance["software"], provenance["git"]
    paragraphs = methods(provenance["config"], known, tested, content["free"], *made_with)
    html = environment.get_template("report.html.j2").render(
        content,
        methods=paragraphs,
        references=[REFERENCES[key] for key in cited(paragraphs)],
        key=key_figure(tables, opened, content["published"]["values"]),
        figures=_figures(figures, folder),
        sections=[each for each in sections if each["test"] in shown.tests],
        n_charted=len(wanted),
        facts=known,
        scripts=[(scripts_folder() / name).read_text(encoding="utf-8") for name in BOKEH if wanted],
        by_hand=made.by_hand(changes, provenance["config"], shown.tests),
        looked=made.changes_seen(changes, tables["runs"]),
        own_script=(PAGE_FILES / "report.js").read_text(encoding="utf-8"),
    )
    write_text(path, html)
    if texts:
        write_text(f"{texts}.md", methods_markdown(paragraphs))
        write_text(f"{texts}.bib", bib(paragraphs))


def _content(
    provenance: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    blocks: Mapping[str, Block],
    shown: Listed,
) -> dict[str, Any]:
    """What the page shows of tables, configuration and provenance."""
    config, runs = provenance["config"], tables["runs"]
    labels = {name: each["label"] for name, each in (config["blocks"] | config["foundations"]).items()}
    simulated = config["origin"] == "simulated"
    published = config["published"] or {"doi": "", "values": {}, "longest": {}}
    excluded = runs["excluded"].astype(bool)
    counted = runs["verdict"][~excluded].value_counts()
    rows = {name: shown.rows(table) for name, table in tables.items()}
    printed = printed_tables(rows, config["origin"], doi=published["doi"], labels=labels)
    doubtful = [row for row in runs.itertuples() if row.verdict != "ok" and not row.excluded]
    to_look_at = sorted(doubtful, key=lambda row: -VERDICTS.index(row.verdict))
    table_1 = made.of_blocks(printed["table1"], runs, labels, shown.tests)
    own, rest = named(printed["table2"]), of_other_laws(printed["table2"])
    listings = {  # by the name of their table
        "runs": made.overview(rows["runs"], rows["choice"], labels),
        "named": made.of_records(own, labels),
        "table2": made.of_records(rest._replace(notes=_new(rest.notes, own.notes)), labels),
        "compared": made.compared(rows["table3"], labels),
        "table3": made.of_records(
            printed["table3"]._replace(notes=_new(printed["table3"].notes, printed["table2"].notes)), labels
        ),
        "choice": made.choices(rows["choice"], labels),
        "budget": made.budget(rows["budget"], rows["choice"], labels),
        "restitution_comparison": made.compared_restitution(rows["restitution_comparison"]),
    }
    named_on = laws_of_foundations(tables["choice"])
    fits = tables["epsilon"]
    failed = fits.loc[~fits["success"].astype(bool), ["test", "run", "model"]].astype(str)
    lost = {*failed.itertuples(index=False, name=None)}
    fitted = tables["choice"]["model"][tables["choice"]["status"] != "not_fitted"]
    laws = {CANDIDATES[model].law for model in fitted}
    rigid = {name: bool(law) and not law_of(law).is_foundation for name, law in named_on.items()}
    yielding = [name for name in rigid if not rigid[name]]
    looks = on_screen()
    return {
        "config": config,
        "rigid": bool(rigid) and not yielding,
        "yielding": {name: labels.get(name, name) for name in yielding if any(rigid.values())},
        "simulated": simulated,
        "simulated_note": SIMULATED_NOTE,
        "seen_note": SEEN_NOTE,
        "origin_word": config["origin"],
        "laws": [law for name, law in LAWS.items() if law.published or name in laws],
        "published": published,
        "findings": findings(tables, labels, published["longest"]),
        "verdicts": [(each, counted[each]) for each in VERDICTS if each in counted],
        "n_excluded": excluded.sum(),
        "n_to_look_at": len(to_look_at),
        "to_look_at": [row for row in to_look_at if row.test in shown.tests],
        "noted": [
            row for row in rows["runs"].itertuples() if row.reasons and (row.verdict == "ok" or row.excluded)
        ],
        "listed": shown,
        "counts": counts(runs),
        "beside": beside_published(tables, published["longest"], labels) if config["published"] else None,
        "table1": table_1._replace(notes=_own(table_1.notes, "table1")),
        "listings": {
            name: each._replace(notes=[*_own(each.notes, name), *shown.notes(name)])
            for name, each in listings.items()
        },
        "evidence": (scenes := scenes_of(tables["choice"], tables["candidates"], blocks, labels, lost)),
        "explained": explained(scenes),
        "candidates": together(scenes),
        "unexplained": unexplained(tables["choice"]),
        "n_runs": int(runs["run"].notna().sum()),
        "settings": settings(config),
        "free": free_besides(config["fits"], laws),
        "inputs": provenance["inputs"],
        "other_software": provenance.get("other_software", ()),
        "styles": {"mark": " – simulated" if simulated else "", "lines": looks},
    }


def _new(notes: Sequence[str], above: Sequence[str]) -> list[str]:
    """Notes of a table, without those of a table above it."""
    more = [note for note in notes if note not in above]
    return [*more, *["Marks: as above."] * (len(more) < len(notes))]


def _own(notes: Sequence[str], name: str) -> list[str]:
    """Notes of a table, without what the head of the page says and what stands below table 2."""
    told_above = (SIMULATED_NOTE, *((PUBLISHED,) if name != "named" else ()))
    return [note for note in notes if not note.startswith(told_above)]


def _indices(text: str) -> Markup:
    """A text of the report's own with its indices below the line; no number leaves its = or %."""
    shown = re.sub(r" (?=[=≤] )|(?<=[=≤]) | (?=%)", "\N{NO-BREAK SPACE}", str(escape(text)))
    return Markup(INDEXED.sub(r"\1<sub>\2</sub>", shown))


def _spoken(text: str) -> str:
    """A text without indices: in the heads of cards and in what a screen reader says there is none."""
    said = INDEXED.sub(lambda symbol: SPOKEN.get(symbol[0], symbol[0]), text)
    return said.replace("Discrepancy discrepancy", "Discrepancy")


def _figures(figures: Sequence[tuple[str, str | Path]], folder: Path) -> list[dict[str, Any]]:
    """The figures, in the order of their chapters."""
    chapters = [*dict.fromkeys(CHAPTERS.values()), FURTHER]
    shown = [(CHAPTERS.get(Path(file).stem, FURTHER), caption, Path(file)) for caption, file in figures]
    shown.sort(key=lambda figure: chapters.index(figure[0]))
    return [_figure(*each, folder, n) for n, each in enumerate(shown, 1)]


def _figure(chapter: str, caption: str, file: Path, folder: Path, n: int) -> dict[str, Any]:
    """A figure with its number, from 1."""
    title, _, text = caption.replace(SIMULATED_NOTE, "").partition("\n")  # the page's head says it of all
    image = {
        "caption": f"Figure {n}. {title}",
        "chapter": chapter,
        "text": text,
        "file": os.path.relpath(file.with_suffix(".pdf"), folder),
        "data": "",
    }
    if n > MOST_FIGURES:
        return image
    with Image.open(file) as opened, io.BytesIO() as small:
        opened.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(small, "png", compress_level=7)
        data = base64.b64encode(small.getvalue()).decode()
        return image | {"width": opened.width, "height": opened.height, "data": data}
