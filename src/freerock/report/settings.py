"""The settings of a campaign as the report lists them."""

from collections.abc import Iterator, Mapping
from typing import Any

Pairs = list[tuple[str, str]]


def settings(config: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, Pairs]]]]:
    """Each section of the configuration with the name, and pairs of key and text, of the things in it."""
    sections = {key: value for key, value in config.items() if isinstance(value, Mapping)}
    told = {*sections, "records", "title", "summary"}
    found = []
    for key, section in {"campaign": {k: config[k] for k in config if k not in told}, **sections}.items():
        of_things = section and all(isinstance(each, Mapping) for each in section.values())
        things = section if of_things else {"": section}
        found.append((key, [(name, list(_flat(each))) for name, each in things.items()]))
    return found


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Nested mappings and lists as pairs of dotted key and text; what is empty is left out."""
    if isinstance(value, list | tuple):
        nested = any(isinstance(inner, Mapping) for inner in value)
        value = dict(enumerate(value, 1)) if nested else ", ".join(map(str, value))
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _flat(inner, f"{key}.{name}" if key else name)
    elif value not in (None, ""):
        yield key, str(value)
