"""The report of a campaign: one HTML file that opens without internet."""

import base64
import io
import math
import os
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from PIL import Image

from freerock.figures.style import MEASURED, MODEL_STYLES
from freerock.files import atomic
from freerock.models.housner import housner_swings
from freerock.models.laws import MODEL_LABELS, MODELS, SYMBOLS
from freerock.products.groups import fits_of, reasons_in, runs_of
from freerock.report.charts import run_curves
from freerock.runs.verdict import in_one_line
from freerock.tables.tidy import (
    PUBLISHED_NOTE,
    RUN_BY_RUN_NOTE,
    SIMULATED_NOTE,
    between_runs,
    failed,
    fixed,
    quantity,
    unit_text,
    usable_rows,
    with_unit,
)

MOST_CHARTED = 24  # runs with charts in the page, about 80 kB each: more would make it slow to open
MOST_FIGURES = 12  # in the page, about 90 kB each; the others are linked
COLOURS = 64  # of a figure in the page: lines, text and their smooth edges need no more

HERE = Path(__file__).parent
BOKEH = ("bokeh.min.js", "bokeh-api.min.js")
VERDICTS = ("fail", "warn", "ok")
DASHES = {"-": [], "--": [7, 3], "-.": [7, 3, 1.5, 3], ":": [1.5, 2]}  # as figures.style, for the screen
MARKERS = {"measured": "circle", "housner": "diamond", "winkler": "square", "hunt_crossley": "triangle"}
MARKERS |= {"general": "inverted_triangle"}

COMPARISON = ["test", "r_fitted", "r_fitted_stderr", "r_first", "r_median", "r_low", "r_high"]
COMPARISON += ["first_impact_s", "rigid_s"]


class Cell(NamedTuple):
    """A cell of a table: its text, what it is sorted by, where it leads to, and its CSS class."""

    text: str
    value: float | str = ""
    href: str = ""
    kind: str = ""


def write_report(path, *, provenance, tables, blocks, opened, figures=(), pages=None):
    """Write the report of a campaign.

    Parameters
    ----------
    path : path-like
        HTML file to write; replaced in one step.
    provenance : mapping
        inputs, config, software and git, as `freerock.products.provenance` gives them; config is the
        campaign's section.
    tables : mapping of str to pandas.DataFrame
        The tidy tables runs, parameters, choice and restitution, and table1 to table3, as
        `freerock.tables.tidy.read_csv` gives them.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    opened : callable
        Opens the record and the fit dataset of a test, opened(test, samples); the latter without its samples
        where that is False. One pair is looked at after the other.
    figures : sequence of (str, path-like)
        Caption and PNG file of each figure to show.
    pages : mapping of str to path-like, optional
        File of the quality pages by record, linked relative to `path`.
    """
    config, folder = provenance["config"], Path(path).parent
    labels = {
        name: each["label"] for kind in ("blocks", "foundations") for name, each in config[kind].items()
    }
    runs, restitution = tables["runs"], tables["restitution"]
    listed = {each["test"]: each for each in config["records"]}
    wanted = charted(runs, MOST_CHARTED)
    drawn = {test for test, _ in wanted}
    verdicts = {(row.test, str(row.run)): (row.verdict, row.reasons) for row in runs.itertuples()}
    pages = {test: os.path.relpath(page, folder) for test, page in (pages or {}).items()}
    sections = [
        _section(*opened(test, test in drawn), line, verdicts, labels, provenance, wanted, pages)
        for test, line in listed.items()
    ]
    compared = restitution_comparison(runs, tables["parameters"], restitution, blocks)
    environment = Environment(loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined)
    environment.filters["indices"] = _indices
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}  # keys in their order
    html = environment.get_template("report.html.j2").render(
        config=config,
        labels=labels,
        simulated=config["origin"] == "simulated",
        simulated_note=SIMULATED_NOTE,
        run_by_run_note=RUN_BY_RUN_NOTE,
        published_note=PUBLISHED_NOTE.format(**config["published"]) if config["published"] else "",
        counts=_counts(runs),
        overview=_overview(runs, tables["choice"], labels),
        reasons=[row for row in runs.itertuples() if row.reasons],
        table1=_table1(tables["table1"], runs, labels),
        table2=_table2(tables["table2"], labels),
        table3=_table3(tables["table3"], labels),
        choice=_choice(tables["choice"], labels),
        comparison=_comparison(compared),
        figures=[_figure(caption, Path(file), folder, i) for i, (caption, file) in enumerate(figures)],
        sections=sections,
        n_charted=len(wanted),
        n_runs=int(runs["run"].notna().sum()),
        facts=_facts(runs, sections, compared, blocks),
        settings=_settings(config),
        models=[MODEL_LABELS[model] for model in config["fits"]["models"]],
        free=_free(config["fits"]),
        inputs=provenance["inputs"],
        software=provenance["software"],
        git=provenance["git"],
        styles={
            "mark": " – simulated" if config["origin"] == "simulated" else "",
            "lines": _lines(),
        },
        scripts=_scripts() if wanted else [],
        own_script=(HERE / "report.js").read_text(encoding="utf-8"),
    )
    with atomic(path) as part:
        Path(part).write_text(html, encoding="utf-8")


