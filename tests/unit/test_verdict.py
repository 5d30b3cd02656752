"""Verdicts: reasons as data, the worst of them, and one line for a reader."""

import pytest

from freerock.runs.verdict import KNOWN_REASONS, Reason, Verdict, in_one_line

NOTED = Reason("ok", "overridden", "overridden: late; and short")
DOUBT = Reason("warn", "pushed", "pushed")
LOST = Reason("fail", "few_impacts", "1 impact")


@pytest.mark.parametrize(
    ("reasons", "level"),
    [((), "ok"), ((NOTED,), "ok"), ((NOTED, DOUBT), "warn"), ((LOST, DOUBT, NOTED), "fail")],
)
def test_the_worst_reason_is_the_verdict(reasons, level):
    assert Verdict(reasons).level == level


def test_reasons_in_words():
    verdict = Verdict((NOTED, DOUBT))
    assert verdict.texts == ("overridden: late; and short", "pushed")
    assert in_one_line(verdict.reasons) == "overridden: late, and short; pushed"
    assert in_one_line([NOTED]) == "overridden: late; and short"
    assert in_one_line([]) == ""


def test_the_remedy_of_what_was_not_processed_names_the_logs():
    known = KNOWN_REASONS
    assert "`logs/fit_TEST.log`" in known["not_fitted"].remedy
    assert "`logs/record_TEST.log`" in known["not_processed"].remedy
