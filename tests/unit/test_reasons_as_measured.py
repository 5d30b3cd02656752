"""Checks of a run: each from facts to reasons, all in one list, all in the documentation."""

import ast
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from freerock.config.processing import ImpactLimits, RotationOptions, RunLimits
from freerock.models.block import Block
from freerock.noise.still_phases import Phase
from freerock.rotation.flags import Fault
from freerock.runs.beginning import Beginning
from freerock.runs.reasons_as_measured import Facts, verdict_on
from freerock.runs.release import HeldAngle, Release
from freerock.runs.signal import signal_of
from freerock.runs.verdict import KNOWN_REASONS, VERDICTS, Reason, Verdict, rows_of_page

ROOT = Path(__file__).parents[2]
TIME = np.arange(0, 10, 0.001)


def signal(flagged=0, grow=1.0):
    """A decaying motion from 3 s on, with some invalid samples, or higher from 5 s on."""
    theta = 0.1 * np.exp(-np.maximum(TIME - 3, 0)) * np.cos(10 * np.maximum(TIME - 3, 0))
    theta *= np.where(TIME > 5, grow, 1)
    flags = np.zeros(TIME.size, np.uint8)
    flags[3030 : 3030 + flagged] = 1
    return signal_of(TIME, theta, 1e-5, flags)


BEGUN = Beginning(1.0, Release(3.0, 1e-4, 0.0, 3.0), HeldAngle(0.1, 1e-6, 0.0), 3.03)
GUESSED = Release(3.0, 0.03, 0.0, 3.0, timed=False)
GOOD = Facts(
    signal=signal(),
    faults=(),
    block=Block(0.28, 0.07, 5.84),
    limits=RunLimits(),
    beginning=BEGUN,
    rest=Phase(8.0, 10.0, 0.0, 1e-6, "rest"),
    level_before=0.0,
    end_s=7.5,
    sigma_theta=1e-5,
    n_impacts=20,
)
ONE_FACT = [
    ({"by_hand": [Reason("ok", "overridden", "why")]}, "ok", "overridden"),
    ({"by_hand": [Reason("ok", "excluded", "why")]}, "ok", "excluded"),
    ({"by_hand": [Reason("fail", "by_hand", "why")]}, "fail", "by_hand"),
    ({"by_hand": [Reason("warn", "renumbered", "why")]}, "warn", "renumbered"),
    ({"beginning": BEGUN._replace(reasons=(Reason("warn", "hold_unseen", "why"),))}, "warn", "hold_unseen"),
    ({"beginning": BEGUN._replace(reasons=(Reason("warn", "braked", "why"),))}, "warn", "braked"),
    ({"beginning": BEGUN._replace(reasons=(Reason("ok", "let_go_again", "why"),))}, "ok", "let_go_again"),
    ({"beginning": BEGUN._replace(release=GUESSED)}, "warn", "release_not_timed"),
    ({"beginning": BEGUN._replace(release=Release(3.0, 1e-4, 0.021, 3.0))}, "warn", "pushed"),
    ({"beginning": BEGUN._replace(release=Release(3.0, 1e-4, -0.021, 3.0))}, "warn", "held_back"),
    ({"beginning": BEGUN._replace(held=HeldAngle(0.25, 1e-6, 0.0))}, "fail", "beyond_critical_angle"),
    ({"beginning": BEGUN._replace(held=HeldAngle(0.1, 1e-6, 0.001))}, "warn", "hold_wanders"),
    ({"n_impacts": 2}, "fail", "few_impacts"),
    ({"rest": None}, "warn", "cut_short"),
    ({"rest": Phase(8.0, 10.0, 0.05, 1e-6)}, "fail", "stopped"),
    ({"rest": Phase(8.0, 10.0, 1.5, 1e-6)}, "fail", "overturned"),
    ({"rest": Phase(8.0, 10.0, -1.5, 1e-6)}, "fail", "overturned"),
    ({"level_before": 0.002}, "warn", "rest_shift"),
    ({"faults": [Fault("drift", 0.0, 10.0, "", 0.002)]}, "warn", "drift"),
    ({"faults": [Fault("aliasing", 0.0, 10.0, "124 Hz")]}, "warn", "aliasing"),
    ({"signal": signal(flagged=10)}, "warn", "invalid_samples"),
    ({"signal": signal(flagged=100)}, "fail", "invalid_samples"),
    ({"signal": signal(grow=1.5)}, "fail", "touched"),
    ({"signal": signal(grow=1.5), "block": Block(0.07, 0.07, 1.5)}, "warn", "touched"),
]


def test_nothing_speaks_against_a_good_run():
    assert verdict_on(GOOD) == Verdict()


