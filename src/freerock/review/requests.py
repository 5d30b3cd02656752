"""What the page may send, as models: checked as the configuration is, before the desk sees any of it."""

from typing import Annotated, Any

from pydantic import BeforeValidator
from pydantic_core import from_json

from freerock.config.mistakes import validate
from freerock.config.values import Section, Text, key
from freerock.errors import FreerockError
from freerock.review.corrections import Correction, Run, Seconds, Sent

Test = Annotated[str, key("the name of a record", max_length=200)]


class Refit(Sent):
    """Try a correction."""

    test: Test
    correction: Correction = key("what is set by hand")
    run: Run | None = key("the number of the run that is shown, or null")
    near_s: Seconds | None = key("its release in seconds, or null")
    whole: bool = key("true to fit all runs, else false")


class Keep(Sent):
    """Keep corrections."""

    corrections: dict[Test, Correction] = key("corrections, each by the name of its record")
    known: str = key("the digest of the CSV as it was listed", pattern="^[0-9a-f]{64}$")
    why: Text = key("why, as a text")


class Look(Sent):
    """Note that a run was looked at, or was not."""

    test: Test
    run: Run | None = key("the number of the run, or null")
    seen: bool = key("true or false")


class OfTest(Section):
    """A record; in an address, so that its values are texts."""

    test: Test


class OfRecord(OfTest):
    """A record and one of its runs."""

    run: Annotated[Run | None, BeforeValidator(lambda text: text or None)] = key(
        "the number of the run", None
    )


class Window(OfTest):
    """Signals of a record between two instants."""

    from_s: Seconds = key("the first instant in seconds")
    to_s: Seconds = key("the last instant in seconds")


DONE: dict[str, type[Section]] = {"refit": Refit, "keep": Keep, "undo": Sent, "look": Look}
REQUESTS: dict[str, type[Section]] = {
    "list": Section,
    "again": Section,
    "styles": Section,
    "record": OfRecord,
    "means": OfTest,
    "window": Window,
}


def read_request(model: type[Section], body: bytes) -> dict[str, Any]:
    """What a request in JSON holds; raises as `checked`, and where it is no JSON."""
    try:
        given = from_json(body)
    except ValueError as error:
        raise FreerockError("request", f"is not JSON ({error})", "load the page again") from error
    if not isinstance(given, dict):
        raise FreerockError("request", "is no JSON object", "load the page again")
    return checked(model, given)


def checked(model: type[Section], given: dict[str, Any]) -> dict[str, Any]:
    """The values of a request by the names of its model.

    Raises
    ------
    FreerockError
        A key is unknown or missing, a value has another type or size: the first of them, with its field.
    """
    problems: list[FreerockError] = []

    def where(loc: tuple[str, ...]) -> str:
        return ".".join(("request", *(part for part in loc if "[" not in part)))

    made = validate(model, given, where, problems)
    if made is None:
        raise problems[0]
    return dict(made)
