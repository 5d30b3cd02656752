"""The tables as a reader sees them: text of each cell, caption and notes."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd

from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS, PAPER_MODELS, law_of
from freerock.tables.number_text import fixed, percent, quantity, unit_text

Labels = Mapping[str, str]
PROCEDURE = "by the paper's own procedure: one motion over the whole run, no input or impact free"
MOST_IMPACTS, MOST_ROWS = 8, 40  # in the table of restitution, of a run and of a page
MOST_BESIDE = 4  # blocks that have a column each
FAR = 0.5  # ε_θ above it is no likeness: set on Palermo, where 0.3 still swings and 0.51 lies still
STOPS = 0.01  # r below it is no restitution: the block stops at its first impact
APART = 2.0  # runs of one scene whose values differ by more have no common value
KINDS = ("paper's procedure", "inputs and impacts free")  # of identification
TOLD = {  # where it occurs in a table
    "Hunt–Crossley": "Hunt–Crossley: the paper's proposal.",
    "†": "†: ε_θ above 50 %, or r < 0.01: the block stops at its first impact.",
    "‡": "‡: runs differ over twofold.",
    "pivoting": "pivoting: about the corners; the paper holds the middle of the base.",
    "width free": "width free: the width in contact is identified (populations.csv).",
}
OF_BLOCKS = {  # by the head of a row of table 1
    "α / °": "α: nominal release angle.",
    "α recorded / °": "α recorded: release angle as the sensor shows it, mean of runs whose hold was "
    "seen, ± total standard uncertainty.",
    "θ_cr / °": "θ_cr: critical angle.",
    "R / m": "R: from corner to centre of mass.",
    "p / (rad s⁻¹)": "p² = m g R over the moment of inertia about the corner.",
    "r (Housner)": "r (Housner): ideal restitution of the rigid block.",
}
# Of simulated records beside published values, and of a law that the paper found worse.
TRUTH = " (the records are simulated, so that agreement proves nothing; a wrong law takes another k̄)"
AGAINST = (
    "§: smaller than that of Hunt–Crossley, unlike in the paper. This procedure takes impacts and motion as "
    "exact, so that a wrong law may fit better."
)
Part = tuple[str, str]  # kind of identification, and block
Cell = tuple[Part, str, str, str]  # part, law, foundation and text


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
    labels, simulated = labels or {}, "simulated" in origin
    tables = {
        "table1": _table1(frames["table1"], labels),
        "table2": _table2(frames["table2"], labels, doi, simulated),
        "table3": _table3(frames["table3"], labels),
        "restitution": _restitution(frames["restitution"], labels, simulated),
    }
    said = " (simulated records)" * simulated
    return {name: each._replace(caption=each.caption + said) for name, each in tables.items()}


def _table1(frame: pd.DataFrame, labels: Labels) -> Printed:
    """A column per block; a row each of many."""
    rows: dict[str, Any] = {
        "2h / m": lambda row: _stated(row.height_m),
        "2b / m": lambda row: _stated(row.width_m),
        "h/b": lambda row: _stated(row.slenderness),
        "m / kg": lambda row: _stated(row.mass_kg),
        "α / °": lambda row: _stated(row.alpha_nominal_deg),
        "α recorded / °": lambda row: quantity(row.alpha_deg, row.alpha_u_deg),
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
    told = [meaning for head, meaning in OF_BLOCKS.items() if head in cells]
    return Printed(text, "Block configurations", [" ".join(told)])


def _table2(frame: pd.DataFrame, labels: Labels, doi: str, simulated: bool) -> Printed:
    """Laws by foundations: by the paper's own procedure for each block, as published, and over all blocks."""
    frame = frame.fillna({"block": "", "rejected": False})
    frame["rejected"] = frame["rejected"].astype(bool) | (frame["epsilon_theta"] > FAR)
    blocks = [block for block in frame["block"].unique() if block]
    one = len(blocks) == 1
    cells: list[Cell] = []
    for block in blocks:
        own = frame[(frame["block"] == block) & frame["model"].isin(PAPER_MODELS)]
        cells += _cells((KINDS[0], "" if one else labels.get(block, block)), own, _by_procedure)
    of_foundations = frame[frame["model"].map(lambda model: law_of(model).is_foundation).astype(bool)]
    means = of_foundations[of_foundations["block"] == ""]
    alone, every = frame.drop(of_foundations.index), (KINDS[1], "" if one else "All blocks")
    cells += _cells(every, alone, _mean, {} if one else labels)
    cells += _cells(every, means, _mean)
    text = _by_law("", cells, labels)
    units: dict[str, list[str]] = {}
    for row in frame[frame["unit"] != "1"].drop_duplicates(["model", "parameter"]).itertuples():
        units.setdefault(unit_text(row.unit), []).append(_symbol(row))
    known = [f"{' and '.join(dict.fromkeys(symbols))} in {unit}" for unit, symbols in units.items()]
    about = f"{_of_runs(frame[frame['block'] != ''])}; with ±: mean and total standard uncertainty; "
    about += "rejected: possible for no run."
    proposed = frame[frame["model"] == "hunt_crossley"]
    made = simulated and proposed["published"].notna().any() and not proposed["rejected"].any()
    beside = f"In brackets: published{TRUTH if made else ''}, doi:{doi}."
    seen = " ".join([*text, *text.to_numpy().ravel()])
    told = [note for mark, note in TOLD.items() if mark in seen]
    told += [beside] * bool(frame["published"].notna().any())
    caption = f"Identified parameters{': ' * bool(known)}{', '.join(known)}"
    return Printed(text, caption, [" ".join([about, *told])])


