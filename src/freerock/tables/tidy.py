"""Tables: the tidy CSV contract, and the printed tables in CSV, Markdown and LaTeX.

The tidy tables (`runs_table`, `parameters_table`, `epsilon_table`, `restitution_table`) gather what the
record and fit datasets hold. The printed ones start from these: `table1` to `table3` follow the numbering of
Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024), `recovered_table` sets the values identified in a
simulated campaign beside those it was simulated with. Each has a numeric frame and a `..._text` frame,
whose cells are what a reader sees.
"""

import math
import re

import numpy as np
import pandas as pd

from freerock.files import atomic, write_text
from freerock.identification.choice import choose_model
from freerock.models.laws import MODEL_LABELS, MODELS, SYMBOLS, UNITS
from freerock.products.groups import fits_of, reasons_in, runs_of, usable_runs
from freerock.runs.verdict import in_one_line

SIMULATED_NOTE = "The records are simulated; they are not the laboratory's data."
RUN_BY_RUN_NOTE = (
    "Identified: jointly, with its standard error. Run by run: mean and standard deviation of the fits of "
    "single runs; where it exceeds the standard error, releases differ by more than the noise."
)
PUBLISHED_NOTE = "Published values: doi:{doi}; they stem from the laboratory's own records."

IDENTITY = ["campaign", "test", "run", "block", "foundation"]
RUNS = [*IDENTITY, "origin", "theta0_deg", "start_s", "duration_s", "n_impacts", "sigma_theta_deg"]
RUNS += ["verdict", "reasons", "excluded"]
PARAMETERS = [*IDENTITY, "model", "parameter", "value", "stderr", "ci95_low", "ci95_high", "unit", "success"]
EPSILON = [*IDENTITY, "model", "epsilon_theta", "final_time_s", "epsilon_holdout", "n_parameters"]
EPSILON += ["aic", "bic", "selected", "success"]
CHOICE = [*IDENTITY, "model", "reason"]
NORMAL_95 = 1.959963984540054
RESTITUTION = ["campaign", "test", "run", "source", "impact", "time_s", "r", "r_stderr"]
RESTITUTION += ["block", "foundation", "peak_before_deg"]


def _identity(tree, run) -> dict:
    return {key: run if key == "run" else str(tree.attrs[key]) for key in IDENTITY}


# Tidy tables


def runs_table(records, fits=()) -> pd.DataFrame:
    """One row per run; a record that could not be processed has one row without a run number.

    Parameters
    ----------
    records : iterable of xarray.DataTree
        Record datasets.
    fits : iterable of xarray.DataTree, optional
        Fit datasets; where a model could not be fitted to a usable run, its row says why; where none could,
        the run is failed.

    Returns
    -------
    pandas.DataFrame
        Columns `RUNS`: start_s is the release on the record's clock [s], duration_s the time from release to
        rest [s], angles in degrees. Failed and excluded runs are rows like any other, with their reasons.
    """
    rows = []
    fits = {tree.attrs["test"]: tree for tree in fits}
    for tree in records:
        runs = runs_of(tree)
        for number, run in runs.items():
            release = run["release"].item()
            verdict, reasons = _with_fits(number, run, fits.get(tree.attrs["test"]))
            rows.append(
                {
                    **_identity(tree, number),
                    "origin": tree.attrs["origin"],
                    "theta0_deg": math.degrees(run["theta0"].item()),
                    "start_s": release,
                    "duration_s": run["end"].item() - release,
                    "n_impacts": run.sizes.get("impact", 0),
                    "sigma_theta_deg": math.degrees(run["sigma_theta"].item()),
                    "verdict": verdict,
                    "reasons": reasons,
                    "excluded": bool(run.attrs["excluded"]),
                }
            )
        if not runs:
            verdict = {key: tree.attrs[key] for key in ("origin", "verdict")}
            verdict["reasons"] = in_one_line(reasons_in(tree.attrs))
            left_out = tree.attrs["verdict"] != "fail"  # by hand, the whole record
            rows.append({**_identity(tree, pd.NA), **verdict, "n_impacts": 0, "excluded": left_out})
    return pd.DataFrame(rows, columns=RUNS).astype({"run": "Int64", "n_impacts": "Int64"})


