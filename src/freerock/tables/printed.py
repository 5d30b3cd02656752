"""The tables as a reader sees them: text of each cell, caption and notes."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd

from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS
from freerock.tables.number_text import SIMULATED_NOTE, fixed, percent, quantity, unit_text

Labels = Mapping[str, str]
PROCEDURE = "by the paper's own procedure: one motion over the whole run, no input or impact free"
MOST_IMPACTS, MOST_ROWS = 8, 40  # in the table of restitution, of a run and of a page
LEAST_R = 0.1  # with less a block falls to rest at once
MOST_BESIDE = 4  # blocks that have a column each


class Printed(NamedTuple):
    """A printed table: cells as text below their heads, caption and notes.

    A row with nothing but its first cell is a heading across the table.
    """

    text: pd.DataFrame
    caption: str
    notes: Sequence[str] = ()


def printed_tables(
    frames: Mapping[str, pd.DataFrame], origin: str, *, doi: str = "", labels: Labels | None = None
) -> dict[str, Printed]:
    """Tables 1 to 3 in the layout of Spanos et al. 2017, and r of each impact beside the laws.

    Parameters
    ----------
    frames : mapping of str to pandas.DataFrame
        table1 to table3, restitution and epsilon, by name.
    origin : str
        Of the records, "measured" or "simulated".
    doi : str, optional
        Of the publication whose values stand beside; empty without one.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    """
    labels, simulated = labels or {}, [SIMULATED_NOTE] if "simulated" in origin else []
    published = [f"Published: doi:{doi}."] if doi else []
    return {
        "table1": _table1(frames["table1"], labels, simulated),
        "table2": _table2(frames["table2"], labels, [*published, *simulated]),
        "table3": _table3(frames["table3"], labels, [*published, *simulated]),
        "restitution": _restitution(frames["restitution"], labels, simulated),
    }


def _table1(frame: pd.DataFrame, labels: Labels, notes: Sequence[str]) -> Printed:
    """A column per block; a row each of many."""
    rows: dict[str, Any] = {
        "2h / m": lambda row: _stated(row.height_m),
        "2b / m": lambda row: _stated(row.width_m),
        "h/b": lambda row: _stated(row.slenderness),
        "m / kg": lambda row: _stated(row.mass_kg),
        "α / °": lambda row: _stated(row.alpha_nominal_deg),
        "α recorded / °": lambda row: quantity(row.alpha_deg, row.alpha_std_deg),
        "θ_cr / °": lambda row: quantity(row.theta_cr_deg, digits=4),
        "R / m": lambda row: quantity(row.R_m, digits=4),
        "p / (rad s⁻¹)": lambda row: quantity(row.p_rad_s, digits=4),
        "r (Housner)": lambda row: quantity(row.r_housner, digits=4),
    }
    blocks = list(frame.itertuples())
    cells = {head: [cell(row) for row in blocks] for head, cell in rows.items()}
    cells = {head: own for head, own in cells.items() if set(own) != {"–"}}
    names = [labels.get(row.block, row.block) for row in blocks]
    text = pd.DataFrame(list(cells.values()), index=list(cells), columns=names)
    beside = len(names) <= MOST_BESIDE
    text = text.reset_index(names="") if beside else text.T.reset_index(names="Block")
    about = "α: release angle; recorded: mean of the runs ± their standard deviation. θ_cr: critical angle."
    return Printed(text, "Block configurations", [about, *notes])


def _table2(frame: pd.DataFrame, labels: Labels, notes: Sequence[str]) -> Printed:
    """Laws by foundations: identified, by the paper's own procedure, and as published."""
    kinds: dict[str, Callable[[Any], str]] = {
        "Identified": lambda row: _of_law(row.parameter, row.mean, row.u_total),
        "Paper's procedure": lambda row: _of_law(row.parameter, row.paper),
        "Published": lambda row: _of_law(row.parameter, row.published),
    }
    frame = frame.fillna({"block": ""})
    several = frame["block"].nunique() > 2  # one of Housner's r, and those of foundations
    cells: list[tuple[str, str, str, str]] = []
    for kind, cell in kinds.items():
        for (law, block, base), own in frame.groupby(["model", "block", "foundation"], sort=False):
            name = MODEL_LABELS[law] + f", {labels.get(block, block)}" * bool(block and several)
            if told := [text for row in own.itertuples() if (text := cell(row))]:
                cells.append((kind, name, base, ", ".join(told)))
    units = frame[frame["unit"] != "1"].drop_duplicates("parameter")
    known = [f"{SYMBOLS[row.parameter]} in {unit_text(row.unit)}" for row in units.itertuples()]
    about = (
        "Identified: mean of the records ± total standard uncertainty, inputs and impacts free. Paper's "
        "procedure: median of the runs, one motion over the whole run, no input or impact free. "
        f"{', '.join(known)}."
    )
    return Printed(_by_law("", cells, labels), "Identified parameters", [about, *notes])


