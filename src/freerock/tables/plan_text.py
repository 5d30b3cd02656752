"""The plan of a campaign as printed: standard errors in per cent of the values, and rivals in words."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.tables.number_text import INPUT_LABELS

CASE = ["block", "foundation", "laser", "sensor", "duration", "rate", "angle"]


def plan_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """The plan as a reader sees it: standard errors in per cent of the values, and why some are missing.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan.plan`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        A line per case with a column per parameter; the standard error of a tilt; a line per reason.
    """
    rows = _printed(frame, labels)
    rows = rows.assign(
        parameter=rows["model"] + " " + rows["parameter"].map(SYMBOLS),
        percent=[_percent(*pair) for pair in zip(rows["stderr"], rows["value"], strict=True)],
    )
    alike, shown = _columns(rows)
    table = rows.set_index([*shown, "parameter"])["percent"].unstack(sort=False)
    title = ", ".join(["Standard errors by noise alone in %, inputs exact", *rows[alike].iloc[0]])
    reasons = [
        f"{row.block} on {row.foundation} from {row.angle}: {row.note}"
        for row in rows.itertuples()
        if row.note
    ]
    return "\n".join([title, table.to_string(), *_tilt(frame), *dict.fromkeys(reasons)])


def _tilt(frame: pd.DataFrame) -> list[str]:
    """How well the runs tell a base off level; nothing where none does."""
    errors = frame["tilt_stderr_deg"]
    known = errors[np.isfinite(errors)]
    if known.empty:
        return []
    return [f"a base off level is told to ±{known.min():.1g} … {known.max():.1g}° by a fit that must find it"]


def rivals_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """Which rivals a campaign will tell from what is expected, as a reader sees it.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan.plan_rivals`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        At the lowest sampling rate, a line per case with the nearest rival of each expected model; then a
        sentence per model and rival. "" where no model has a rival.
    """
    if frame.empty:
        return ""
    slowest = frame["sampling_rate_hz"] == frame["sampling_rate_hz"].min()
    rows = _printed(frame[slowest], labels)
    alike, shown = _columns(rows)
    rows["where"] = rows[shown].agg(", ".join, axis=1)
    nearest = rows.sort_values("bic_difference", kind="stable").drop_duplicates(["where", "model"])
    cells = [
        "–" if np.isnan(row.bic_difference) else f"{row.bic_difference:.2g} ({_share(row.epsilon_theta)})"
        for row in nearest.sort_index().itertuples()
    ]
    table = nearest.sort_index().assign(cell=cells).set_index([*shown, "model"])["cell"].unstack(sort=False)
    title = ", ".join(["Δ of the nearest rival (ε_θ between the two)", *rows[alike].iloc[0]])
    pairs = rows[rows["note"] == ""].groupby(["model", "rival"], sort=False)
    sentences = [_sentence(f"{model} against {rival}", pair) for (model, rival), pair in pairs]
    return "\n".join([title, table.to_string(), "", *sentences])


def totals_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """What more runs and better known inputs would do for the total uncertainty, as a reader sees it.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan_total.plan_totals`; not empty.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        A line per parameter and block, in the case that knows it best (`best_known`): u in per cent of the
        value by the number of runs; of the most runs their share in u², the input to measure first, and u
        were it exact.
    """
    best = _named(best_known(frame), labels)
    keys = ["foundation", "", "block"]
    best[""] = best["model"].map(MODEL_LABELS) + " " + best["parameter"].map(SYMBOLS)
    rows = []
    for key, own in best.groupby(keys, sort=False):
        own = own.sort_values("n_runs")
        by_n = {f"n = {row.n_runs}": _percent(row.u_total, row.value) for row in own.itertuples()}
        last = own.iloc[-1]
        case = (
            f"{last.sensor}, {last.duration_s:g} s, {last.sampling_rate_hz:g} Hz, {last.release_angle_deg:g}°"
        )
        row = {**dict(zip(keys, key, strict=True)), **by_n, **_first(last)}
        rows.append(row | {"best case": case if last.laser else ""})
    table = pd.DataFrame(rows).set_index(keys)
    lines = ["Total uncertainty u (k = 1) of the mean of n runs of each block in %", table.to_string()]
    if (best["spread_fraction"] == 0).any():
        lines.append("the spread between runs is 0 where plan.spread_fraction gives none")
    return "\n".join(lines)


def _first(row: pd.Series) -> dict[str, str]:
    """The share of the runs in u², the input to measure first, and u were it exact; "–" if no less."""
    of_runs = (row["runs_fraction"] * row["value"] / row["u_total"]) ** 2
    u, exact = (_percent(row[name], row["value"]) for name in ("u_total", "u_total_without_first"))
    first = "–" if exact == u else f"{INPUT_LABELS[row['first_input']]} of {row['first_owner']}"
    return {
        "runs": f"{100 * of_runs:.0f} %",
        "measure first": first,
        "if exact": "–" if exact == u else exact,
    }


def best_known(frame: pd.DataFrame) -> pd.DataFrame:
    """Of each foundation, model, parameter, block and number of runs the case of least total uncertainty."""
    of_mean = ["foundation", "model", "parameter"]
    least = frame.groupby([*of_mean, "block", "n_runs"])["u_total"].idxmin()
    found = frame.loc[sorted(least)]
    return found.sort_values(of_mean, key=lambda names: pd.factorize(names)[0], kind="stable")


def _sentence(pair: str, rows: pd.DataFrame) -> str:
    """How a rival fares against an expected model, over all cases that can be measured."""
    rows = rows.sort_values(["epsilon_theta", "bic_difference"])
    apart, missed = rows[rows["told_apart"]], rows[~rows["told_apart"]]
    text = f"{pair}: told apart in {len(apart)} of {len(rows)}"
    if len(apart):
        text += f", best by {_case(apart.iloc[-1])}"
    if len(missed):
        return f"{text}; least by {_case(missed.iloc[0])}"
    return f"{text}, barely by {_case(apart.iloc[0])}"


def _case(row: pd.Series) -> str:
    return f"{row['where']} (Δ = {row['bic_difference']:.2g}, ε_θ = {_share(row['epsilon_theta'])})"


def _printed(frame: pd.DataFrame, labels: Mapping[str, str] | None) -> pd.DataFrame:
    """The rows with names and choices as printed."""
    frame = _named(frame, labels)
    return frame.assign(
        duration=frame["duration_s"].map("{:g} s".format),
        rate=frame["sampling_rate_hz"].map("{:g} Hz".format),
        angle=frame["release_angle_deg"].map("{:g}°".format),
        **{name: frame[name].map(MODEL_LABELS) for name in ("model", "rival") if name in frame},
    )


def _named(frame: pd.DataFrame, labels: Mapping[str, str] | None) -> pd.DataFrame:
    """The rows with printed names of blocks and foundations."""
    return frame.replace({"block": labels or {}, "foundation": labels or {}})


def _columns(rows: pd.DataFrame) -> tuple[list[str], list[str]]:
    """Which of the choices are alike in all rows, and which are shown as columns."""
    alike = [name for name in CASE if rows[name].nunique() == 1]
    return alike, [name for name in CASE if name not in alike] or ["angle"]


def _share(fraction: float) -> str:
    return f"{100 * fraction:.2g} %"


def _percent(stderr: float, value: float) -> str:
    return f"{100 * stderr / value:.2g}" if np.isfinite(stderr) else "–"