def _with_fits(number, run, fits) -> tuple[str, str]:
    """Verdict and reasons of a run, with those of the models that could not be fitted to it."""
    verdict, reasons = run.attrs["verdict"], in_one_line(reasons_in(run.attrs))
    told = fits.attrs.get("not_fitted", "") if fits is not None else ""
    if verdict == "fail" or run.attrs["excluded"] or not told:
        return verdict, reasons
    if fits.attrs["verdict"] == "fail":  # the step gave up
        own = [f"not fitted: {told}"]
    else:
        mine = (f"run {number}: ", "all runs: ")
        own = [each.removeprefix(mine[0]) for each in told.split("; ") if each.startswith(mine)]
    if not own:
        return verdict, reasons
    lost = f"run_{number}" not in fits.children
    return "fail" if lost else "warn", "; ".join(filter(None, [reasons, *own]))


def parameters_table(fits) -> pd.DataFrame:
    """One row per identified parameter, freed release angles and times included.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns `PARAMETERS`; run is "pooled" for the joint fit of a record's runs, SI units; success tells
        whether the fit may be used.
    """
    rows = []
    for tree in fits:
        for run, model, fit in fits_of(tree):
            numbers = {key: fit[key].values for key in ("value", "stderr", "ci95_low", "ci95_high")}
            for i, parameter in enumerate(fit["parameter"].values.astype(str)):
                rows.append(
                    {
                        **_identity(tree, run),
                        "model": model,
                        "parameter": parameter,
                        **{key: column[i] for key, column in numbers.items()},
                        "unit": UNITS[parameter.split("_")[0]],
                        "success": bool(fit["success"].item()),
                    }
                )
    return pd.DataFrame(rows, columns=PARAMETERS).astype({"success": bool})


def epsilon_table(fits) -> pd.DataFrame:
    """One row per fit: how far the model is from the measured θ(t).

    Parameters
    ----------
    fits : sequence of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns `EPSILON`; epsilon_theta is a fraction up to final_time_s [s], selected the model chosen
        for that run (`choice_table`), success tells whether the fit may be used.
    """
    rows = []
    for tree in fits:
        for run, model, fit in fits_of(tree):
            scalars = ("epsilon_theta", "final_time", "aic", "bic", "n_parameters")
            row = {key: fit[key].item() for key in scalars}
            row["final_time_s"] = row.pop("final_time")
            row["epsilon_holdout"] = fit["epsilon_holdout"].item() if "epsilon_holdout" in fit else math.nan
            row["success"] = bool(fit["success"].item())
            rows.append({**_identity(tree, run), "model": model, **row})
    columns = [column for column in EPSILON if column != "selected"]
    frame = pd.DataFrame(rows, columns=columns).astype({"n_parameters": "Int64", "success": bool})
    chosen = {(row.test, row.run): row.model for row in choice_table(fits).itertuples()}
    selected = [chosen[row.test, row.run] == row.model for row in frame.itertuples()]
    return frame.assign(selected=selected)[EPSILON]


def choice_table(fits) -> pd.DataFrame:
    """One row per run: the model it needs, and why.

    Parameters
    ----------
    fits : iterable of xarray.DataTree
        Fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns `CHOICE`; model is empty where every fit failed.
    """
    rows = {}
    for tree in fits:
        evidence = {}
        for run, model, fit in fits_of(tree):
            numbers = {key: fit[key].item() for key in ("success", "bic")}
            held_out = fit["epsilon_holdout"].item() if "epsilon_holdout" in fit else math.nan
            evidence.setdefault(run, {})[model] = {**fit.attrs, **numbers, "epsilon_holdout": held_out}
        for run, found in evidence.items():
            model, reason = choose_model(found)
            rows[tree.attrs["test"], run] = {**_identity(tree, run), "model": model, "reason": reason}
    return pd.DataFrame(rows.values(), columns=CHOICE)