def _of_law(parameter: str, value: float, u: float = math.nan) -> str:
    """A parameter as table 2 has it; empty where it is not known."""
    if parameter == "r" and value < LEAST_R:
        return f"r < {LEAST_R}"
    return f"{SYMBOLS[parameter]} = {identified(value, u)}" if math.isfinite(value) else ""


def _table3(frame: pd.DataFrame, labels: Labels, notes: Sequence[str]) -> Printed:
    """ε_θ of the laws by foundations, below each block."""
    cells = [
        (labels.get(row.block, row.block), MODEL_LABELS[row.model], row.foundation, _epsilon(row))
        for row in frame.itertuples()
    ]
    about = f"Median of the runs, {PROCEDURE}."
    beside = " In brackets: published." if frame["published"].notna().any() else ""
    caption = "ε_θ between recorded and modelled rotation"
    return Printed(_by_law("ε_θ / %", cells, labels), caption, [about + beside, *notes])


def _by_law(first: str, cells: Sequence[tuple[str, str, str, str]], labels: Labels) -> pd.DataFrame:
    """Cells, of part, law, foundation and text: laws by foundations, the parts below each other."""
    foundations = list(dict.fromkeys(base for _, _, base, _ in cells))
    text = {cell[:3]: cell[3] for cell in cells}
    lines: list[list[str]] = []
    for part in dict.fromkeys(each for each, *_ in cells):
        lines.append([part, *[""] * len(foundations)])
        for name in dict.fromkeys(law for each, law, *_ in cells if each == part):
            lines.append([name, *(text.get((part, name, base), "–") for base in foundations)])
    return pd.DataFrame(lines, columns=[first, *(labels.get(base, base) for base in foundations)])


def _epsilon(row: Any) -> str:
    text = percent(row.epsilon_theta, 3) if row.n_runs else "failed fit"
    return text + (f" [{fixed(100 * row.published, 2)}]" if math.isfinite(row.published) else "")


def _restitution(frame: pd.DataFrame, labels: Labels, notes: Sequence[str]) -> Printed:
    """r of the first impacts of the first run of each record beside the three laws; notes if simulated."""
    kind = "Simulated record" if notes else "Experiment"
    heads = ["Impact", "|θ| / °", kind, *(MODEL_LABELS[law] for law in PAPER_MODELS)]
    lines: list[list[str]] = []
    scenes = frame.groupby(["block", "foundation"], sort=False)
    shown = min(MOST_IMPACTS, max(1, MOST_ROWS // max(1, len(scenes)) - 1))
    for (block, foundation), scene in scenes:
        seen = scene[(scene["source"] == "experiment") & scene["r"].notna()]
        if seen.empty:
            continue
        test, run = seen.iloc[0][["test", "run"]]
        own = scene[(scene["test"] == test) & (scene["run"].astype(str) == str(run))]
        of_law = {(row.source, row.impact): row.r for row in own.itertuples()}
        seen = seen[(seen["test"] == test) & (seen["run"].astype(str) == str(run))]
        name = f"{labels.get(str(block), block)}, {labels.get(str(foundation), foundation)}"
        part = f"; the first {shown} of {len(seen)} impacts with r" if len(seen) > shown else ""
        lines.append([f"{name} ({test}, run {run}{part})", *[""] * (len(heads) - 1)])
        for row in seen.head(shown).itertuples():
            modelled = [of_law.get((law, row.impact), math.nan) for law in PAPER_MODELS]
            told = [str(row.impact), fixed(row.peak_before_deg, 2), quantity(row.r, row.r_u)]
            lines.append([*told, *(fixed(each, 3) for each in modelled)])
    about = (
        "r from the peaks before and after each impact, as the sensor shows them; by energy: r_energy in "
        f"restitution.csv. Laws {PROCEDURE}. –: the law has none there."
    )
    caption = f"Restitution of each impact from peaks, {kind.lower()} and laws"
    return Printed(pd.DataFrame(lines, columns=heads), caption, [about, *notes])


def identified(mean: float, u: float) -> str:
    """A mean with its total standard uncertainty; in a word where that exceeds it."""
    return "undetermined" if u > abs(mean) else quantity(mean, u)


def _stated(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"
