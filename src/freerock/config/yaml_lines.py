"""Text and YAML files, with the line on which each key stands.

YAML is read as its version 1.2, in which numbers are what they look like: 017 is 17, and 1:30 is a text.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from yaml import MappingNode, MarkedYAMLError, Node, SafeLoader, ScalarNode, SequenceNode, YAMLError

from freerock.config.values import Key
from freerock.errors import FreerockError
from freerock.files import read_bytes

Lines = dict[Key, int]  # line of each key of a YAML file

TAG = "tag:yaml.org,2002:"
LOOKS = {  # of what is no text, without quotes
    "null": "~|null|Null|NULL|",
    "bool": "true|True|TRUE|false|False|FALSE",
    "int": "[-+]?([0-9][0-9_]*|0b[01_]+|0o[0-7_]+|0x[0-9a-fA-F_]+)",
    "float": r"[-+]?([0-9][0-9_]*(\.[0-9_]*|(?=[eE]))|\.[0-9_]+)([eE][-+]?[0-9]+)?"
    r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
    "merge": "<<",
}
CORRECT = "correct the YAML; indent with spaces, not tabs"
CLOSE = "close the brace, bracket or quote that opens here, with commas between"


class Yaml12(SafeLoader):  # type: ignore[misc]
    """Loader of PyYAML, whose own read version 1.1."""

    def resolve(self, kind: type[Node], value: str, implicit: Any) -> Any:
        """Tag of a node."""
        if kind is not ScalarNode or not implicit[0]:
            return super().resolve(kind, value, implicit)
        return TAG + next((name for name, looks in LOOKS.items() if re.fullmatch(looks, value)), "str")

    def whole(self, node: ScalarNode) -> int:
        """A whole number."""
        return int(node.value.replace("_", ""), 0 if re.search("[box]", node.value) else 10)


Yaml12.add_constructor(f"{TAG}int", Yaml12.whole)
Yaml12.add_constructor(f"{TAG}timestamp", SafeLoader.construct_yaml_str)


def read_text(path: Path) -> str:
    """The text of a file in UTF-8; raises FreerockError where it can't be read."""
    return text_of(read_bytes(path), path)


def text_of(content: bytes, path: Path) -> str:
    """The text that the bytes of a file are in UTF-8, with plain ends of lines; raises FreerockError."""
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FreerockError(f"{path}:{line}", "is not UTF-8 text", "save the file as UTF-8") from None


def read_yaml(path: Path) -> tuple[dict[str, Any] | None, Lines, list[FreerockError]]:
    """Keys and values (None when unreadable), the line of each key, and the problems met."""
    lines: Lines = {}
    problems: list[FreerockError] = []
    try:
        reader = Yaml12(read_text(path))
        root = reader.get_single_node()
        for loc, line in _locate_keys(root):
            if loc in lines:
                where, first = f"{path}:{line}: {'.'.join(loc)}", lines[loc]
                problems.append(FreerockError(where, f"is given twice, first on line {first}", "keep one"))
            lines[loc] = line
        data = reader.construct_document(root) if root else None
    except FreerockError as error:
        return None, {}, [error]
    except YAMLError as error:
        opened = re.search("flow|quoted", str(getattr(error, "context", "")))  # and never closed
        mark = getattr(error, "context_mark" if opened else "problem_mark", None)
        what = getattr(error, "problem", None) or str(error).partition("\n")[0]
        where, remedy = f"{path}:{mark.line + 1}" if mark else str(path), CLOSE if opened else CORRECT
        return None, {}, [FreerockError(where, what, remedy)]
    if not isinstance(data, dict):
        what = "is empty" if data is None else "is not a list of keys and values"
        return None, {}, [*problems, FreerockError(path, what, "write lines of the form key: value")]
    return data, lines, problems


def _locate_keys(node: Node | None, loc: Key = ()) -> Iterator[tuple[Key, int]]:
    """Location and line of every key and list item below a YAML node; keys become texts."""
    children: list[tuple[str, Node, Node]] = []
    if isinstance(node, MappingNode):
        for key, value in node.value:
            if not isinstance(key, ScalarNode):
                raise MarkedYAMLError(problem="a key is no word", problem_mark=key.start_mark)
            if key.tag != f"{TAG}merge":
                key.tag = f"{TAG}str"
                children.append((key.value, key, value))
    elif isinstance(node, SequenceNode):
        children = [(str(i), item, item) for i, item in enumerate(node.value)]
    for name, key, value in children:
        yield (*loc, name), key.start_mark.line + 1
        yield from _locate_keys(value, (*loc, name))


def place(path: Path, lines: Lines, loc: Key) -> str:
    """file:line: key, by the line of the nearest key that is in the file."""
    near = next((loc[:n] for n in range(len(loc), 0, -1) if loc[:n] in lines), None)
    return f"{path}:{lines[near]}: {'.'.join(loc)}" if near else f"{path}: {'.'.join(loc)}"
