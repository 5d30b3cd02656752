"""Checks values against a section; each mistake becomes a line: where, what is wrong, what to do."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, get_origin

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from freerock.config import values
from freerock.config.values import NAME_PATTERN, Invalid, Key, Section
from freerock.errors import FreerockError

FILL_IN = "FILL_IN"  # what `freerock new-campaign` writes where only the user knows


class ConfigError(FreerockError):
    """All problems of the configuration; str() has one line for each.

    Parameters
    ----------
    problems : sequence of FreerockError
        At least one; where, what and remedy are those of the first.
    """

    def __init__(self, problems: Sequence[FreerockError]) -> None:
        self.problems = tuple(problems)
        first = self.problems[0]
        super().__init__(first.where, first.what, first.remedy)

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


def refuse(problems: Sequence[FreerockError]) -> None:
    """Raise a `ConfigError` of some problems, where there are any."""
    if problems:
        raise ConfigError(problems)


def leaves(value: Any, loc: Key = ()) -> Iterator[tuple[Key, Any]]:
    """What nested mappings and lists hold at last, each with the keys and list positions on the way to it."""
    if not isinstance(value, Mapping | list):
        yield loc, value
        return
    for name, each in value.items() if isinstance(value, Mapping) else enumerate(value):
        yield from leaves(each, (*loc, str(name)))


def validate(
    model: type[Section],
    data: Mapping[str, Any] | None,
    where: Callable[[Key], str],
    problems: list[FreerockError],
) -> Any:
    """The section, or None and its problems added; `where` words a location."""
    if data is None:
        return None
    blanks = [loc for loc, value in leaves(data) if value == FILL_IN]
    for loc in blanks:
        field, _ = _walk(model, loc)
        give = f"give {field.description}" if field else "write the value there"
        problems.append(FreerockError(where(loc), "is still to be filled in", give))
    try:
        section = model.model_validate(data)
        return None if blanks else section
    except ValidationError as error:
        found = error.errors(include_url=False)
    located = [(tuple(str(part) for part in fault["loc"] if part != "[key]"), fault) for fault in found]
    # a list is too short as well where all its items are wrong
    inner = {loc[:n] for loc, _ in located for n in range(len(loc))}
    faults = [(loc, fault) for loc, fault in located if loc not in blanks]
    faults = [(loc, fault) for loc, fault in faults if fault["type"] != "too_short" or loc not in inner]
    meant = {
        (*loc[:-1], close)
        for loc, fault in faults
        if fault["type"] == "extra_forbidden"
        for close in values.closest(loc[-1], _keys(model, loc[:-1]))
    }
    for loc, fault in faults:
        if fault["type"] != "missing" or loc not in meant:
            problems.append(FreerockError(where(loc), *_explain(model, loc, fault)))
    return None


def _explain(model: type[Section], loc: Key, fault: ErrorDetails) -> tuple[str, str]:
    """What is wrong and what to do, for one of pydantic's errors."""
    kind, value, context = fault["type"], fault["input"], fault.get("ctx", {})
    if isinstance(context.get("error"), Invalid):
        return context["error"].what, context["error"].remedy
    if kind == "extra_forbidden":
        if loc[-1].isdigit():
            return "is no key; it may be what follows a decimal comma", "write numbers with a decimal point"
        keys = _keys(model, loc[:-1])
        return "unknown key", values.did_you_mean(loc[-1], keys) or f"use one of {', '.join(keys)}"
    if context.get("pattern") == NAME_PATTERN and value:
        return values.name_fault(value) or ("", "")
    field, _ = _walk(model, loc)
    give = f"give {field.description}" + (", in quotes" if kind == "string_type" else "")
    if kind == "missing":
        return "is missing", give
    if value in (None, "", {}, [], ()):
        return "is empty", give
    if isinstance(value, dict | list | tuple):
        return f"{'a group of keys' if isinstance(value, dict) else 'a list'} does not belong here", give
    if "pattern" in context:
        return f"{values.shown(value)} is not understood", give
    what = fault["msg"].replace("Input should be", "is not").replace("valid tuple", "list")
    what = re.sub(r"valid dictionary.*", "group of keys", what).partition(", unable")[0]
    if kind == "literal_error":
        give = values.did_you_mean(value, re.findall(r"'(\w+)'", context["expected"])) or give
    return f"{values.shown(value)} {what}", give


def _walk(model: type[Section], loc: Key) -> tuple[Any, type[Section] | None]:
    """The field that holds a location, and the section whose keys stand below it."""
    field: Any = None
    section: type[Section] | None = model
    named = False
    for part in loc:
        if named or section is None:
            named = False
            continue
        if part not in section.model_fields:
            return field, section
        field = section.model_fields[part]
        section, named = values.section_in(field.annotation), get_origin(field.annotation) in (dict, tuple)
    return field, section


def _keys(model: type[Section], loc: Key) -> tuple[str, ...]:
    section = _walk(model, loc)[1]
    return tuple(section.model_fields) if section else ()
