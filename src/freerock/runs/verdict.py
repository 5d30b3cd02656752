"""The verdict on a run or a record: how far it may be used, and why, one reason per check.

`reasons.csv` has a row per reason: its verdicts, what was found, the limit and the key that sets it, which
modules make it, and what to do. Code, the table of reasons and docs/verdicts.md read it;
`python -m freerock.runs.verdict` prints the rows of the page. Reasons are joined in `runs` and
`products.contents`.
"""

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

Level = Literal["ok", "warn", "fail"]
VERDICTS: tuple[Level, ...] = ("ok", "warn", "fail")  # from the best to the worst


class KnownReason(NamedTuple):
    """A row of `reasons.csv`.

    Parameters
    ----------
    name : str
    verdicts : tuple of str
        Those that it may have, the usual one first.
    found, limit : str
        What was found and the threshold, in words.
    key : str
        The threshold's key in the configuration, "" of one that no key sets.
    makers : tuple of str
        The modules that make it.
    remedy : str
        What to do.
    """

    name: str
    verdicts: tuple[Level, ...]
    found: str
    limit: str
    key: str
    makers: tuple[str, ...]
    remedy: str


with open(Path(__file__).with_name("reasons.csv"), encoding="utf-8", newline="") as _file:
    # All reasons that there are, by name.
    KNOWN_REASONS = {
        row["name"]: KnownReason(
            row["name"],
            tuple(cast(Level, each) for each in row["verdicts"].split()),
            row["found"],
            row["limit"],
            row["key"],
            tuple(row["maker"].split()),
            row["remedy"],
        )
        for row in csv.DictReader(_file)
    }


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

    @classmethod
    def of(
        cls,
        name: str,
        text: str,
        verdict: Level | None = None,
        value: float | None = None,
        limit: float | None = None,
        unit: str = "",
    ) -> "Reason":
        """A known reason with its usual verdict, or another of its verdicts.

        Raises
        ------
        KeyError
            There is no such reason.
        """
        known = KNOWN_REASONS[name]
        key = known.key if limit is not None else ""
        return cls(verdict or known.verdicts[0], name, text, value, limit, unit, key)

    @classmethod
    def beyond(
        cls, limits: Any, name: str, text: str, value: float | None, verdict: Level | None = None
    ) -> "Reason":
        """A known reason whose value is beyond the one of `limits` that its key sets."""
        key = KNOWN_REASONS[name].key.rpartition(".")[2]
        unit = "degree" if key.endswith("_deg") else "1"
        return cls.of(name, text, verdict, value, float(getattr(limits, key)), unit)


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


def in_one_line(reasons: Iterable[Reason]) -> str:
    """Reasons as text for a reader, separated by "; "; within one of several it becomes ", "."""
    texts = [reason.text for reason in reasons]
    return texts[0] if len(texts) == 1 else "; ".join(text.replace("; ", ", ") for text in texts)


def rows_of_page() -> str:
    """The rows of docs/verdicts.md: a row per reason."""
    return "\n".join(
        f"| {', '.join(each.verdicts)} | `{each.name}` | {each.found} | {_limit(each)} | {each.remedy} |"
        for each in KNOWN_REASONS.values()
    )


def _limit(each: KnownReason) -> str:
    """The limit of a reason in words, with its key."""
    return " ".join([*([f"`{each.key.rpartition('.')[2]}`:"] if each.key else []), each.limit])


if __name__ == "__main__":
    print(rows_of_page())
