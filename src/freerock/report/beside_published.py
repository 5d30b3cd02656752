"""What agrees with a publication and what does not: sentences from the tables."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd

from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS
from freerock.report.numbers import USABLE, Number, Sentence, Tables, Where, listed, said
from freerock.tables.number_text import fixed
from freerock.tables.printed_tables import Labels

TENTH = 0.1  # relative difference up to which values are said to agree, as published ones state no error
TWO_U = 2.0  # standard uncertainties apart, up to which others are too uncertain to differ
KEYS = ("test", "model", "parameter")
REJECTED = " Parameters of a rejected law depend on how much of a run is fitted."

SIMULATED = "The records are simulated: agreement with the law that made them tests the method alone."
FINAL_TIME = "it depends on the final time"
NOISE_ALONE = "a simulated record leaves noise alone, a laboratory's does not"


class Beside(NamedTuple):
    """Sentences on what agrees with a publication, and on what does not."""

    agrees: Sequence[Sentence]
    differs: Sequence[Sentence]


def beside_published(
    tables: Mapping[str, pd.DataFrame], longest: Mapping[str, str], labels: Labels
) -> Beside:
    """The campaign beside the values of a publication.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame
        runs, foundations, restitution_comparison, table2 and table3.
    longest : mapping of str to str
        Foundation on which each block rocks longest, as published.
    labels : mapping of str to str
        Printed names of blocks and foundations.
    """
    known = Tables(tables)
    told = [*_parameters(known, labels), *_discrepancies(known, labels), *_durations(known, longest, labels)]
    return Beside([text for alike, text in told if alike], [text for alike, text in told if not alike])


Told = tuple[bool, Sentence]  # whether it agrees, and what is said


def _parameters(known: Tables, labels: Labels) -> Iterator[Told]:
    """Identified and published parameters; of r, what an impact takes away."""
    frame = known["table2"]
    rows = frame[frame["published"].notna() & frame["success"].astype(bool)]
    offset = (rows["parameter"] == "r").astype(float)
    off = (rows["mean"] - rows["published"]).abs()
    near = off <= TENTH * (rows["published"] - offset).abs()
    vague = ~near & (off <= TWO_U * rows["u_total"])
    if near.any() and _simulated(known):
        yield True, (SIMULATED,)
    kinds = (
        ("Within a tenth of", near),
        ("More than a tenth off", ~near & ~vague),
        ("More than a tenth off but within two standard uncertainties of", vague),
    )
    shown = [(size, rows[which]) for size, which in kinds if which.any()]
    first = next((size for size, some in shown if some["rejected"].any()), "")  # to say so once
    for size, some in shown:
        of_r = "; r by its difference from one" * bool(offset[some.index].any())
        values = listed([_beside(known, row, _where(row, rows, labels)) for row in some.itertuples()])
        why = REJECTED * (size == first)
        told = said("{} the published value (in brackets{}): {}.{}", size, of_r, values, why)
        yield near[some.index].all(), told


def _where(row: Any, rows: pd.DataFrame, labels: Labels) -> str:
    """On which foundation, and for which block or record where several of them have published values."""
    there = rows[rows["foundation"] == row.foundation].drop_duplicates("test")
    name = labels.get(row.block, row.block) if there["block"].is_unique else row.test
    return f"for {name} " * (len(there) > 1) + f"on {labels.get(row.foundation, row.foundation)}"


def _beside(known: Tables, row: Any, scene: str) -> Sentence:
    """A parameter, and the published one in brackets."""
    where = {key: getattr(row, key) for key in KEYS}
    of = f"{MODEL_LABELS[row.model]}{' (rejected)' * row.rejected} {SYMBOLS[row.parameter]}"
    here, there = known.value("table2", "mean", where, "u_total"), known.value("table2", "published", where)
    return said("{} {} {} [{}]", of, scene, here, there)


def _discrepancies(known: Tables, labels: Labels) -> Iterator[Told]:
    """Whether ε_θ ranks the laws as published, and which ε_θ is more than a tenth off."""
    frame = known["table3"]
    rows = frame[frame["published"].notna() & frame["success"].astype(bool)]
    ranked: dict[tuple[bool, str], list[Sentence]] = {}
    for _, own in rows.groupby("test", sort=False):
        here, there = (list(own.sort_values(column)["model"]) for column in ("epsilon_theta", "published"))
        scene = _where(next(own.itertuples()), rows, labels)
        if len(own) > 1:
            order = " < ".join(MODEL_LABELS[model] for model in here)
            ranked.setdefault((here == there, order), []).append((scene,))
        off = own[(own["epsilon_theta"] / own["published"] - 1).abs() > TENTH]
        noise = off["selected"].astype(bool) & _simulated(known)
        for why, some in ((NOISE_ALONE, off[noise]), (FINAL_TIME, off[~noise])):
            if len(some):
                values = listed([_epsilon(known, row) for row in some.itertuples()])
                yield False, said("ε_θ {} [published]: {}; {}.", scene, values, why)
    for (alike, order), scenes in ranked.items():
        as_published = "as published" if alike else "otherwise than published"
        yield alike, said("ε_θ ranks the laws {} {}: {}.", as_published, listed(scenes), order)


def _epsilon(known: Tables, row: Any) -> Sentence:
    """The discrepancy of a law, and the published one in brackets."""
    where: Where = {"test": row.test, "model": row.model}
    published = Number(fixed(100 * row.published, 2), "table3", ("published",), where, factor=100)
    here = known.ends("table3", "epsilon_theta", where, 100)
    return said("{} {} % [{} %]", MODEL_LABELS[row.model], here, published)


def _simulated(known: Tables) -> bool:
    return "simulated" in set(known["runs"]["origin"])


def _durations(known: Tables, longest: Mapping[str, str], labels: Labels) -> Iterator[Told]:
    """On which foundation each block rocks longest, here and as published."""
    means = known.rows("runs", USABLE).groupby(["block", "foundation"])["duration_s"].mean()
    alike: dict[str, list[Sentence]] = {}
    for block, published in longest.items():
        if block not in means or published not in means[block] or len(means[block]) < 2:
            continue
        here, name = str(means[block].idxmax()), labels.get(block, block)
        if here == published:
            alike.setdefault(here, []).append((name,))
        else:
            yield False, _reversed(known, block, (here, published), labels)
    for foundation, blocks in alike.items():
        verb = "rocks" if len(blocks) == 1 else "rock"
        on = labels.get(foundation, foundation)
        yield True, said("{} {} longest on {}, as published.", listed(blocks), verb, on)


def _reversed(known: Tables, block: str, foundations: tuple[str, str], labels: Labels) -> Sentence:
    """A block that rocks longest elsewhere than published, and why here."""
    here, there = (labels.get(each, each) for each in foundations)
    scenes = [{"block": block, "foundation": each} for each in foundations]
    lasts = [known.ends("runs", "duration_s", {**USABLE, **each}) for each in scenes]
    keeps = [known.ends("restitution_comparison", "r_first", each) for each in scenes]
    told = said(
        "{} rocks longest on {} ({} s; {} s on {}), in the publication on {}. Here its first "
        "impact keeps r = {} of the angular rate on {}, {} on {}.",
        *(labels.get(block, block), here, *lasts, there, there),
        *(keeps[0], here, keeps[1], there),
    )
    if _simulated(known) and known["foundations"]["transfers"].any():
        told += (
            " The simulated blocks share k and damping. The published order is the reverse: possible causes "
            "are blocks that differ, or an effect outside these laws, such as sliding or bouncing.",
        )
    return told
