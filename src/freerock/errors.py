"""The one error class a user meets, and words of messages."""

import sys
import unicodedata
from collections.abc import Callable
from typing import Any, TypeVar

Made = TypeVar("Made")
LONGEST = 2000  # characters of a message


def printable(text: str) -> str:
    """A text without what steers a terminal: control characters and the like as a backslash and their number.

    Examples
    --------
    >>> print(printable("laser" + chr(27) + "[31m"))
    laser\\x1b[31m
    """
    return "".join(
        char.encode("unicode_escape").decode()
        if unicodedata.category(char) in ("Cc", "Cf", "Cs") and char != "\n"
        else char
        for char in text
    )


def number_of(n: int, thing: str) -> str:
    """A number of things in words: "1 run", "3 runs"."""
    return f"{n} {thing}{'' if n == 1 else 's'}"


class FreerockError(Exception):
    """Bad input in one line: where, what, remedy.

    Parameters
    ----------
    where : str or path
        File, key, run or argument in which the fault lies.
    what : str
        The fault, with the offending value.
    remedy : str
        What the user does about it.

    Examples
    --------
    >>> print(FreerockError("blocks.tall.mass_kg", "-5.8 is not greater than 0", "give the mass"))
    blocks.tall.mass_kg: -5.8 is not greater than 0; give the mass
    """

    def __init__(self, where: object, what: str, remedy: str) -> None:
        super().__init__(where, what, remedy)
        self.where, self.what, self.remedy = where, what, remedy

    def __str__(self) -> str:
        line = printable(" ".join(f"{self.where}: {self.what}; {self.remedy}".split()))
        return line if len(line) <= LONGEST else f"{line[:LONGEST]} …"


def of_kind(where: str, value: object, kind: type, remedy: str) -> None:
    """Refuse a value of another class.

    Raises
    ------
    FreerockError
        Which class it has, and the remedy.
    """
    if not isinstance(value, kind):
        raise FreerockError(where, f"{type(value).__name__} is no {kind.__name__}", remedy)


def attempt(task: Callable[..., Made], *arguments: Any) -> Made | FreerockError:
    """What a task makes of its arguments, or the `FreerockError` that refuses them."""
    try:
        return task(*arguments)
    except FreerockError as error:
        return error


def exit_code(task: Callable[[], object]) -> int:
    """Run a task of the command line: 0, or 1 where a `FreerockError` refuses it, whose line is printed."""
    try:
        task()
    except FreerockError as error:
        print(error, file=sys.stderr)
        return 1
    return 0