def charted(runs, most) -> set:
    """The runs whose charts go into the page: the worst verdicts first, then the first run of each record.

    Parameters
    ----------
    runs : pandas.DataFrame
        Tidy table.
    most : int
        How many at most.

    Returns
    -------
    set of (str, int)
        Test and run.
    """
    found = runs.dropna(subset=["run"]).astype({"run": int})
    ranked = found.assign(rank=found["verdict"].map(VERDICTS.index)).sort_values(
        ["rank", "run"], kind="stable"
    )
    return {(row.test, row.run) for row in ranked.head(most).itertuples()}


def restitution_comparison(runs, parameters, restitution, blocks) -> pd.DataFrame:
    """Restitution of the fitted Housner model beside that of the impacts, and the time to the first impact.

    Parameters
    ----------
    runs, parameters, restitution : pandas.DataFrame
        Tidy tables.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.

    Returns
    -------
    pandas.DataFrame
        One row per record with measured impacts: test, r_fitted and its standard error (joint fit of the
        runs), r_first, the mean r of the runs' first impacts, r_median, r_low and r_high, median and range of
        all impacts, first_impact_s, the mean time from release to the first impact, rigid_s, the mean time of
        a rigid block from the angles of the same runs.
    """
    rows = []
    runs = usable_rows(runs)
    measured = restitution[restitution["source"] == "experiment"].merge(runs[["test", "run"]])
    for test, impacts in measured.groupby("test", sort=False):
        fitted = parameters[
            (parameters["test"] == test) & (parameters["run"] == "pooled") & (parameters["parameter"] == "r")
        ]
        own = runs[(runs["test"] == test) & runs["run"].isin(impacts["run"])]
        block = blocks[own["block"].iloc[0]]
        rigid = [
            housner_swings(block, 1.0, math.radians(abs(angle)), max_impacts=1).impact_time[0]
            for angle in own["theta0_deg"]
            if abs(angle) < math.degrees(block.theta_cr)
        ]
        rows.append(
            {
                "test": test,
                "r_fitted": fitted["value"].mean(),
                "r_fitted_stderr": fitted["stderr"].mean(),
                "r_first": impacts[impacts["impact"] == 1]["r"].mean(),
                "r_median": impacts["r"].median(),
                "r_low": impacts["r"].min(),
                "r_high": impacts["r"].max(),
                "first_impact_s": impacts[impacts["impact"] == 1]["time_s"].mean(),
                "rigid_s": sum(rigid) / len(rigid) if rigid else math.nan,
            }
        )
    return pd.DataFrame(rows, columns=COMPARISON)


# Tables


def _indices(text) -> Markup:
    """A heading of the report's own with its indices below the line."""
    return escape(text).replace("ε_θ", Markup("ε<sub>θ</sub>")).replace("t_f", Markup("t<sub>f</sub>"))


def _number(text, value) -> Cell:
    return Cell(text, float(value) if math.isfinite(value) else "")


def _run_link(test, run) -> str:
    return f"#record-{test}" if run in ("–", "pooled") else f"#run-{test}-{run}"


def _counts(runs) -> str:
    def number(n, noun):
        return f"{n} {noun}{'' if n == 1 else 's'}"

    found = runs["run"].notna()
    verdicts = ", ".join(f"{n} {verdict}" for verdict, n in runs["verdict"].value_counts(sort=False).items())
    lost = (~found & (runs["verdict"] == "fail")).sum()
    lost = f" {number(lost, 'record')} could not be processed." if lost else ""
    records = number(runs["test"].nunique(), "record")
    return f"{records} with {number(found.sum(), 'free-rocking run')}; verdicts: {verdicts}.{lost}"


