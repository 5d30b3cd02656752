"""The tables of the report: heads and cells; each row leads to its run or record."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import pandas as pd

from freerock.config.review_log import LOOKED_AT, Change, looked_at
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS, MODELS
from freerock.rotation.u_total import OF_LAW
from freerock.runs.verdict import VERDICTS
from freerock.tables.candidates import Answer, answers
from freerock.tables.number_text import INPUT_LABELS, SEEN_NOTE, fixed, quantity, with_unit
from freerock.tables.printed_tables import (
    UNKNOWN_NOTE,
    Cell,
    Column,
    Labels,
    Printed,
    decimals,
    identified,
    is_unknown,
    number,
    numbers,
    with_error,
)

SHOWN = 1.0  # per cent of a square of a total uncertainty, from which a contribution is shown


class Sortable(NamedTuple):
    """A table of the report: heads, and the cells of each row."""

    heads: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str
    notes: Sequence[str] = ()


def _sortable(
    columns: Sequence[Column], rows: Iterable[Any], caption: str, notes: Sequence[str] = ()
) -> Sortable:
    cells = [[column.cell(row) for column in columns] for row in rows]
    return Sortable([column.head for column in columns], cells, caption, notes)


_RECORD = Column("Record", lambda row: Cell(row.test, anchor=f"record-{row.test}"))


def _scene(labels: Labels) -> list[Column]:
    """Block and foundation of a row."""
    return [
        Column("Block", lambda row: Cell(labels.get(row.block, row.block))),
        Column("Foundation", lambda row: Cell(labels.get(row.foundation, row.foundation))),
    ]


def of_blocks(table: Printed, runs: pd.DataFrame, labels: Labels, listed: Collection[str]) -> Sortable:
    """A printed table with a row per block, which leads to its settings and to its records.

    Parameters
    ----------
    table : Printed
        Table 1.
    runs : pandas.DataFrame
        Tidy table.
    labels : mapping of str to str
        Printed names of blocks and foundations.
    listed : collection of str
        Records that have a section in the page.
    """

    def block(row: Any) -> Cell:
        return Cell(labels.get(row.block, row.block), anchor=f"config-blocks-{row.block}")

    def records(row: Any) -> Cell:
        tests = list(dict.fromkeys(runs[runs["block"] == row.block]["test"]))
        n, first = len(tests), next((f"record-{test}" for test in tests if test in listed), "")
        return Cell(str(n), n, first) if first else number(str(n), n) if n else Cell("0")

    columns = [Column("Block", block), *table.columns, Column("Records", records)]
    return _sortable(columns, table.frame.itertuples(), table.caption, table.notes)


def of_records(table: Printed, labels: Labels) -> Sortable:
    """A printed table with several rows per record: tables 2 and 3."""
    columns = [_RECORD, *_scene(labels), *table.columns]
    return _sortable(columns, table.frame.itertuples(), table.caption, table.notes)


def compared(frame: pd.DataFrame, labels: Labels) -> Sortable:
    """Discrepancies of the laws beside each other, from table 3: a row per record, a column per law."""
    by_law = {(row.test, row.model): row for row in frame.itertuples()}

    def law(model: str) -> Column:
        return Column(MODEL_LABELS[model], lambda row: _discrepancy(by_law.get((row.test, model))))

    shown = [law(model) for model in MODEL_LABELS if model in set(frame["model"])]
    columns, rows = [_RECORD, *_scene(labels), *shown], frame.drop_duplicates("test").itertuples()
    note = (
        "†: rejected by most of the runs. Round brackets: a fit that may not be used. All values: appendix."
    )
    note += " Square brackets: as published." if frame["published"].notna().any() else ""
    return _sortable(columns, rows, "Discrepancy ε_θ of each law in per cent, median of the runs", [note])


def _discrepancy(row: Any) -> Cell:
    """ε_θ of a law on a record in per cent; in brackets that of a fit that may not be used."""
    if row is None:
        return Cell("–")
    text = quantity(100 * row.epsilon_theta)
    text = text if row.success else f"({text})"
    text += " †" if row.rejected else ""
    text += f" [{fixed(100 * row.published, 2)}]" if math.isfinite(row.published) else ""
    return number(text, row.epsilon_theta)


def overview(runs: pd.DataFrame, choice: pd.DataFrame, labels: Labels) -> Sortable:
    """Every run with its verdict and the model it needs, from the tidy tables."""
    needed = {(each.test, each.run): each for each in answers(choice)}

    def run(row: Any) -> str:
        return "–" if pd.isna(row.run) else str(row.run)

    def verdict(row: Any) -> Cell:
        kind = "excluded" if row.excluded else row.verdict
        return Cell(row.verdict, -VERDICTS.index(row.verdict), kind=kind)

    columns = [
        Column("Record", lambda row: Cell(row.test, anchor=_anchor(row.test, run(row)))),
        Column("Run", lambda row: Cell(run(row))),
        *_scene(labels),
        Column("Verdict", verdict),
        numbers("θ₀ / °", "theta0_deg", decimals(3)),
        numbers("Release / s", "release_s", decimals(3)),
        numbers("Duration / s", "duration_s", decimals(2)),
        numbers("Zeros", "n_impacts"),
        numbers("with r", "n_restitution"),
        numbers("σ / °", "sigma_theta_deg", partial(quantity, digits=2)),
        Column("Model", lambda row: _named(needed.get((row.test, run(row))))),
    ]
    note = f"Each row leads to its run. {SEEN_NOTE} σ: standard deviation of the noise of θ. "
    note += "Zeros: crossings that stand out of the noise; with r: those with a restitution. "
    note += "Model: the one that explains the run with the fewest parameters."
    return _sortable(columns, runs.itertuples(), "Runs and verdicts", [note])


def choices(choice: pd.DataFrame, labels: Labels) -> Sortable:
    """Runs that no candidate explains or that several do: what they could be, and why."""
    scenes = {row.test: row for row in choice.itertuples()}

    def of_test(column: Column) -> Column:
        return Column(column.head, lambda each: column.cell(scenes[each.test]))

    columns = [
        Column("Record", lambda each: Cell(each.test, anchor=_anchor(each.test, each.run))),
        Column("Run", lambda each: Cell(each.run)),
        *map(of_test, _scene(labels)),
        Column("Model", _named),
        Column("Also possible", lambda each: Cell("; ".join(MODEL_LABELS[m] for m in each.others) or "–")),
        Column("Reason", lambda each: Cell(each.reason)),
    ]
    rows = [each for each in answers(choice) if each.others or not each.explained]
    return _sortable(columns, rows, "Runs without a single answer")


def compared_restitution(compared: pd.DataFrame) -> Sortable:
    """Fitted and per-impact restitution of each record, from the table restitution_comparison."""
    columns = [
        _RECORD,
        with_error("Housner r, fitted", "r_fitted", "r_fitted_u"),
        with_error("r, first impact", "r_first", "r_first_u"),
        with_error("r, median of impacts", "r_median", "r_median_u"),
        Column("Range", lambda row: Cell(f"{row.r_low:.3f} to {row.r_high:.3f}")),
        numbers("First impact / s", "first_impact_s", decimals(4)),
        numbers("First impact, rigid / s", "rigid_s", decimals(4)),
        numbers("r, rigid", "r_housner", decimals(3)),
    ]
    caption = "Restitution fitted and of single impacts, and the mean time from release to the first impact"
    note = "±: total standard uncertainty, with the scatter between the runs. "
    note += "r, first impact: mean of the runs. Rigid: Housner’s block, from the same angles; its r is "
    note += "that of a rigid base."
    return _sortable(columns, compared.itertuples(), caption, [note])


def budget(frame: pd.DataFrame, choice: pd.DataFrame, labels: Labels) -> Sortable:
    """What the total uncertainty of each foundation's parameters is made of, from two tidy tables.

    Rows are of candidates that explain a run or come nearest: of each its mean over the records of the
    foundation, where it has one, else those of the records whose runs it is named for.
    """
    selected = choice[choice["status"] == "selected"]
    of_records, of_foundations = (
        {*zip(selected[each], selected["model"], strict=True)} for each in ("test", "foundation")
    )
    rows, unknown = [], False
    over_records = frame[frame["level"] == "foundation"]
    several = {*zip(over_records["foundation"], over_records["model"], strict=True)}
    keys = ["level", "test", "foundation", "model", "parameter", "unit"]
    for key, parts in frame.groupby(keys, sort=False, dropna=False):
        level, test, foundation, model, parameter, unit = map(str, key)
        of_record = level == "record"
        named = (test, model) in of_records if of_record else (foundation, model) in of_foundations
        if not named or parameter not in MODELS[model]:
            continue
        if of_record and (foundation, model) in several:
            continue
        first = parts.iloc[0]
        share = 100 * first["u_total"] / abs(first["mean"])
        unknown = unknown or bool(is_unknown(first["mean"], first["u_total"]))
        of = f", {test}" if of_record else ""
        anchor = f"record-{test}" if of_record else f"config-foundations-{foundation}"
        rows.append(
            [
                Cell(labels.get(foundation, foundation) + of, anchor=anchor),
                Cell(MODEL_LABELS[model]),
                Cell(with_unit(SYMBOLS[parameter], unit)),
                number(identified(first["mean"], first["u_total"]), first["mean"]),
                number(quantity(share, digits=2), share),
                Cell(_largest(parts, labels)),
            ]
        )
    heads = ["Foundation", "Model", "Parameter", "Mean", "u / %", "Largest shares of its square"]
    note = (
        "u: total standard uncertainty (one standard deviation). Runs: noise, and differences between runs "
        "and between records. Law: misfit of the law; see docs/uncertainty.md. (d): a default, "
        "as the laboratory stated none; see config/README.md. Every share: tables/budget.csv."
    )
    return Sortable(heads, rows, "Uncertainty budget", [note] + [UNKNOWN_NOTE] * unknown)


def _largest(parts: pd.DataFrame, labels: Labels) -> str:
    """The largest contributions of a mean, in words."""
    shown = parts[parts["share_percent"] >= SHOWN]
    told = []
    for row in shown.sort_values("share_percent", ascending=False, kind="stable").head(4).itertuples():
        share, name = f"{row.share_percent:.0f} %", INPUT_LABELS[row.input]
        if row.input not in ("runs", OF_LAW):
            name += f" of {labels.get(row.input_owner, row.input_owner)}"
            share += " (d)" * (row.input_stated == 0)
        told.append(f"{name} {share}")
    return "; ".join(told)


def _named(answer: Answer | None) -> Cell:
    """The model of a run, marked where it doesn't explain it."""
    if answer is None or answer.explained:
        return Cell(MODEL_LABELS[answer.model] if answer else "–")
    nearest = f", nearest {MODEL_LABELS[answer.model]}" if answer.model else ""
    return Cell(f"none explains it{nearest}", kind="warn")


