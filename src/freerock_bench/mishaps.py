"""Mishaps of a laboratory: how surely a run warns of each with its right name, and what stands under an ok.

Records of the virtual laboratory with the noise of a laser, one release and one mishap each
(`freerock_bench.moves`), go the whole way to verdict and fits, with the laws and rivals of a campaign
by default. The truth is Hunt-Crossley's law of table 2, within 3 %.

    python -m freerock_bench.mishaps results/studies/mishaps.csv full docs/validation.md

measures on all cores (`small`: one record of each in a minute or two; `full`: hours of processor time) and
renews the table in the documentation, where it is named.
"""

import math
import sys
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from freerock.config.uncertainty import response_u_ms
from freerock.errors import FreerockError
from freerock.identification.levels import NORMAL_95
from freerock.models.block import Block
from freerock.models.laws import GEOMETRIC, Rules
from freerock.populations.sensitivity import contributions
from freerock.rotation.laboratory import Input, Laboratory
from freerock.rotation.sensor import Laser
from freerock.selection.hypotheses import BY_DEFAULT
from freerock.virtual_lab import faults
from freerock.virtual_lab.noise import Noise
from freerock.virtual_lab.palermo import CONFIGURATIONS, FOUNDATIONS
from freerock.virtual_lab.record import Recording, Release, VirtualRecord, simulate_record
from freerock_bench import moves
from freerock_bench.analysed import analysed
from freerock_bench.document import publish
from freerock_bench.truths import place, table_2
from freerock_bench.virtual_run import Row, rows_of_all

SIZES = {"small": 1, "full": 200}  # records of each mishap; six make a round of blocks and foundations
NOISE = Noise(mains_v=0.0, drift_v=0.0)
RATE_HZ = 2000.0
MAINS_V = 0.005
SCATTER = 0.03
ALTERNATES = ("alternating_restitution", "uneven_restitution", "touched")
INTERRUPTED = ("outlying_restitution", "uneven_restitution", "touched", "disturbed", "disturbed_release")
AT_RELEASE = ("braked", "disturbed_release", "pushed", "held_back", "release_not_timed", "hold_wanders")
MARK = ("<!-- mishaps -->\n", "<!-- end of the mishaps -->\n")


@dataclass(frozen=True)
class Mishap:
    """What goes wrong, and by what name it goes.

    Parameters
    ----------
    quantity : str
        What is set, with its unit.
    value : float
    spoil : callable
        (value, half period [s], generator) → what differs: fields of `Release`; `faults`; `law`, `rules` of
        the law; `edge_radius_m` of the block; `sign` and `response_ms`, of the laser as it is described.
    names : collection of str
        Reasons that name it rightly.
    """

    quantity: str
    value: float
    spoil: Callable[[float, float, Any], dict[str, Any]]
    names: Collection[str] = ()


def _either(generator: Any) -> float:
    return float(generator.choice([-1, 1]))