def restitution_table(records, fits) -> pd.DataFrame:
    """One row per impact of the measured runs and of the models fitted to each of them.

    Parameters
    ----------
    records, fits : iterable of xarray.DataTree
        Record and fit datasets.

    Returns
    -------
    pandas.DataFrame
        Columns `RESTITUTION`; source is "experiment" or a model, impact counts from 1, time_s is since the
        release [s], r the restitution from the peaks before and after the impact, peak_before_deg the peak
        |θ| before it.
    """
    parts = []
    for tree in records:
        for number, run in runs_of(tree).items():
            parts.append((tree, number, "experiment", run, run["release"].item()))
    for tree in fits:
        parts += [(tree, run, model, fit, 0.0) for run, model, fit in fits_of(tree) if run != "pooled"]
    frames = [
        pd.DataFrame(
            {
                **_identity(tree, run),
                "source": source,
                "impact": np.arange(1, node.sizes["impact"] + 1),
                "time_s": node["impact_time"].values - release,
                "r": node["restitution"].values,
                "r_stderr": node["restitution_stderr"].values,
                "peak_before_deg": np.degrees(np.abs(node["peak_before"].values)),
            }
        )
        for tree, run, source, node, release in parts
        if node.sizes.get("impact", 0)
    ]
    if not frames:
        return pd.DataFrame(columns=RESTITUTION)
    frame = pd.concat(frames, ignore_index=True)
    ranks = {"test": list(dict.fromkeys(frame["test"])), "source": ["experiment", *MODELS]}
    order = frame.sort_values(
        ["test", "run", "source", "impact"],
        key=lambda column: column.map(ranks[column.name].index) if column.name in ranks else column,
    )
    return order[RESTITUTION].reset_index(drop=True)


# Printed tables


def table1(records, blocks, release_angles_deg=None) -> pd.DataFrame:
    """Block configurations with the release angle as measured.

    Parameters
    ----------
    records : iterable of xarray.DataTree
        Record datasets.
    blocks : mapping of str to freerock.models.block.Block
        The campaign's blocks by name.
    release_angles_deg : mapping of str to float, optional
        Nominal release angle of each block [degree].

    Returns
    -------
    pandas.DataFrame
        One row per block: height 2h and width 2b [m], slenderness h/b, mass [kg], nominal release angle,
        mean and standard deviation of the held angle |θ₀| over the usable runs [degree], their number.
    """
    held = {name: [] for name in blocks}
    for tree in records:
        held[tree.attrs["block"]] += [
            abs(math.degrees(run["theta0"].item())) for run in usable_runs(tree).values()
        ]
    rows = [
        {
            "block": name,
            "height_m": block.height_m,
            "width_m": block.width_m,
            "slenderness": block.height_m / block.width_m,
            "mass_kg": block.mass_kg,
            "alpha_nominal_deg": (release_angles_deg or {}).get(name, math.nan),
            "alpha_deg": np.mean(held[name]) if held[name] else math.nan,
            "alpha_std_deg": np.std(held[name], ddof=1) if len(held[name]) > 1 else math.nan,
            "n_runs": len(held[name]),
        }
        for name, block in blocks.items()
    ]
    return pd.DataFrame(rows)


def table1_text(frame, labels=None) -> pd.DataFrame:
    """Cells of `table1` as printed: one column per block.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `table1`.
    labels : mapping of str to str, optional
        Printed names of blocks.
    """
    labels = labels or {}
    text = {"": ["2h / m", "2b / m", "h/b", "m / kg", "α nominal / °", "α measured / °"]}
    for row in frame.itertuples():
        given = (row.height_m, row.width_m, row.slenderness, row.mass_kg, row.alpha_nominal_deg)
        text[labels.get(row.block, row.block)] = [
            *(f"{number:.4g}" if math.isfinite(number) else "–" for number in given),
            quantity(row.alpha_deg, row.alpha_std_deg),
        ]
    return pd.DataFrame(text)


def table2(parameters, published=None) -> pd.DataFrame:
    """Identified parameters of the pooled fits, beside the published ones.

    Parameters
    ----------
    parameters : pandas.DataFrame
        From `parameters_table`.
    published : mapping, optional
        Published values by block, foundation, model and quantity.

    Returns
    -------
    pandas.DataFrame
        Columns test, block, foundation, model, parameter, unit, value, stderr, run_mean, run_scatter,
        published, success; SI units. run_mean and run_scatter: mean and standard deviation of the fits of
        single runs.
    """
    key = ["test", "model", "parameter"]
    single = parameters[(parameters["run"] != "pooled") & parameters["success"]]
    runs = single.groupby(key)["value"].agg(run_mean="mean", run_scatter="std")
    frame = parameters[parameters["run"] == "pooled"].join(runs, on=key)
    own = [row.parameter in MODELS[row.model] for row in frame.itertuples()]
    frame = frame[np.array(own, bool)].reset_index(drop=True)
    frame["published"] = [_published(published, row, row.parameter) for row in frame.itertuples()]
    columns = ["test", "block", "foundation", "model", "parameter", "unit", "value", "stderr"]
    return frame[[*columns, "run_mean", "run_scatter", "published", "success"]]


