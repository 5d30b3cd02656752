"""Sentences of the report and its settings, as texts."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from freerock.models.block import Block
from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import LAWS, MODEL_LABELS
from freerock.tables.number_text import fixed, number_of, quantity
from freerock.tables.summary import largest_shift_m

Pairs = list[tuple[str, str]]


def counts(runs: pd.DataFrame) -> str:
    """How many records and runs there are, with what verdicts, from the tidy table."""
    found = runs["run"].notna()
    verdicts = ", ".join(f"{n} {verdict}" for verdict, n in runs["verdict"].value_counts(sort=False).items())
    n_lost = (~found & (runs["verdict"] == "fail")).sum()
    lost = f" {number_of(n_lost, 'record')} could not be processed." if n_lost else ""
    records = number_of(runs["test"].nunique(), "record")
    return f"{records} with {number_of(found.sum(), 'free-rocking run')}; verdicts: {verdicts}.{lost}"


def facts(
    runs: pd.DataFrame,
    sections: Sequence[Mapping[str, Any]],
    compared: pd.DataFrame,
    blocks: Mapping[str, Block],
) -> dict[str, Any]:
    """Numbers of the report's sentences, as text.

    Parameters
    ----------
    runs : pandas.DataFrame
        Tidy table.
    sections : sequence of mapping
        Of the records, as `freerock.report.records.sections_of` gives them.
    compared : pandas.DataFrame
        The table restitution_comparison.
    blocks : mapping of str to freerock.models.block.Block
        The blocks by name.
    """
    timed = compared.dropna(subset=["first_impact_s", "rigid_s"])
    fitted = compared.dropna(subset=["r_fitted", "r_first", "r_fitted_u", "r_first_u"])
    apart = np.hypot(fitted["r_fitted_u"].astype(float), fitted["r_first_u"].astype(float))
    above = fitted["r_fitted"] - fitted["r_first"] > 2 * apart
    later = 100 * (timed["first_impact_s"] / timed["rigid_s"] - 1)
    fits = [fit for section in sections for run in section["runs"] for fit in run["fits"]]
    integrated = pd.DataFrame(
        [fit for fit in fits if math.isfinite(fit["rtol"])], columns=["rtol", "integrator_error"]
    )
    rates = sorted({section["rate_hz"] for section in sections if math.isfinite(section["rate_hz"])})
    return {
        "rates_hz": " to ".join(dict.fromkeys(f"{rate:.6g}" for rate in (*rates[:1], *rates[-1:]))),
        "shift_mm": quantity(1000 * largest_shift_m(runs, blocks), digits=2),
        "latest": _later(later.max()),
        "earliest": _later(later.min()),
        "some_earlier": bool((later < 0).any()),
        "n_timed": len(timed),
        "n_above": int(above.sum()),
        "n_fitted": len(fitted),
        "laws": [law.label for law in LAWS.values() if law.label in {fit["model"] for fit in fits}],
        "n_integrated": len(integrated),
        "rtol_low": f"{integrated['rtol'].min():g}",
        "rtol_high": f"{integrated['rtol'].max():g}",
        "error_percent": quantity(100 * integrated["integrator_error"].max(), digits=2),
    }


def free_besides(fits: Mapping[str, Any], laws: Collection[str]) -> Pairs:
    """What each model of these laws was free in besides its parameters, models alike taken together."""
    alike: dict[str, list[str]] = {}
    for model in filter(laws.__contains__, fits["models"]):
        free = " and ".join(SYMBOLS.get(name, name.replace("_", " ")) for name in fits["free"].get(model, ()))
        alike.setdefault(free or "nothing", []).append(MODEL_LABELS[model])
    return [(", ".join(models), free) for free, models in alike.items()]


def settings(config: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str, Pairs]]]]:
    """Each section of the configuration with (anchor, name, pairs of key and text) of the things in it."""
    sections = {key: value for key, value in config.items() if isinstance(value, Mapping)}
    told = {*sections, "records", "title", "summary"}
    found = []
    for key, section in {"campaign": {k: config[k] for k in config if k not in told}, **sections}.items():
        of_things = section and all(isinstance(each, Mapping) for each in section.values())
        things = section if of_things else {"": section}
        parts = [(f"config-{key}-{name}", name, list(_flat(each))) for name, each in things.items()]
        found.append((key, parts))
    return found


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Nested mappings and lists as pairs of dotted key and text; what is empty is left out."""
    if isinstance(value, list | tuple):
        nested = any(isinstance(inner, Mapping) for inner in value)
        value = dict(enumerate(value, 1)) if nested else ", ".join(map(str, value))
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _flat(inner, f"{key}.{name}" if key else name)
    elif value not in (None, ""):
        yield key, str(value)


def _later(percent: float) -> str:
    return f"{fixed(abs(percent), 1)} % {'later' if percent > 0 else 'earlier'}"
