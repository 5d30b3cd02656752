"""The verdict on a run or a record: how far it may be used, and why, one reason per check.

Reasons are made in `reasons_as_measured`, those of a release that was pushed or badly timed among them; of a
hold and a beginning in `beginning`; of r in `uneven_restitution` and `impacts`; of a
signal in `reasons_as_measured.faults_met`; after the fits in `selection.reasons_after_fits`, of base, release
and sensor in `selection.reasons_of_set_up`; of corrections in `by_hand`; of fits and
records that failed in `products.verdict_with_fits` and the jobs. They are joined in `runs_with_impacts` and
`products.verdict_with_fits`. Thresholds with a key are in `config.keys_of_processing`, levels of tests in
`identification.significance_levels`, others beside their check. A user finds value, limit and key of each
reason in `tables/reasons.csv`.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

Level = Literal["ok", "warn", "fail"]
VERDICTS: tuple[Level, ...] = ("ok", "warn", "fail")  # from the best to the worst


class Reason(NamedTuple):
    """What one check found.

    Parameters
    ----------
    verdict : str
        One of `VERDICTS`; "ok" for what is only noted, such as a release set by hand.
    name : str
        Identifier of the check, such as "few_impacts".
    text : str
        What was found, in words.
    value, limit : float or None
        The number judged and the threshold it was compared with, in `unit`; None of what is no number.
    unit : str
        Of both; "1" of a fraction or a count.
    key : str
        The threshold's key in the configuration, "" of one that no key sets.
    """

    verdict: Level
    name: str
    text: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    key: str = ""


@dataclass(frozen=True)
class Verdict:
    """The reasons found by all checks, in their order; none where all is well."""

    reasons: tuple[Reason, ...] = ()

    @property
    def level(self) -> Level:
        """The worst verdict of the reasons, "ok" without any."""
        return max((reason.verdict for reason in self.reasons), key=VERDICTS.index, default="ok")

    @property
    def texts(self) -> tuple[str, ...]:
        """The reasons in words."""
        return tuple(reason.text for reason in self.reasons)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the reasons."""
        return tuple(reason.name for reason in self.reasons)

    def adding(self, reasons: Iterable[Reason]) -> "Verdict":
        """The verdict with more reasons."""
        return Verdict((*self.reasons, *reasons))


def in_one_line(reasons: Iterable[Reason]) -> str:
    """Reasons as text for a reader, separated by "; "; within one of several it becomes ", "."""
    texts = [reason.text for reason in reasons]
    return texts[0] if len(texts) == 1 else "; ".join(text.replace("; ", ", ") for text in texts)