def table2_text(frame, labels=None) -> pd.DataFrame:
    """Cells of `table2` as printed: one row per foundation, model and parameter, grouped by block.

    What the single runs gave stands beside where a record has several.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `table2`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    """
    several = {"Run by run": between_runs} if frame["run_scatter"].notna().any() else {}
    return _grouped(
        frame,
        labels,
        {
            "Model": lambda row: MODEL_LABELS[row.model],
            "Parameter": lambda row: with_unit(SYMBOLS[row.parameter], row.unit),
            "Identified": lambda row: quantity(row.value, row.stderr) + failed(row),
            **several,
            "Published": lambda row: quantity(row.published),
        },
    )


def between_runs(row) -> str:
    """Mean and standard deviation of what the single runs of a record gave; "–" for a single one."""
    return quantity(row.run_mean, row.run_scatter) if math.isfinite(row.run_scatter) else "–"


def table3(epsilon, published=None) -> pd.DataFrame:
    """Discrepancy ε_θ of the pooled fits, beside the published one.

    Parameters
    ----------
    epsilon : pandas.DataFrame
        From `epsilon_table`.
    published : mapping, optional
        Published values by block, foundation, model and quantity.

    Returns
    -------
    pandas.DataFrame
        Columns test, block, foundation, model, epsilon_theta, published (fractions), final_time_s, success.
    """
    frame = epsilon[epsilon["run"] == "pooled"].reset_index(drop=True)
    frame["published"] = [_published(published, row, "epsilon_theta") for row in frame.itertuples()]
    columns = ["test", "block", "foundation", "model", "epsilon_theta", "published", "final_time_s"]
    return frame[[*columns, "success"]]


def table3_text(frame, labels=None) -> pd.DataFrame:
    """Cells of `table3` as printed: one row per foundation and model, grouped by block.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `table3`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    """
    return _grouped(
        frame,
        labels,
        {
            "Model": lambda row: MODEL_LABELS[row.model],
            "ε_θ / %": lambda row: quantity(100 * row.epsilon_theta) + failed(row),
            "Published / %": lambda row: fixed(100 * row.published, 2),
            "t_f / s": lambda row: fixed(row.final_time_s, 2),
        },
    )


def failed(row) -> str:
    """What is printed after a number of a fit that may not be used."""
    return "" if row.success else " (failed fit)"


def _grouped(frame, labels, cells) -> pd.DataFrame:
    """Printed rows under the name of their block; a repeated foundation or model is left blank."""
    labels, columns = labels or {}, ["Foundation", *cells]
    text = []
    for block, rows in frame.groupby("block", sort=False):
        if frame["block"].nunique() > 1:
            text.append({"Foundation": labels.get(block, block)})
        for foundation, own in rows.groupby("foundation", sort=False):
            for test, fits in own.groupby("test", sort=False):
                name = labels.get(foundation, foundation)
                name += f" ({test})" if own["test"].nunique() > 1 else ""
                printed = pd.DataFrame(
                    [[name, *(cell(row) for cell in cells.values())] for row in fits.itertuples()],
                    columns=columns,
                )
                for column in ("Model", "Foundation"):
                    printed[column] = printed[column].mask(printed[column].duplicated(), "")
                text += printed.to_dict("records")
    return pd.DataFrame(text, columns=columns).fillna("")


