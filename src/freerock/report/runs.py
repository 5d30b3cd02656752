"""The runs of a campaign as the report lists them: verdicts, laws and why, changes by hand."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from freerock.config.review_log import LOOKED_AT, Change, looked_at
from freerock.errors import number_of
from freerock.models.laws import MODEL_LABELS
from freerock.report.printed import Labels, Printed
from freerock.runs.verdict import VERDICTS
from freerock.tables.choices import STATUS_WORDS
from freerock.tables.number_text import fixed, quantity

NUMBER = r"(?<= leaves )([\d.e+]+)(?= times)"  # in the reason why a candidate was not fitted
OF_TESTS = "Residual / noise: root of the ratio of their powers, largest of the runs. All: tables/choice.csv."
MOST_LISTED = 120  # runs in the page; all stand in the tables


def listed(runs: pd.DataFrame) -> pd.DataFrame:
    """The runs that the page lists: all, or those with the worst verdicts; an excluded run needs no look."""
    need = runs["verdict"].map(VERDICTS.index).where(~runs["excluded"].astype(bool), 0)
    worst = need.sort_values(ascending=False, kind="stable").index[:MOST_LISTED]
    return runs.loc[sorted(worst)]


def printed_runs(runs: pd.DataFrame, choice: pd.DataFrame, labels: Labels, n_runs: int) -> Printed:
    """Every listed run with its verdict and the law selected for it."""
    selected = choice[choice["status"] == "selected"]
    law = {(row.test, str(row.run)): row.model for row in selected.itertuples()}
    rows = [
        {
            "Record": row.test,
            "Run": "–" if pd.isna(row.run) else str(row.run),
            "Block": labels.get(row.block, row.block),
            "Foundation": labels.get(row.foundation, row.foundation),
            "Verdict": row.verdict + ", excluded" * bool(row.excluded),
            "α / °": quantity(row.theta0_deg, row.theta0_u_deg),
            "Duration / s": fixed(row.duration_s, 2),
            "Zero crossings": "–" if pd.isna(row.run) else f"{row.n_impacts} ({row.n_restitution} with r)",
            "σ / °": quantity(row.sigma_theta_deg, digits=2),
            "Law": MODEL_LABELS.get(law.get((row.test, str(row.run)), ""), "–"),
        }
        for row in runs.itertuples()
    ]
    notes = [
        "α: release angle as the sensor shows it, ± its total standard uncertainty. "
        "Zero crossings: those of θ that stand out of the noise; the last ones are no impacts, as the base "
        "stays in full contact; with r: impacts whose restitution is known. "
        "σ: standard deviation of the noise of θ at rest."
    ]
    if len(runs) < n_runs:
        notes.append(f"Listed: {len(runs)} of {n_runs} runs, those that most need a look; all: runs.csv.")
    return Printed(pd.DataFrame(rows), "Runs and verdicts", notes)


def printed_choices(choice: pd.DataFrame, runs: pd.DataFrame) -> Printed:
    """Which law each record has, and why, in the words of the choice."""
    shown = choice[(choice["status"] == "selected") & choice["test"].isin(runs["test"])]
    rows = [
        {"Record": row.test, "Law": MODEL_LABELS[row.model], "Why": row.reason}
        for row in shown.drop_duplicates(["test", "model", "reason"]).itertuples()
    ]
    left = choice[(choice["status"] == "not_fitted") & choice["test"].isin(runs["test"])]
    told = [f"Not fitted to whole runs: {_left_out(left)}."] if len(left) else []
    return Printed(pd.DataFrame(rows), "Which law, and why", told)


def _left_out(left: pd.DataFrame) -> str:
    """Candidates that were not fitted, by the reason; where reasons differ in a number, its range."""
    reasons = left["reason"].astype(str)
    numbers = pd.to_numeric(reasons.str.extract(NUMBER, expand=False), errors="coerce")
    known = left.assign(number=numbers, why=reasons.str.replace(NUMBER, "#", n=1, regex=True))
    parts = []
    for why, own in known.groupby("why", sort=False):
        least, most = own["number"].min(), own["number"].max()
        ends = [f"{end:.3g}" if end < 1000 else f"{end:.0f}" for end in (least, most)]
        names = "; ".join(MODEL_LABELS[model] for model in own["model"].unique())
        parts.append(f"{names} ({str(why).replace('#', ' to '.join(dict.fromkeys(ends)))})")
    return ". ".join(parts)


def printed_tests(choice: pd.DataFrame, runs: pd.DataFrame) -> Printed:
    """The candidates of each record, a row for runs that are alike; p-values where there are any."""
    shown = choice[choice["test"].isin(runs["test"]) & (choice["status"] != "not_fitted")]
    rows = pd.DataFrame(
        {
            "Record": shown["test"],
            "Candidate": shown["model"].map(MODEL_LABELS),
            "Status": shown["status"].map(STATUS_WORDS),
            "Residual / noise": [quantity(each, digits=2) for each in shown["residual_over_noise"]],
            "p (prediction)": [quantity(each, digits=2) for each in shown["p_prediction"]],
            "Runs": shown["run"].astype(str),
        }
    )
    if {*rows["p (prediction)"]} <= {"–"}:
        del rows["p (prediction)"]
    alike = rows.groupby([name for name in rows if name != "Runs"], sort=False)["Runs"]
    text = alike.agg(", ".join).reset_index().head(MOST_LISTED)
    return Printed(text, "Candidates and tests", [OF_TESTS])


def by_hand(changes: Sequence[Change], config: Mapping[str, Any]) -> Printed | None:
    """What was changed at the review desk, newest first; None where nothing was.

    Parameters
    ----------
    changes : sequence of Change
    config : mapping
        The campaign's section: a line whose cell holds something else by now is marked.
    """
    now = {line["test"]: line for line in config["records"]}
    cells = [each for each in changes if each.cell != LOOKED_AT]
    last = {(each.test, each.cell): each for each in cells}
    rows = []
    for each in reversed(cells):
        held = now.get(each.test, {}).get(each.cell, "")
        other = last[each.test, each.cell] is each and " ".join(each.after.split()) != held
        why = each.why + " (the CSV holds something else by now)" * other
        texts = (each.test, each.time, each.login, each.cell, each.before or "–", each.after or "–", why)
        rows.append(dict(zip(("Record", "When", "Who", "Cell", "From", "To", "Why"), texts, strict=True)))
    return Printed(pd.DataFrame(rows), "Changes at the review desk, newest first") if rows else None


def changes_seen(changes: Sequence[Change], runs: pd.DataFrame) -> str:
    """How many runs were looked at since they were last corrected, and by whom; empty where nobody did."""
    looked = looked_at(changes)
    known = {(row.test, "" if pd.isna(row.run) else str(row.run)) for row in runs.itertuples()}
    mine = [each for key, each in looked.items() if key in known]
    people = ", ".join(sorted({each.login for each in mine}))
    return f"Looked at: {len(mine)} of {number_of(len(known), 'run')}, by {people}." if mine else ""
