"""The desk under generated requests, in small; `python -m freerock_bench.desk` sends 2000."""

import json

import pytest

from freerock_bench import desk


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    desk.write_campaign(tmp_path)
    monkeypatch.chdir(tmp_path)


def test_no_answer_contradicts_the_files(campaign):
    counts, wrong = desk.tried(60, seed=3)
    assert not wrong
    assert counts["200 do/keep"] and counts["400"] and counts["killed"]


@pytest.mark.parametrize("kind", ["kill", "full"])
def test_a_save_struck_at_each_write_is_whole_or_nothing(campaign, kind):
    """Each write is struck once, until a save meets none any more; some saves are kept and some are not."""
    served, kept = desk.Served(), []
    try:
        for at in range(1, 30):
            before = desk.state()
            served.ask("ask/again")
            own = {"overrides": [], "exclude": [], "stretches": [], "reason": "", "note": f"note {at}"}
            body = {"corrections": {"tall": own}, "known": before[2], "why": "heard"}
            served.fault.set(kind, at)
            status, told = served.ask("do/keep", json.dumps(body).encode())
            served.revive()
            after = desk.state()
            assert not desk.what_is_wrong(before, after, status, told, "do/keep")
            kept.append(after != before)
            if kind == "kill":
                assert (status == 0) or after != before
            if status == 200 and len(set(kept)) == 2 and kept[-2:] == [True, True]:
                break
        assert set(kept) == {True, False} and kept.index(True) >= 5
    finally:
        served.close()


def test_a_log_written_before_its_table_is_found(campaign, monkeypatch):
    """The check itself: a desk that writes the log by itself, as it goes, is found."""

    def one_by_one(contents):
        for path, content in reversed(contents.items()):
            with open(path, "wb") as file:
                file.write(content)

    monkeypatch.setattr("freerock.review.csv_edit.replace_together", one_by_one)
    assert desk.tried(60, seed=3)[1]