def recovered_table(parameters, truth) -> pd.DataFrame:
    """Values identified in a simulated campaign beside those it was simulated with.

    Parameters
    ----------
    parameters : pandas.DataFrame
        From `parameters_table` or `read_csv`.
    truth : mapping of (str, int, str) to float
        True value by test, run and parameter of the Hunt–Crossley model, SI units.

    Returns
    -------
    pandas.DataFrame
        Columns test, run, parameter, unit, truth, value, ci95_low, ci95_high, error_percent, inside (the
        truth lies in the 95 % interval).
    """
    known = {(test, str(run), name): value for (test, run, name), value in truth.items()}
    keys = zip(parameters["test"], parameters["run"].astype(str), parameters["parameter"], strict=True)
    true = pd.Series([known.get(key, math.nan) for key in keys], parameters.index, float)
    chosen = (parameters["model"] == "hunt_crossley") & true.notna()
    frame = parameters[chosen].assign(
        truth=true,
        error_percent=100 * (parameters["value"] / true - 1),
        inside=(parameters["ci95_low"] <= true) & (true <= parameters["ci95_high"]),
    )
    columns = ["test", "run", "parameter", "unit", "truth", "value", "ci95_low", "ci95_high", "error_percent"]
    return frame[[*columns, "inside"]].reset_index(drop=True)


def recovered_text(frame) -> pd.DataFrame:
    """Cells of `recovered_table` as printed."""
    rows = list(frame.itertuples())
    return pd.DataFrame(
        {
            "Record": [row.test for row in rows],
            "Run": [str(row.run) for row in rows],
            "Parameter": [with_unit(SYMBOLS[row.parameter], row.unit) for row in rows],
            "Truth": [quantity(row.truth, digits=5) for row in rows],
            "Identified": [
                quantity(row.value, (row.ci95_high - row.ci95_low) / 2 / NORMAL_95) for row in rows
            ],
            "Error / %": [fixed(row.error_percent, 3) for row in rows],
            "In 95 %": ["yes" if row.inside else "no" for row in rows],
        }
    )


def tidy_tables(records, fits) -> dict:
    """The tidy tables by name: runs, parameters, epsilon, choice, restitution.

    Parameters
    ----------
    records, fits : sequence of xarray.DataTree
        Record and fit datasets.
    """
    return {
        "runs": runs_table(records, fits),
        "parameters": parameters_table(fits),
        "epsilon": epsilon_table(fits),
        "choice": choice_table(fits),
        "restitution": restitution_table(records, fits),
    }


def printed_tables(tidy, records, blocks, *, release_angles_deg=None, published=None, labels=None) -> dict:
    """Tables 1 to 3 of Spanos et al. 2017 for another campaign.

    Parameters
    ----------
    tidy : mapping of str to pandas.DataFrame
        From `tidy_tables`.
    records : sequence of xarray.DataTree
        Record datasets.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    release_angles_deg : mapping of str to float, optional
        Nominal release angle of each block [degree].
    published : mapping, optional
        doi and values of the publication to compare with.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    dict of str to dict
        By name ("table1" to "table3") the keyword arguments of `write_table`.
    """
    values = published["values"] if published else None
    first = table1(records, blocks, release_angles_deg)
    second, third = table2(tidy["parameters"], values), table3(tidy["epsilon"], values)
    origin = ", ".join(tidy["runs"]["origin"].unique())
    simulated = [SIMULATED_NOTE] if "simulated" in origin else []
    notes = [*simulated, PUBLISHED_NOTE.format(doi=published["doi"])] if published else simulated
    return {
        "table1": {
            "frame": first.assign(origin=origin),
            "text": table1_text(first, labels),
            "caption": "Block configurations",
            "notes": simulated,
        },
        "table2": {
            "frame": second.assign(origin=origin),
            "text": table2_text(second, labels),
            "caption": "Identified parameters, all runs of a record jointly",
            "notes": [RUN_BY_RUN_NOTE, *notes] if second["run_scatter"].notna().any() else notes,
        },
        "table3": {
            "frame": third.assign(origin=origin),
            "text": table3_text(third, labels),
            "caption": "Discrepancy ε_θ of the joint fit between measured and modelled rotation up to t_f",
            "notes": notes,
        },
    }


def usable_rows(runs) -> pd.DataFrame:
    """The rows of the table runs that `usable_runs` would keep: neither failed nor excluded."""
    return runs[(runs["verdict"] != "fail") & ~runs["excluded"].astype(bool)]


def _published(published, row, name) -> float:
    for key in (row.block, row.foundation, row.model):
        published = (published or {}).get(key)
    return (published or {}).get(name, math.nan)


# Numbers and units as text