def _of_runs(frame: pd.DataFrame) -> str:
    """What the value of a block stands for."""
    return "Median of the runs" if frame["n_runs"].max() > 1 else "One run of each block"


def _cells(
    part: Part, rows: pd.DataFrame, told: Callable[[Sequence[Any]], str], blocks: Labels | None = None
) -> list[Cell]:
    """The cells of a part of table 2: of each law on each foundation, and block where `blocks` has names."""
    possible = {*rows[~rows["rejected"]]["model"]}
    cells = []
    for (model, block, base), own in rows.groupby(["model", "block", "foundation"], sort=False):
        name = MODEL_LABELS[model]
        if blocks and model in possible:
            name += f", {blocks.get(block, block)}"
        if text := told(list(own.itertuples())):
            cells.append((part, name, str(base), text))
    return cells


def _by_procedure(rows: Sequence[Any]) -> str:
    """A law by the paper's own procedure, marked where it is no likeness or no value of the runs."""
    rows = [row for row in rows if math.isfinite(row.paper)]
    told = []
    for row in rows:
        apart = " ‡" * (row.paper_high > APART * row.paper_low)
        unlike = row.epsilon_theta > FAR or (row.parameter == "r" and row.paper < STOPS)
        text = "no fit †" if unlike else f"{_symbol(row)} = {quantity(row.paper)}{apart}"
        told.append(text + (f" [{quantity(row.published)}]" if math.isfinite(row.published) else ""))
    return ", ".join(dict.fromkeys(told))


def _mean(rows: Sequence[Any]) -> str:
    """A law with inputs and impacts free, unless its runs reject it."""
    if any(row.rejected for row in rows):
        return "rejected"
    known = (row for row in rows if math.isfinite(row.mean))
    return ", ".join(f"{_symbol(row)} = {identified(row.mean, row.u_total)}" for row in known)


def _symbol(row: Any) -> str:
    """The paper's symbol of a parameter of a law."""
    return "k̄" if (row.model, row.parameter) == ("winkler", "k") else SYMBOLS[row.parameter]


def _table3(frame: pd.DataFrame, labels: Labels) -> Printed:
    """ε_θ of the laws by foundations, below each block."""
    proposed = frame["epsilon_theta"].where(frame["model"] == "hunt_crossley")
    proposed = proposed.groupby([frame["block"], frame["foundation"]]).transform("max")
    against = (frame["model"] == "winkler") & (frame["epsilon_theta"] < proposed)
    cells = [
        (("", labels.get(row.block, row.block)), MODEL_LABELS[row.model], row.foundation, _epsilon(row))
        for row in frame.assign(mark=against.map({True: " §", False: ""})).itertuples()
    ]
    text = _by_law("ε_θ / %", cells, labels)
    caption = "ε_θ between recorded and modelled rotation, by the paper's own procedure"
    told = [f"{_of_runs(frame)}.", *[AGAINST] * bool(against.any())]
    told += ["In brackets: published."] * bool(frame["published"].notna().any())
    return Printed(text, caption, [" ".join(told)])


def _by_law(first: str, cells: Sequence[Cell], labels: Labels) -> pd.DataFrame:
    """Laws by foundations, the blocks and kinds of identification below each other."""
    foundations = list(dict.fromkeys(base for *_, base, _ in cells))
    text = {cell[:3]: cell[3] for cell in cells}
    lines: list[list[str]] = []
    for part in dict.fromkeys(part for part, *_ in cells):
        kind, block = part
        head = ", ".join(filter(None, (block, kind))) if block else kind[0].upper() + kind[1:]
        lines.append([head, *[""] * len(foundations)])
        for name in dict.fromkeys(law for each, law, *_ in cells if each == part):
            lines.append([name, *(text.get((part, name, base), "–") for base in foundations)])
    return pd.DataFrame(lines, columns=[first, *(labels.get(base, base) for base in foundations)])


def _epsilon(row: Any) -> str:
    text = percent(row.epsilon_theta, 3) + row.mark if row.n_runs else "failed fit"
    return text + (f" [{fixed(100 * row.published, 2)}]" if math.isfinite(row.published) else "")


def _restitution(frame: pd.DataFrame, labels: Labels, simulated: bool) -> Printed:
    """r of the first impacts of the first run of each record beside the three laws."""
    kind = "Simulated record" if simulated else "Experiment"
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
        "|θ|: peak before the impact. r from the peaks before and after it, as the sensor shows them; "
        f"restitution.csv has r by energy, too. Laws {PROCEDURE}. –: the law has none there."
    )
    caption = "Restitution of each impact from peaks, record and laws"
    return Printed(pd.DataFrame(lines, columns=heads), caption, [about])


def identified(mean: float, u: float) -> str:
    """A mean with its total standard uncertainty; in a word where that exceeds it."""
    return "undetermined" if u > abs(mean) else quantity(mean, u)


def _stated(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"