def test_a_reason_names_its_number_its_threshold_and_the_key_that_sets_it():
    keys = set()
    for change, _, name in ONE_FACT:
        (reason,) = verdict_on(replace(GOOD, **change)).reasons
        if reason.key:
            keys.add(reason.key)
            key = reason.key.removeprefix("processing.runs.")
            assert reason.limit == getattr(RunLimits(), key) and reason.unit in ("1", "degree")
            beyond = abs(reason.value) > reason.limit
            assert beyond or (reason.verdict == "warn" and name == "invalid_samples") or name == "few_impacts"
    (few,) = verdict_on(replace(GOOD, n_impacts=2)).reasons
    assert few[3:] == (2, 3.0, "1", "processing.runs.min_impacts")
    (held,) = verdict_on(replace(GOOD, beginning=BEGUN._replace(held=HeldAngle(0.25, 1e-6, 0.0)))).reasons
    assert held.value == pytest.approx(math.degrees(0.25)) and held.key == ""
    assert held.limit == pytest.approx(math.degrees(math.atan(0.25)))
    (grown,) = verdict_on(replace(GOOD, signal=signal(grow=1.5))).reasons
    assert grown.value == pytest.approx(0.13, abs=0.1) and grown.limit == 0.05
    of_checks = {"push_fraction", "hold_drift_deg", "rest_shift_deg", "flagged_fraction", "growth_fraction"}
    assert keys == {f"processing.runs.max_{key}" for key in of_checks} | {"processing.runs.min_impacts"}


KEYS = ": check valid_low_v, valid_high_v (of a current valid_low_ma, valid_high_ma) of the laser"
ANGLE = ": release at a larger angle"


@pytest.mark.parametrize(
    ("flag", "share", "told"),
    [
        (2, 0.1, f"; in its record, 10% of the samples are invalid (out of range){KEYS}"),
        (16, 0.1, "; in its record, 10% of the samples are invalid (dropout)"),
        (2, 0.01, ANGLE),
        (64, 0.1, ANGLE),  # by hand
        (0, 0.0, ANGLE),
    ],
)
def test_a_run_without_impacts_names_what_its_record_lost(flag, share, told):
    flags = np.where(share * TIME[-1] > TIME, flag, 0).astype(np.uint8)
    lossy = signal_of(TIME, GOOD.signal.theta, 1e-5, flags)
    (reason,) = verdict_on(replace(GOOD, n_impacts=2, signal=lossy)).reasons
    assert reason.text == f"2 zero crossings, fewer than 3{told}"


def test_every_key_of_a_reason_is_one_of_the_configuration():
    told = (ROOT / "config/README.md").read_text(encoding="utf-8")
    for file in (ROOT / "src/freerock").rglob("*.py"):
        for section, key in re.findall(r'"(processing\.\w+)\.(\w+)"', file.read_text(encoding="utf-8")):
            assert f"| `{key}` |" in told.partition(f"### {section}\n")[2].partition("###")[0], file


def test_the_page_of_verdicts_is_that_of_the_table():
    assert rows_of_page() in (ROOT / "docs/verdicts.md").read_text(encoding="utf-8")


def test_reasons_are_made_where_the_table_says():
    """Every name that a module gives to a reason stands in the table, and every row is made there."""
    known = KNOWN_REASONS
    for each in known.values():
        assert each.verdicts and {*each.verdicts} <= {*VERDICTS}
        if each.key:
            section, key = each.key.removeprefix("processing.").split(".")
            limits = {"runs": RunLimits, "impacts": ImpactLimits, "rotation": RotationOptions}[section]
            assert key in limits.model_fields
        for maker in each.makers:
            text = (ROOT / "src/freerock" / f"{maker.replace('.', '/')}.py").read_text(encoding="utf-8")
            assert f'"{each.name}"' in text or each.name == "held_back", each.name
    for file in (ROOT / "src/freerock").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("Reason"):
                named = [each.value for each in node.args[:3] if isinstance(each, ast.Constant)]
                names = [each for each in named if each not in (*VERDICTS, None)][:1]
                assert {*names} <= {*known}, (file, ast.unparse(node))
    for _, verdict, name in ONE_FACT:
        assert verdict in known[name].verdicts


def test_the_noise_of_a_rest_holds_nothing_of_the_motion_before_it():
    time_s = np.arange(0, 4, 1e-3)
    swing = 3e-5 * np.exp(-time_s / 0.4) * np.sin(60 * time_s)
    theta = swing + 1e-5 * np.random.default_rng(4).standard_normal(time_s.size)
    signal = signal_of(time_s, theta, 1e-5, np.zeros(time_s.size, int))
    assert signal.noise(slice(0, time_s.size)) == pytest.approx(1e-5, rel=0.05)