def quantity(value, stderr=math.nan, digits=3) -> str:
    """A value rounded by its uncertainty, with a power of ten where it is large or small.

    Parameters
    ----------
    value : float
        The value.
    stderr : float, optional
        Its standard error, printed with two significant digits; without one the value has `digits` of them.
    digits : int
        Significant digits of a value without a standard error.

    Returns
    -------
    str
        For instance "0.9570 ± 0.0012", "(6.880 ± 0.012)·10⁶", "6.88·10⁶"; "–" for NaN.
    """
    if not math.isfinite(value):
        return "–"
    magnitude = _exponent(value, digits)
    power = magnitude if not -3 <= magnitude < 4 else 0
    known = math.isfinite(stderr) and stderr > 0
    decimals = max(0, 1 - _exponent(stderr, 2) + power if known else digits - 1 - magnitude + power)
    text = fixed(value / 10.0**power, decimals)
    if known:
        text = f"{text} ± {stderr / 10.0**power:.{decimals}f}"
    if power:
        text = f"({text})" if known else text
        text += "·10" + str(power).translate(SUPERSCRIPTS)
    return text


SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _exponent(value, digits) -> int:
    return int(f"{value:.{digits - 1}e}".split("e")[1]) if value else 0


def fixed(value, decimals) -> str:
    """A number with so many decimals and a true minus sign; "–" for NaN."""
    return f"{value:.{decimals}f}".replace("-", "−") if math.isfinite(value) else "–"


def with_unit(symbol, unit) -> str:
    """Symbol and unit, "k / (N m⁻²)" or "t₀ / s"; the symbol alone for a pure number."""
    text = unit_text(unit)
    return f"{symbol} / ({text})" if " " in text else f"{symbol} / {text}" if text else symbol


def unit_text(unit) -> str:
    """A unit with raised exponents, "N m⁻²"; nothing for a pure number."""
    return (
        "" if unit == "1" else re.sub(r"-[0-9]", lambda exponent: exponent[0].translate(SUPERSCRIPTS), unit)
    )


# Writing


def write_csv(frame, path):
    """Write a frame as CSV, the same bytes for the same numbers.

    Parameters
    ----------
    frame : pandas.DataFrame
        The table.
    path : path-like
        File to write; replaced in one step.
    """
    texts = {
        name: ["" if math.isnan(value) else f"{value:.10g}" for value in frame[name].tolist()]
        for name in frame.select_dtypes("float")
    }  # pandas' own float_format takes twice as long
    with atomic(path) as part:
        frame.assign(**texts).to_csv(part, index=False, float_format="%.10g", lineterminator="\n")


def read_csv(path) -> pd.DataFrame:
    """Read a table written by `write_csv`; run numbers are texts, as "pooled" is one of them.

    Parameters
    ----------
    path : path-like
        CSV file.
    """
    names = ("campaign", "test", "run", "block", "foundation", "basis", "model")  # 001 is one too
    text = dict.fromkeys((*names, "reasons", "reason"), str)
    frame = pd.read_csv(path, dtype=text, keep_default_na=False, na_values=[""])  # a block may be called NA
    return frame.fillna({column: "" for column in ("reasons", "reason") if column in frame})


def write_table(stem, frame, text, *, caption, notes=()):
    """Write a printed table: numbers as `<stem>.csv`, printed cells as `<stem>.md` and `<stem>.tex`.

    Parameters
    ----------
    stem : path-like
        Path without suffix.
    frame, text : pandas.DataFrame
        The numeric frame and its printed cells.
    caption : str
        Caption.
    notes : sequence of str
        Footnotes.
    """
    write_csv(frame, f"{stem}.csv")
    for suffix, render in ((".md", markdown), (".tex", latex)):
        write_text(f"{stem}{suffix}", render(text, caption, notes))


def markdown(text, caption, notes=()) -> str:
    """A printed table as GitHub-flavoured Markdown.

    Parameters
    ----------
    text : pandas.DataFrame
        Printed cells.
    caption : str
        Caption.
    notes : sequence of str
        Footnotes.
    """
    rows = [list(text.columns), ["---"] * len(text.columns), *text.values.tolist()]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join([f"**{caption}**", "", *lines, "", *(f"*{note}*  " for note in notes)]).rstrip() + "\n"