def _overview(runs, choice, labels) -> tuple:
    needed = {(row.test, str(row.run)): row.model for row in choice.itertuples()}
    heads = ["Record", "Run", "Block", "Foundation", "Verdict", "θ₀ / °", "Release / s", "Duration / s"]
    rows = []
    for row in runs.itertuples():
        run = "–" if pd.isna(row.run) else str(row.run)
        rows.append(
            [
                Cell(row.test, href=_run_link(row.test, run)),
                Cell(run),
                Cell(labels.get(row.block, row.block)),
                Cell(labels.get(row.foundation, row.foundation)),
                Cell(row.verdict, VERDICTS.index(row.verdict), kind=row.verdict),
                _number(fixed(row.theta0_deg, 3), row.theta0_deg),
                _number(fixed(row.start_s, 3), row.start_s),
                _number(fixed(row.duration_s, 2), row.duration_s),
                _number(str(row.n_impacts), row.n_impacts),
                _number(quantity(row.sigma_theta_deg, digits=2), row.sigma_theta_deg),
                Cell(MODEL_LABELS.get(needed.get((row.test, run)), "–")),
            ]
        )
    return [*heads, "Impacts", "σ / °", "Model"], rows


def _table1(frame, runs, labels) -> tuple:
    heads = ["Block", "2h / m", "2b / m", "h/b", "m / kg", "α nominal / °", "α measured / °", "Records"]
    rows = []
    for row in frame.itertuples():
        given = (row.height_m, row.width_m, row.slenderness, row.mass_kg, row.alpha_nominal_deg)
        tests = list(dict.fromkeys(runs[runs["block"] == row.block]["test"]))
        first = (
            Cell(f"{len(tests)}, from {tests[0]}", len(tests), f"#record-{tests[0]}") if tests else Cell("0")
        )
        rows.append(
            [
                Cell(labels.get(row.block, row.block), href=f"#config-blocks-{row.block}"),
                *(_number(f"{value:.4g}" if math.isfinite(value) else "–", value) for value in given),
                _number(quantity(row.alpha_deg, row.alpha_std_deg), row.alpha_deg),
                first,
            ]
        )
    return heads, rows


def _scene(row, labels) -> list:
    """Record, block and foundation of a row."""
    names = (labels.get(row.block, row.block), labels.get(row.foundation, row.foundation))
    return [Cell(row.test, href=f"#record-{row.test}"), *map(Cell, names)]


def _table2(frame, labels) -> tuple:
    heads = ["Record", "Block", "Foundation", "Model", "Parameter", "Identified", "Run by run", "Published"]
    return heads, [
        [
            *_scene(row, labels),
            Cell(MODEL_LABELS[row.model]),
            Cell(with_unit(SYMBOLS[row.parameter], row.unit)),
            _number(quantity(row.value, row.stderr) + failed(row), row.value),
            _number(between_runs(row), row.run_mean),
            _number(quantity(row.published), row.published),
        ]
        for row in frame.itertuples()
    ]


def _table3(frame, labels) -> tuple:
    heads = ["Record", "Block", "Foundation", "Model", "ε_θ / %", "Published / %", "t_f / s"]
    return heads, [
        [
            *_scene(row, labels),
            Cell(MODEL_LABELS[row.model]),
            _number(quantity(100 * row.epsilon_theta) + failed(row), row.epsilon_theta),
            _number(fixed(100 * row.published, 2), row.published),
            _number(fixed(row.final_time_s, 2), row.final_time_s),
        ]
        for row in frame.itertuples()
    ]


def _choice(choice, labels) -> tuple:
    heads = ["Record", "Run", "Block", "Foundation", "Model", "Reason"]
    return heads, [
        [
            Cell(row.test, href=_run_link(row.test, row.run)),
            Cell("all" if row.run == "pooled" else str(row.run)),
            *_scene(row, labels)[1:],
            Cell(MODEL_LABELS.get(row.model, "–")),
            Cell(row.reason),
        ]
        for row in choice.itertuples()
    ]


