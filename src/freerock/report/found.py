"""What was found: a row for each foundation, and the parameters of each record."""

from collections.abc import Mapping

import pandas as pd

from freerock.errors import number_of
from freerock.models.free_parameters import PARAMETERS, SYMBOLS
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS
from freerock.report.printed import PROCEDURE, Labels, Printed, identified
from freerock.tables.choices import QUOTED
from freerock.tables.number_text import fixed, percent, quantity, unit_text, with_unit

NO_BREAK = "\N{NO-BREAK SPACE}"
PREDICTED = "A run predicted from the others"
MOST_BESIDE = 3  # foundations that have a column each, and blocks that are named


def printed_summary(frame: pd.DataFrame, runs: pd.DataFrame, labels: Labels) -> Printed:
    """What was found of each foundation: the first table of the report.

    Parameters
    ----------
    frame, runs : pandas.DataFrame
        The tables of these names.
    labels : mapping of str to str
        Printed names of blocks and foundations.
    """
    usable = runs[(runs["verdict"] != "fail") & ~runs["excluded"].astype(bool)]
    rows = []
    for row in frame.to_dict("records"):
        parameters = [
            f"{SYMBOLS[name]} = {identified(row[name], row[f'{name}_u'])} {unit_text(PARAMETERS[name].unit)}"
            for name in QUOTED
            if pd.notna(row[name])
        ]
        here = usable["foundation"] == row["foundation"]
        elsewhere = {*usable[here]["block"]} & {*usable[~here]["block"]}
        longest = str(row["longest"]).split() if pd.notna(row["longest"]) else []
        law, scatter = MODEL_LABELS.get(row["model"], "none"), (100 * row["sigma_r"], 100 * row["sigma_r_u"])
        epsilon = [
            f"{MODEL_LABELS[name]} {percent(row[f'epsilon_{name}'])}".replace(" ", NO_BREAK)
            for name in PAPER_MODELS
            if pd.notna(row[f"epsilon_{name}"])
        ]
        told = {
            "Foundation": labels.get(row["foundation"], row["foundation"]),
            "Rocking lasts / s, median": _lasting(usable[here], labels),
            "Blocks that rock longest on it": ", ".join(labels.get(block, block) for block in longest)
            or ("none" if elsewhere else "–"),
            "Selected law": f"{law}, {row['n_selected']} of {number_of(row['n_runs'], 'run')}",
            "Parameters": "; ".join(parameters).replace(" ", NO_BREAK).replace(f";{NO_BREAK}", "; "),
            "Scatter of impacts σ_r / %": quantity(*scatter) if scatter[0] else "none found",
            PREDICTED: _predicted(row["n_inside"], row["n_peaks"], row["half_band"]),
            "r of first impacts": fixed(row["r_first"], 3),
            "ε_θ / %": ", ".join(epsilon),
        }
        rows.append({head: cell or "–" for head, cell in told.items()})
    text = pd.DataFrame(rows)
    text = text.loc[:, [name for name in text if {*text[name]} - {"–", "none"}]]
    about = (
        "±: total standard uncertainty. r of first impacts: median of all runs, by energy (in figures: "
        "from peaks). "
        f"ε_θ of the laws: median, {PROCEDURE}."
    )
    if PREDICTED in text:
        about += f" {PREDICTED}: the 95 % band of its peaks from the other runs of its record (half its "
        about += "width, median), and the peaks in it."
    if 0 < len(text) <= MOST_BESIDE:
        text = text.set_index("Foundation").T.reset_index(names="Foundation")
    return Printed(text, "Each foundation", [about])


def _lasting(runs: pd.DataFrame, labels: Labels) -> str:
    """How long each block rocks, and the range of many."""
    seconds = runs.groupby("block", sort=False)["duration_s"].median().dropna()
    if len(seconds) > MOST_BESIDE:
        return f"{quantity(seconds.median())}; blocks: {quantity(seconds.min())} to {quantity(seconds.max())}"
    return "; ".join(f"{labels.get(block, block)}: {quantity(each)}" for block, each in seconds.items())


def _predicted(n_inside: float, n_peaks: float, half_band: float) -> str:
    """How wide the band of peaks is, how many lay in it, and how many should."""
    if not n_peaks:
        return ""
    width = f"peaks to ± {quantity(100 * half_band, digits=2)} %; " if pd.notna(half_band) else ""
    return f"{width}{n_inside} of {n_peaks} inside ({fixed(100 * n_inside / n_peaks, 0)} %; expected: 95 %)"


def printed_records(populations: pd.DataFrame, laws: Mapping[str, str], labels: Labels) -> Printed:
    """Parameters of each record under the candidate selected for its foundation, from the tidy table."""
    own = populations[populations["level"] == "record"]
    own = own[own["model"] == own["foundation"].map(laws)]
    rows = [
        {
            "Record": row.test,
            "Block": labels.get(row.block, row.block),
            "Foundation": labels.get(row.foundation, row.foundation),
            "Law": MODEL_LABELS[row.model],
            "Parameter": with_unit(SYMBOLS[row.parameter], row.unit),
            "Mean": identified(row.mean, row.u_total),
            "τ / %": quantity(100 * row.tau / row.mean, digits=2) if row.tau > 0 else "–",
            "Runs": str(row.n_runs),
        }
        for row in own.itertuples()
    ]
    about = "Law: selected for most runs of the foundation. τ: spread between runs beyond their noise; "
    notes = [about + "–: none found, or one run."]
    notes += ["2b: the width in contact."] * bool((own["parameter"] == "width").any())
    return Printed(pd.DataFrame(rows), "Parameters of each record", notes)