def latex(text, caption, notes=()) -> str:
    """A printed table as LaTeX; the document needs no package but booktabs.

    Parameters
    ----------
    text : pandas.DataFrame
        Printed cells.
    caption : str
        Caption.
    notes : sequence of str
        Footnotes.
    """
    font = "small" if len(text.columns) <= 6 else "scriptsize"
    rows = [" & ".join(map(_tex, row)) + r" \\" for row in [list(text.columns), *text.values.tolist()]]
    return "\n".join(
        [
            r"\begin{table}",
            rf"\centering\{font}\setlength{{\tabcolsep}}{{2.5pt}}",
            rf"\caption{{{_tex(caption)}}}",
            rf"\begin{{tabular}}{{{'l' * len(text.columns)}}}",
            r"\toprule",
            rows[0],
            r"\midrule",
            *rows[1:],
            r"\bottomrule",
            r"\end{tabular}",
            *(rf"\par\footnotesize {_tex(note)}" for note in notes),
            r"\end{table}",
            "",
        ]
    )


def numbers_tex(tidy) -> str:
    r"""Every fitted number as a LaTeX macro, for the text of a paper.

    Parameters
    ----------
    tidy : mapping of str to pandas.DataFrame
        From `tidy_tables`.

    Returns
    -------
    str
        A file to `\input`: `\frRecords`, `\frRuns`, and of each fit its parameters with standard error and
        unit, discrepancy and t_f, as `\frConfigTwoMarbleHuntCrossleyK`; of a single run with `RunOne` before
        the model. The numbers of a fit that may not be used are the words "failed fit".
    """
    runs, named = tidy["runs"], {}

    def macro(parts, text):
        name = "fr" + "".join(map(_letters, parts))
        while name in named:  # names that differ by signs alone
            name += "X"
        named[name] = _tex(text)

    macro(["Records"], runs["test"].nunique())
    macro(["Runs"], runs["run"].notna().sum())
    for row in tidy["parameters"].itertuples():
        value = f"{quantity(row.value, row.stderr)} {unit_text(row.unit)}".rstrip()
        macro([*_fit_name(row), row.parameter], value if row.success else "failed fit")
    for row in tidy["epsilon"].itertuples():
        epsilon = f"{quantity(100 * row.epsilon_theta)} %"
        macro([*_fit_name(row), "epsilon"], epsilon if row.success else "failed fit")
        macro([*_fit_name(row), "final_time"], f"{fixed(row.final_time_s, 2)} s")
    notes = [f"% {SIMULATED_NOTE}"] if "simulated" in set(runs["origin"]) else []
    lines = [rf"\newcommand{{\{name}}}{{{text}}}" for name, text in named.items()]
    return "\n".join([*notes, *lines, ""])


def _fit_name(row) -> list:
    return [row.test, *(["run", str(row.run)] if row.run != "pooled" else []), row.model]


DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")


def _letters(name) -> str:
    """A name in letters alone, as LaTeX's macros want it: "config2_marble" is ConfigTwoMarble."""
    spelled = re.sub(r"\d", lambda digit: f"_{DIGITS[int(digit[0])]}_", name)
    words = re.findall("[a-zA-Z]+", spelled)
    return "".join(word[0].upper() + word[1:] for word in words)


TEX = {
    **{char: rf"\{char}" for char in "&%$#_{}"},
    **{"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"},
    **{"±": r"$\pm$", "·": r"$\cdot$", "−": "$-$", "°": r"$^\circ$", "–": "--", "’": "'"},
    **{"α": r"$\alpha$", "λ": r"$\lambda$", "ε_θ": r"$\varepsilon_\theta$", "t_f": "$t_f$"},
    **{"θ₀": r"$\theta_0$", "t₀": "$t_0$", "θ": r"$\theta$", "ε": r"$\varepsilon$"},
}
_TEX_TOKEN = re.compile(
    r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|\bt_f\b|"
    + "|".join(re.escape(key) for key in sorted({*TEX} - {"t_f"}, key=len, reverse=True))
)
_NORMAL_DIGITS = {ord(high): low for high, low in zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True)}


def _tex(text) -> str:
    def command(match):
        return TEX.get(match[0]) or f"$^{{{match[0].translate(_NORMAL_DIGITS)}}}$"

    return _TEX_TOKEN.sub(command, str(text))