def _comparison(compared) -> tuple:
    heads = ["Record", "Housner r, fitted", "r, first impact", "r per impact, median", "Range"]
    return [*heads, "First impact / s", "First impact, rigid / s"], [
        [
            Cell(row.test, href=f"#record-{row.test}"),
            _number(quantity(row.r_fitted, row.r_fitted_stderr), row.r_fitted),
            _number(fixed(row.r_first, 3), row.r_first),
            _number(fixed(row.r_median, 3), row.r_median),
            Cell(f"{row.r_low:.3f} to {row.r_high:.3f}"),
            _number(fixed(row.first_impact_s, 4), row.first_impact_s),
            _number(fixed(row.rigid_s, 4), row.rigid_s),
        ]
        for row in compared.itertuples()
    ]


# Records and their runs


def _section(record, fits, line, verdicts, labels, provenance, wanted, pages) -> dict:
    """What the report says about a record: its file, what was found in it, fits, curves of its runs."""
    attrs, test = record.attrs, record.attrs["test"]
    file = f"{provenance['config']['raw']}/{line['file']}"
    fitted, groups = runs_of(fits), {}
    for run, model, fit in fits_of(fits):
        groups.setdefault(run, []).append(_fit(model, fit))
    time = record["time"].values if "time" in record else []
    return {
        "test": test,
        "block": attrs["block"],
        "foundation": attrs["foundation"],
        "names": ", ".join(labels.get(attrs[kind], attrs[kind]) for kind in ("block", "foundation")),
        "verdict": min((verdicts[key][0] for key in verdicts if key[0] == test), key=VERDICTS.index),
        "reasons": in_one_line(reasons_in(attrs)),
        "file": file,
        "sha256": provenance["inputs"].get(file, ""),
        "lasers": [name.strip() for name in line["laser"].split(";")],
        "by_hand": {key: line[key] for key in ("exclude", "override", "reason", "note") if line.get(key)},
        "samples": len(time),
        "rate_hz": float(attrs.get("sampling_rate_hz", math.nan)),
        "page": pages.get(test, ""),
        "pooled": groups.get("pooled", []),
        "runs": [
            _run(number, run, verdicts[test, str(number)], time, groups.get(number, []))
            | {"curves": run_curves(record, number, fitted.get(number)) if (test, number) in wanted else None}
            for number, run in runs_of(record).items()
        ],
    }


def _run(number, run, told, time, fits) -> dict:
    verdict, reasons = told
    instants = [run[name].item() for name in ("release", "fit_start", "end")]
    return {
        "number": number,
        "verdict": verdict + (", excluded" if run.attrs["excluded"] else ""),
        "kind": verdict,
        "reasons": reasons,
        "theta0": quantity(*(math.degrees(run[name].item()) for name in ("theta0", "theta0_stderr"))),
        "sigma": quantity(math.degrees(run["sigma_theta"].item()), digits=2),
        "impacts": run.sizes.get("impact", 0),
        "instants": [fixed(instant, 3) for instant in instants],
        "samples": [int(time.searchsorted(instant)) for instant in instants],
        "fits": fits,
    }


def _fit(model, fit) -> dict:
    names, units = fit["parameter"].values.astype(str), fit["unit"].values.astype(str)
    found = zip(names, fit["value"].values, fit["stderr"].values, units, strict=True)
    told = fit.attrs
    return {
        "model": MODEL_LABELS[model],
        "parameters": [
            f"{_symbol(name)} = {quantity(value, stderr)}" + f" {unit_text(unit)}".rstrip()
            for name, value, stderr, unit in found
        ],
        "epsilon": quantity(100 * fit["epsilon_theta"].item()),
        "success": bool(fit["success"].item()),
        "rtol": math.nan if model == "housner" else float(told["rtol"]),
        "integrator_error": float(told["integrator_error"]),
        "averaged": f"{told['averaged']:.0f}",
        "residual": quantity(told["residual_over_sigma"]),
        "colour": "coloured" if told["coloured"] else "white" if told["white"] else "not quite white",
        "message": told["message"],
    }


def _symbol(name) -> str:
    """Symbol of a parameter; with its number that of an impact, or in a joint fit of a run."""
    kind, _, number = name.partition("_")
    return SYMBOLS[kind] + (f" of {'impact' if kind == 'r' else 'run'} {number}" if number else "")


# Figures, settings, scripts


def _figure(caption, file, folder, rank) -> dict:
    image = {"caption": caption, "file": os.path.relpath(file.with_suffix(".pdf"), folder), "data": ""}
    if rank >= MOST_FIGURES:
        return image
    with Image.open(file) as opened, io.BytesIO() as small:
        opened.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(small, "png", optimize=True)
        size = dict(zip(("width", "height"), opened.size, strict=True))
        return image | size | {"data": base64.b64encode(small.getvalue()).decode()}


