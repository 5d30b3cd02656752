"""Ground motions on the identified laws of a campaign: responses in batches, fragility over all of them."""

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from freerock.errors import FreerockError, attempt
from freerock.models.block import Block
from freerock.models.laws import law_of
from freerock.response.draws import KnownParameter, drawn
from freerock.response.ensemble import RESPONSE_COLUMNS as RESPONSES
from freerock.response.ensemble import respond
from freerock.response.fragility import fragility
from freerock.response.motions import INTENSITIES, Accelerogram, read_motion
from freerock.tables.csvfile import read_csv, write_csv

log = logging.getLogger("freerock")
SCENE = ["campaign", "test", "block", "foundation", "model"]
CURVE = [*SCENE, "measure", "kind", "intensity", "probability", "low", "high", "n", "median", "median_low"]
CURVE += ["median_high", "beta", "beta_low", "beta_high", "n_motions", "n_failed"]


def known_laws(
    choice: pd.DataFrame, populations: pd.DataFrame, of: str = "next"
) -> list[tuple[dict[str, str], dict[str, KnownParameter]]]:
    """The law that each record names, and its parameters.

    Parameters
    ----------
    choice, populations : pandas.DataFrame
        Tables of a campaign.
    of : str
        "mean" (u_total of the mean) or "next" (of the next run: with the spread between runs).

    Returns
    -------
    list of (dict, dict)
        Columns `SCENE`, and each parameter. Records none of whose runs names a law are left out, and those of
        a law that is solved on ground at rest only.
    """
    found = []
    selected = choice[(choice["status"] == "selected") & choice["explains"].astype(bool)]
    for test, runs in selected.groupby("test", sort=False):
        model = runs["model"].value_counts().index[0]
        rows = populations[(populations["level"] == "record") & (populations["test"] == test)]
        rows = rows[rows["model"] == model]
        if rows.empty or law_of(model).bounces:
            continue
        known = {}
        for row in rows.to_dict("records"):
            spread = row["tau"] if of == "next" and np.isfinite(row["tau"]) else 0.0
            u = float(np.hypot(np.nan_to_num(row["u_total"]), spread))
            known[str(row["parameter"])] = KnownParameter(float(row["mean"]), u)
        scene = {name: str(rows.iloc[0][name]) for name in SCENE}
        found.append((scene, known))
    return found


def make_responses(
    laws: Iterable[tuple[Mapping[str, str], Mapping[str, KnownParameter]]],
    blocks: Mapping[str, Mapping[str, Any]],
    motions: Sequence[Accelerogram],
    scales: Sequence[float],
    n_draws: int,
    debonding: str = "geometric",
) -> pd.DataFrame:
    """Responses of each record's block and law, `SCENE` beside the columns of `ensemble.respond`.

    The draws are the same in each batch of motions, so that batches can be joined.
    """
    tables = []
    for scene, known in laws:
        block = Block(**blocks[scene["block"]]).as_found({name: each.mean for name, each in known.items()})
        sets = drawn(scene["model"], known, n_draws)
        table = respond(scene["model"], block, sets, motions, scales, debonding)
        for i, name in enumerate(SCENE):
            table.insert(i, name, scene[name])
        tables.append(table)
    if not tables:
        log.warning("no record names a law that explains its runs")
        return pd.DataFrame(columns=[*SCENE, *RESPONSES])
    return pd.concat(tables, ignore_index=True)


def make_batch(
    settings: Mapping[str, Any],
    tables: Mapping[str, str | Path],
    motions: Sequence[str | Path],
    output: str | Path,
) -> None:
    """Write the responses of a campaign's laws to some ground motions.

    Parameters
    ----------
    settings : mapping
        blocks, debonding, and scales, draws, of: as `config.keys_of_ground_motions`.
    tables : mapping
        Paths of choice and populations.
    motions : sequence of path
        Accelerograms.
    output : path
        CSV file: `SCENE` beside the columns of `ensemble.respond`.

    Raises
    ------
    FreerockError
        An accelerogram can't be used.
    """
    choice, populations = (read_csv(tables[name]) for name in ("choice", "populations"))
    laws = known_laws(choice, populations, settings["of"])
    of_motions = settings["scales"], settings["draws"]
    read = [read_motion(path) for path in motions]
    write_csv(make_responses(laws, settings["blocks"], read, *of_motions, settings["debonding"]), output)


def make_fragility(
    batches: Sequence[str | Path], records: Sequence[Mapping[str, str]], output: str | Path
) -> None:
    """Write the fragility of all batches of responses; records as for `fragility_table`."""
    used = [*SCENE, "motion", *INTENSITIES, "overturned"]
    parts = [read_csv(path)[used] for path in batches]
    write_csv(fragility_table(pd.concat(parts, ignore_index=True), records), output)


def fragility_table(responses: pd.DataFrame, records: Iterable[Mapping[str, str]] = ()) -> pd.DataFrame:
    """Fragility of each record against each intensity: columns `CURVE`, rows of kind fitted and counted.

    A block that always or never falls has one row, with its share and no curve. So has, of kind no_law, each
    of the campaign's records (campaign, test, block, foundation) without responses: no law explains
    its runs, or no run is usable.
    """
    tables = []
    for key, own in responses.groupby(SCENE, sort=False):
        scene = dict(zip(SCENE, key, strict=True))
        counts = {"n_motions": own["motion"].nunique(), "n_failed": int(own["overturned"].isna().sum())}
        for measure in INTENSITIES:
            found = attempt(fragility, own, measure)
            if isinstance(found, FreerockError):
                log.warning("%s: %s", scene["test"], found)
                share = {"kind": "none", "probability": own["overturned"].mean(), "n": len(own)}
                tables.append(pd.DataFrame([{**scene, "measure": measure, **share, **counts}]))
                continue
            numbers = found.fitted._asdict()
            for end, limits in (("low", found.low), ("high", found.high)):
                numbers |= {f"{name}_{end}": limit for name, limit in limits._asdict().items()}
            for kind, curve in (("fitted", found.curve), ("counted", found.counted)):
                tables.append(curve.assign(**scene, measure=measure, kind=kind, **numbers, **counts))
    known = {*responses["test"]}
    none = {"kind": "no_law", "n_motions": 0, "n_failed": 0}
    lawless = [{**each, **none} for each in records if each["test"] not in known]
    tables += [pd.DataFrame(lawless)] if lawless else []
    if not tables:
        return pd.DataFrame(columns=CURVE)
    return pd.concat(tables, ignore_index=True).reindex(columns=CURVE)
