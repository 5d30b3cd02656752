"""Tables of the studies, and the numbers that texts take from them."""

import re

import pandas as pd
import pytest

from freerock.errors import FreerockError
from freerock_bench import evidence, kinds, minimum, scatter, scattered
from freerock_bench.campaigns import COLUMNS
from freerock_bench.document import BEGIN, END

pytestmark = pytest.mark.usefixtures("springs")

KIND = "clean, Winkler, guided"
ROWS = pd.DataFrame(
    [
        {"case": "one", "parameter": "k", "truth": 2.0, "value": 2.02, "u": 0.02, "inside": True},
        {"case": "one", "parameter": "k", "truth": 2.0, "value": 1.92, "u": 0.02, "inside": False},
        {"case": "other", "parameter": "k", "truth": 2.0, "value": 2.6, "u": 0.3, "inside": True},
    ],
    columns=COLUMNS,
)


@pytest.fixture
def written(tmp_path):
    evidence.write("minimum", ROWS, 7, tmp_path)
    return tmp_path


def test_a_table_states_version_seed_and_code(written):
    stated = evidence.heading("minimum", written)
    assert stated.seed == "7" and re.fullmatch(r"\d+\.\d+.*", stated.version)
    assert evidence.table("minimum", written)["value"].tolist() == ROWS["value"].tolist()
    assert not evidence.is_older("minimum", written) and evidence.is_older("means", written)


def test_a_table_is_older_once_the_code_that_it_judges_is_another(written, monkeypatch):
    monkeypatch.setitem(evidence.STUDIES, "minimum", ("freerock.models.block",))
    assert evidence.is_older("minimum", written)


def test_a_cell_changed_by_hand_is_seen(written):
    path = written / "minimum.csv"
    path.write_text(path.read_text().replace("1.92", "1.99"))
    with pytest.raises(FreerockError, match=r"a cell was changed by hand.*evidence minimum") as told:
        evidence.table("minimum", written)
    own = {number["name"] for number in evidence.numbers() if number["study"] == "minimum"}
    places = [where for page in evidence.pages() for name, _, where in evidence.cited(page) if name in own]
    assert places and all(each in str(told.value) for each in places)
    assert re.match(r"\w+\.md:\d+: ", places[0]) and "<!--" not in places[0]


def test_numbers_are_made_of_rows():
    of = {name: statistic(ROWS) for name, statistic in evidence.STATISTICS.items()}
    assert of["inside"] == "2 of 3" and of["percent"] == "67 %" and of["rows"] == "3"
    assert of["error"] == "4 %" and of["least"] == "1.92"
    assert of["times"] == "12"  # 30 % over 2.5 %


def test_every_number_of_the_documentation_is_that_of_its_study():
    texts = {number["name"]: evidence.printed(number) for number in evidence.numbers()}
    for page in evidence.pages():
        for name, text, where in evidence.cited(page):
            assert text == texts[name], f"{where} [{name} is {texts[name]}]"
    assert {name for page in evidence.pages() for name, *_ in evidence.cited(page)} == set(texts)


def test_every_table_of_the_documentation_is_that_of_its_study():
    document = evidence.DOCUMENT.read_text(encoding="utf-8")
    for name, text in evidence.sections():
        shown = document.split(BEGIN.format(name))[1].split(END.format(name))[0]
        assert shown.splitlines()[1:] == text.splitlines()[1:], (
            f"run python -m freerock_bench.evidence {name}"
        )


def test_studies_in_their_small_size(tmp_path, monkeypatch):
    """Of each way of making a table one, from records to rows; blocks on Aerstop rock briefly."""
    monkeypatch.chdir(tmp_path)
    of_table = dict(reversed(scattered.TABLE_2.items()))
    for study in (scattered, kinds):
        monkeypatch.setattr(study, "TABLE_2", of_table)
    monkeypatch.setattr(minimum, "STARTS", 5)
    monkeypatch.setattr(scatter, "SIGMAS", (0.0,))
    monkeypatch.setattr(kinds, "KINDS", {KIND: kinds.KINDS[KIND]})
    names = "minimum", "by_hand", "scatter", "kinds"
    evidence.main(*names, size="small", cores=1)
    found = {name: evidence.table(name, tmp_path / "results/evidence") for name in names}
    assert found["minimum"]["inside"].all()
    left_out = found["scatter"].query("parameter == 'error of held-out peaks' and case == 'σ_r 0 %'")
    error = left_out.groupby("note")["value"].median()  # a guided Hunt–Crossley block
    assert error["hunt_crossley"] < 0.01 < error["winkler"] < error["housner"]
    named = found["scatter"].query("parameter == 'true law in the set'")["inside"]
    assert len(named) == 3 and named.all()
    of_kind = found["kinds"].groupby("parameter")["inside"]
    assert of_kind.mean()["r of an impact"] > 0.8 and of_kind.all()["true law in the set"]
    assert set(found["by_hand"]["parameter"]) == {"k", "lambda", "ε_θ", "processor time"}
