"""The study of mishaps: the whole way from a record to a verdict and its name."""

import math

import pandas as pd
import pytest

from freerock_bench.figures.mishaps import OUTCOMES, draw, outcomes
from freerock_bench.mishaps import COLUMNS, MISHAPS, SIZES, main, markdown, one

pytestmark = pytest.mark.slow

AERSTOP_2 = 4  # of six scenes: configuration 2 on Aerstop


def test_a_clean_record_is_ok_and_gives_the_truth():
    row = one("none", AERSTOP_2)
    assert (row["level"], row["names"], row["model"], row["named"]) == ("ok", "", "hunt_crossley", False)
    assert abs(row["k_error_percent"]) < 1 and abs(row["k_error_stderrs"]) < 4


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("base off level, 0.2", "off_level"),
        ("hit during a run, 0.05", "disturbed"),
        ("braked, 0.5", "disturbed_release"),
        ("hold beyond the range", "hold_unseen"),
        ("mains elsewhere", "other_mains"),
    ],
)
def test_a_mishap_is_warned_of_with_its_name(name, says):
    row = one(name, AERSTOP_2)
    assert row["level"] == "warn" and row["named"] and says in row["names"].split()
    assert {*row} <= {*COLUMNS}


@pytest.mark.parametrize(
    ("name", "i", "says"),
    [
        ("hit during a run, 0.02", 41, "disturbed_release"),
        ("braked, 0.2", 4, "disturbed_release"),
        ("sensor averages", 20, "slow_sensor"),
    ],
)
def test_what_passed_for_clean_or_went_without_its_name(name, i, says):
    row = one(name, i)
    assert row["level"] == "warn" and row["named"] and says in row["names"].split()


def test_a_caught_block_is_fitted_from_where_it_is_let_go_again():
    row = one("caught and let go again, 0.1", AERSTOP_2)
    assert (row["level"], row["names"], row["model"]) == ("ok", "let_go_again", "hunt_crossley")
    assert abs(row["k_error_stderrs"]) < 4


def test_the_table_says_what_stands_under_an_ok(monkeypatch, tmp_path):
    some = {"none": MISHAPS["none"], "braked, 0.5": MISHAPS["braked, 0.5"]}
    rows = [
        {
            "mishap": "none",
            "level": "ok",
            "k_error_percent": 0.5,
            "k_error_stderrs": -2.5,
            "k_error_us": -1.5,
            "named": False,
        },
        {
            "mishap": "braked, 0.5",
            "level": "warn",
            "k_error_percent": 20,
            "k_error_stderrs": 90.0,
            "named": True,
        },
        {
            "mishap": "braked, 0.5",
            "level": "ok",
            "k_error_percent": -7,
            "k_error_stderrs": -6.0,
            "named": False,
        },
    ]
    known = [
        row | {"quantity": some[row["mishap"]].quantity, "value": some[row["mishap"]].value} for row in rows
    ]
    lines = markdown(pd.DataFrame(known, columns=COLUMNS)).splitlines()
    assert lines[2:] == [
        "| none |  | 1 | 0% |  | +0.5 … +0.5 | 0 of 1 | 2.5 | 1 of 1 | 1.5 |",
        "| braked | share of the rate 0.5 | 2 | 50% | 50% | -7 … +20 | 0 of 1 | 6.0 |  |  |",
    ]
    monkeypatch.setattr("freerock_bench.mishaps.MISHAPS", {"none": MISHAPS["none"]})
    monkeypatch.setitem(SIZES, "small", 1)
    document = tmp_path / "signals.md"
    document.write_text("a\n<!-- mishaps -->\nold\n<!-- end of the mishaps -->\nb\n", encoding="utf-8")
    main(str(tmp_path / "mishaps.csv"), "small", str(document))
    text = document.read_text(encoding="utf-8")
    assert text.startswith("a\n<!-- mishaps -->\n| mishap |") and "old" not in text
    assert text.endswith("<!-- end of the mishaps -->\nb\n")
    assert not math.isnan(pd.read_csv(tmp_path / "mishaps.csv")["k_error_percent"][0])


def test_the_figure_says_what_became_of_each_mishap():
    """Of what counts as right under an ok the limit is four standard errors."""
    seen = [
        ("warn", "off_level", True, 50.0),
        ("warn", "unexplained", False, 50.0),
        ("ok", "held_back", False, -3.9),
        ("ok", None, False, 3.9),
        ("ok", None, False, 4.1),
        ("ok", "held_back", False, math.nan),
    ]
    columns = ["level", "names", "named", "k_error_stderrs"]
    frame = pd.DataFrame(seen, columns=columns).assign(
        mishap="pushed, 0.03", quantity="rate [rad/s]", value=0.03
    )
    clean = frame.iloc[3:4].assign(mishap="none", quantity="", value=math.nan)
    (figure, rows), found = draw(pd.concat([clean, frame])), outcomes(frame)
    shares = [round(6 * found[name][0]) for name in OUTCOMES]
    assert shares == [1, 1, 1, 1, 2] and found["records"][0] == 6
    assert rows["mishap"].tolist() == ["none", "pushed, 0.03"]
    (ax,) = figure.axes
    assert [label.get_text() for label in ax.get_yticklabels()] == ["none (1)", "pushed, 0.03 rad/s (6)"]
    ends = [bar.get_x() + bar.get_width() for bar in ax.patches]
    assert max(ends) == pytest.approx(100)