MISHAPS = {
    "none": Mishap("", math.nan, lambda value, swing_s, draw: {}),
    **{
        f"base off level, {tilt:g}": Mishap(
            "tilt [deg]",
            tilt,
            lambda value, swing_s, draw: {"moves": moves.off_level(math.radians(value) * _either(draw))},
            (*ALTERNATES, "off_level"),
        )
        for tilt in (0.05, 0.2)
    },
    "sign of the laser": Mishap(
        "sign", -1, lambda value, swing_s, draw: {"sign": value}, (*ALTERNATES, "other_sign")
    ),
    **{
        f"hit during a run, {rate:g}": Mishap(
            "rate [rad/s]",
            rate,
            lambda value, swing_s, draw: {
                "moves": moves.hit(swing_s * draw.uniform(1.0, 3.0), value * _either(draw))
            },
            INTERRUPTED,
        )
        for rate in (0.02, 0.05)
    },
    **{
        f"caught and let go again, {pause:g}": Mishap(
            "pause [s]",
            pause,
            lambda value, swing_s, draw: {"moves": moves.caught(swing_s * draw.uniform(0.2, 0.4), value)},
            (*INTERRUPTED, *AT_RELEASE),
        )
        for pause in (0.1, 0.5)
    },
    **{
        f"braked, {share:g}": Mishap(
            "share of the rate",
            share,
            lambda value, swing_s, draw: {"moves": moves.braked(swing_s * draw.uniform(0.2, 0.4), value)},
            (*INTERRUPTED, *AT_RELEASE),
        )
        for share in (0.2, 0.5)
    },
    "finger leaves slowly": Mishap(
        "time [s]", 0.08, lambda value, swing_s, draw: {"fade_s": value}, AT_RELEASE
    ),
    **{
        f"pushed, {rate:g}": Mishap(
            "rate [rad/s]",
            rate,
            lambda value, swing_s, draw: {"moves": moves.pushed(value * _either(draw))},
            AT_RELEASE,
        )
        for rate in (0.03, 0.06)
    },
    **{
        f"rounded edges, {radius * 1e3:g}": Mishap(
            "radius [m]",
            radius,
            lambda value, swing_s, draw: {"moves": moves.rounded(value), "edge_radius_m": value},
            ("rounded_edges", "unexplained"),
        )
        for radius in (7e-4, 2e-3)
    },
    "sensor averages": Mishap(
        "time [s]",
        4e-3,
        lambda value, swing_s, draw: {"faults": [faults.averaged(value)]},
        ("slow_sensor", "unexplained"),
    ),
    "sensor averages and says so": Mishap(
        "time [s]",
        4e-3,
        lambda value, swing_s, draw: {"faults": [faults.averaged(value)], "response_ms": 1e3 * value},
    ),
    "hold beyond the range": Mishap(
        "share of the held reading",
        0.8,
        lambda value, swing_s, draw: {"faults": [faults.saturated(value)]},
        ("hold_unseen",),
    ),
    "mains elsewhere": Mishap(
        "frequency [Hz]",
        60.0,
        lambda value, swing_s, draw: {"faults": [faults.tone(value + draw.uniform(-0.05, 0.05), MAINS_V)]},
        ("other_mains",),
    ),
    "other debonding rule": Mishap(
        "",
        math.nan,
        lambda value, swing_s, draw: {"rules": Rules("tensionless"), "law": "winkler"},
        ("other_debonding",),
    ),
}
COLUMNS = ["mishap", "quantity", "value", "block", "foundation", "level", "names", "named", "model"]
COLUMNS += ["explained", "k_error_percent", "k_error_stderrs", "k_error_us"]


def run(size: str = "full") -> pd.DataFrame:
    """Every mishap on blocks and foundations in turn.

    Returns
    -------
    pandas.DataFrame
        A row per record: mishap, quantity and value of what is set; block, foundation; level and names (of
        the reasons, joined by blanks) of the run's verdict; named (a right name is among them); model chosen,
        explained; k_error_percent and k_error_stderrs of k under it, NaN where it has none; k_error_us, in
        total uncertainties: all is known exactly here, but that the sensor's response has the default
        uncertainty, and what the law leaves.
    """
    cases = [(name, i) for i in range(SIZES[size]) for name in MISHAPS]
    return pd.DataFrame(rows_of_all(_rows, cases), columns=COLUMNS)


def _rows(case: tuple[str, int]) -> list[Row]:
    return [one(*case)]


def one(name: str, i: int) -> Row:
    """The i-th record with a mishap."""
    mishap, (configuration, foundation) = MISHAPS[name], place(i)
    block, angle, laser = CONFIGURATIONS[configuration]
    draw = np.random.RandomState([list(MISHAPS).index(name), i])
    parameters = {
        key: value * (1 + draw.uniform(-SCATTER, SCATTER)) for key, value in FOUNDATIONS[foundation].items()
    }
    angle *= _either(draw) * draw.uniform(0.6, 1.0)
    how = mishap.spoil(mishap.value, math.pi / 2 / block.p, draw)
    if "law" in how:
        parameters = table_2(how["law"], foundation)
    record = spoiled(block, laser, parameters, angle, how, i)
    read = replace(laser, **{key: how[key] for key in ("sign", "response_ms") if key in how})
    row: Row = {"mishap": name, "quantity": mishap.quantity, "value": mishap.value}
    row |= {"block": configuration, "foundation": foundation} | _judged(record, read, block, parameters["k"])
    named = row["names"].split()
    return row | {"named": row["level"] != "ok" and any(each in mishap.names for each in named)}