def _free(fits) -> list:
    """What each model was free in besides its parameters, models alike taken together."""
    alike = {}
    for model in fits["models"]:
        free = " and ".join(SYMBOLS.get(name, name.replace("_", " ")) for name in fits["free"].get(model, ()))
        alike.setdefault(free or "nothing", []).append(MODEL_LABELS[model])
    return [(", ".join(models), free) for free, models in alike.items()]


def _settings(config) -> list:
    """Each section of the configuration with (anchor, name, pairs of key and text) of the things in it."""
    sections = {key: value for key, value in config.items() if isinstance(value, Mapping)}
    plain = {
        key: value for key, value in config.items() if key not in (*sections, "records", "title", "summary")
    }
    return [("campaign", [("", "", list(_flat(plain)))])] + [
        (key, list(_parts(value, f"config-{key}"))) for key, value in sections.items()
    ]


def _parts(section, anchor):
    if section and all(isinstance(each, Mapping) for each in section.values()):
        for name, each in section.items():
            yield f"{anchor}-{name}", name, list(_flat(each))
    else:
        yield "", "", list(_flat(section))


def _flat(value, key=""):
    """Nested mappings and lists as pairs of dotted key and text; what is empty is left out."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _flat(inner, f"{key}.{name}" if key else name)
    elif isinstance(value, list | tuple) and any(isinstance(inner, Mapping) for inner in value):
        for i, inner in enumerate(value, 1):
            yield from _flat(inner, f"{key}.{i}")
    elif isinstance(value, list | tuple):
        yield from _flat(", ".join(map(str, value)), key)
    elif value not in (None, ""):
        yield key, str(value)


def _lines() -> dict:
    """Look of each curve on the screen, as figures.style has it on paper."""
    styles = {"measured": MEASURED | {"color": "#999999"}} | {model: MODEL_STYLES[model] for model in MODELS}
    return {
        name: {
            "color": style["color"],
            "dash": DASHES.get(style["linestyle"])
            if isinstance(style["linestyle"], str)
            else style["linestyle"][1],
            "width": 3 if name == "measured" else 1.5,
            "marker": MARKERS[name],
            "label": style["label"],
        }
        for name, style in styles.items()
    }


def _scripts():
    """BokehJS as it comes with the Python package, which need not be imported for it."""
    folder = Path(find_spec("bokeh").origin).parent / "server/static/js"
    return [(folder / name).read_text(encoding="utf-8") for name in BOKEH]


def _facts(runs, sections, compared, blocks) -> dict:
    """Numbers of the report's sentences, as text."""
    shifts_mm = [
        1000 * blocks[run.block].b * (1 - math.cos(math.radians(run.theta0_deg)))
        for run in runs.dropna(subset=["theta0_deg"]).itertuples()
    ]
    known = compared.dropna(subset=["r_fitted", "first_impact_s", "rigid_s"])
    later = 100 * (known["first_impact_s"] / known["rigid_s"] - 1)
    fits = [
        fit
        for section in sections
        for each in (section["runs"], [{"fits": section["pooled"]}])
        for run in each
        for fit in run["fits"]
    ]
    integrated = pd.DataFrame(
        [fit for fit in fits if math.isfinite(fit["rtol"])], columns=["rtol", "integrator_error"]
    )
    rates = sorted({section["rate_hz"] for section in sections if math.isfinite(section["rate_hz"])})
    return {
        "rates_hz": " to ".join(dict.fromkeys(f"{rate:.6g}" for rate in (*rates[:1], *rates[-1:]))),
        "shift_mm": quantity(max(shifts_mm, default=math.nan), digits=2),
        "latest": _later(later.max()),
        "earliest": _later(later.min()),
        "some_earlier": bool((later < 0).any()),
        "n_above": int((known["r_fitted"] > known["r_first"]).sum()),
        "n_known": len(known),
        "n_integrated": len(integrated),
        "rtol_low": f"{integrated['rtol'].min():g}",
        "rtol_high": f"{integrated['rtol'].max():g}",
        "error_percent": quantity(100 * integrated["integrator_error"].max(), digits=2),
    }


def _later(percent) -> str:
    return f"{fixed(abs(percent), 1)} % {'later' if percent > 0 else 'earlier'}"