def by_hand(changes: Sequence[Change], config: Mapping[str, Any], listed: Collection[str]) -> Sortable | None:
    """What was changed at the review desk, newest first; None where nothing was.

    Parameters
    ----------
    changes : sequence of Change
    config : mapping
        The campaign's section: a line whose cell holds something else by now is marked.
    listed : collection of str
        Records that have a section in the page.
    """
    now = {line["test"]: line for line in config["records"]}
    cells = [each for each in changes if each.cell != LOOKED_AT]
    last = {(each.test, each.cell): each for each in cells}
    rows = []
    for each in reversed(cells):
        held = now.get(each.test, {}).get(each.cell, "")
        other = last[each.test, each.cell] is each and " ".join(each.after.split()) != held
        anchor = f"record-{each.test}" if each.test in listed else ""
        why = each.why + (" (the CSV holds something else by now)" if other else "")
        texts = (each.time, each.login, each.cell, each.before or "–", each.after or "–", why)
        rows.append([Cell(each.test, anchor=anchor), *map(Cell, texts)])
    heads = ["Record", "When", "Who", "Cell", "From", "To", "Why"]
    return Sortable(heads, rows, "Changes at the review desk, newest first") if rows else None


def changes_seen(changes: Sequence[Change], runs: pd.DataFrame) -> str:
    """How many runs were looked at since they were last corrected, and by whom; empty where nobody did."""
    looked = looked_at(changes)
    known = {(row.test, "" if pd.isna(row.run) else str(row.run)) for row in runs.itertuples()}
    mine = [each for key, each in looked.items() if key in known]
    people = ", ".join(sorted({each.login for each in mine}))
    return f"Looked at: {len(mine)} of {len(known)} runs, by {people}." if mine else ""


def _anchor(test: str, run: str) -> str:
    return f"record-{test}" if run == "–" else f"run-{test}-{run}"