def spoiled(
    block: Block, laser: Laser, parameters: dict[str, float], angle: float, how: dict[str, Any], seed: int
) -> VirtualRecord:
    """A record of one release as it should not be."""
    release = Release(
        angle,
        parameters,
        tilt_s=1.0,
        held_s=1.5,
        **{key: how[key] for key in ("moves", "fade_s") if key in how},
    )
    recording = Recording(rate_hz=RATE_HZ, longest_s=16.0, noise=NOISE)
    return simulate_record(
        replace(block, edge_radius_m=how.get("edge_radius_m")),  # as deep in the hold as it stands there
        laser,
        how.get("law", "hunt_crossley"),
        [release],
        seed=seed,
        recording=recording,
        faults=how.get("faults", ()),
        rules=how.get("rules", GEOMETRIC),
    )


def _judged(record: VirtualRecord, laser: Laser, block: Block, k: float) -> Row:
    """Verdict and parameters of the first run of a record."""
    try:
        verdict, found, motion = analysed(record.time_s, record.volts, laser, block)
    except FreerockError as error:
        return {"level": "fail", "names": "not_processed", "model": str(error.what), "explained": False}
    row = {"level": verdict.level, "names": " ".join(verdict.names), "model": "", "explained": False}
    choice = found.choice(BY_DEFAULT)
    if found.fits and choice.selected:
        fit = found.fits[choice.selected]
        row |= {"model": choice.selected, "explained": choice.explained}
        if "k" in fit.parameters:
            at = fit.parameters.index("k")
            off = float(fit.value[at]) - k
            row |= {"k_error_percent": 100 * off / k, "k_error_stderrs": off / float(fit.stderr[at])}
            if motion is not None and fit.success:
                settings = BY_DEFAULT.settings(choice.selected, found.widened)
                response = Input("laser", "response_ms", response_u_ms(laser.response_ms), False)
                known = contributions(fit, motion, Laboratory(block, {"laser": laser}, (response,)), settings)
                row["k_error_us"] = off / float(known.total(fit.stderr, fit.discrepancy)[at])
    return row


def markdown(frame: pd.DataFrame) -> str:
    """A row per mishap: shares warned of and named, the greatest errors of k, and under an ok what holds:
    by the standard error, and by u with the response's default uncertainty."""
    lines = [
        "| mishap | set | records | not ok | its right name | error of k [%] "
        "| under ok: k within 1.96 stderr | at most [stderr] | within 1.96 u | at most [u] |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, rows in frame.groupby("mishap", sort=False):
        first, ok = rows.iloc[0], rows[rows["level"] == "ok"]
        what = f"{first['quantity']} {first['value']:g}" if first["quantity"] else ""
        low, high = rows["k_error_percent"].min(), rows["k_error_percent"].max()
        cells = [
            str(name).partition(",")[0],
            what,
            str(len(rows)),
            f"{(rows['level'] != 'ok').mean():.0%}",
            f"{rows['named'].mean():.0%}" if MISHAPS[str(name)].names else "",
            f"{low:+.2g} … {high:+.2g}",
            *(cell for name in ("k_error_stderrs", "k_error_us") for cell in _held(ok[name].abs().dropna())),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _held(off: "pd.Series[float]") -> tuple[str, str]:
    """How many errors lie in their 95 % interval, and the largest."""
    return (f"{(off < NORMAL_95).sum()} of {len(off)}", f"{off.max():.1f}") if len(off) else ("", "")


def main(product: str, size: str, document: str = "") -> None:
    """Measure, write the product, and renew the table of a document."""
    publish(run(size), product, document, MARK, markdown)


if __name__ == "__main__":
    main(*sys.argv[1:])
