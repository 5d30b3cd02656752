"""Text and YAML files, with the line on which each key stands."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from freerock.errors import FreerockError

Key = tuple[str, ...]  # where a value stands: the keys and list positions on the way to it
Lines = dict[Key, int]  # line of each key of a YAML file


def read_text(path: Path) -> str:
    """The text of a file in UTF-8; raises FreerockError where it can't be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FreerockError(path, f"cannot be read ({error.strerror})", "write the file") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FreerockError(f"{path}:{line}", "is not UTF-8 text", "save the file as UTF-8") from None


def read_yaml(path: Path) -> tuple[dict[str, Any] | None, Lines, list[FreerockError]]:
    """Keys and values (None when unreadable), the line of each key, and the problems met."""
    try:
        text = read_text(path)
        loader = yaml.SafeLoader(text)
        root = loader.get_single_node()
        lines: Lines = {}
        problems: list[FreerockError] = []
        for loc, line in _locate_keys(root):
            if loc in lines:
                where, first = f"{path}:{line}: {'.'.join(loc)}", lines[loc]
                problems.append(FreerockError(where, f"is given twice, first on line {first}", "keep one"))
            lines[loc] = line
        data = loader.construct_document(root) if root else None
    except FreerockError as error:
        return None, {}, [error]
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"{path}:{mark.line + 1}" if mark else str(path)
        what = getattr(error, "problem", None) or getattr(error, "reason", None) or "is not YAML"
        return None, {}, [FreerockError(where, what, "correct the YAML; indent with spaces, not tabs")]
    except (ValueError, RecursionError) as error:
        what = str(error) if isinstance(error, ValueError) else "keys are nested without end"
        return None, {}, [FreerockError(path, what, "correct the YAML; put texts in quotes")]
    if not isinstance(data, dict):
        what = "is empty" if data is None else "is not a list of keys and values"
        return None, {}, [*problems, FreerockError(path, what, "write lines of the form key: value")]
    return data, lines, problems


def _locate_keys(node: yaml.Node | None, loc: Key = ()) -> Iterator[tuple[Key, int]]:
    """Location and line of every key and list item below a YAML node; keys become texts, even no and 1."""
    children: list[tuple[str, yaml.Node, yaml.Node]] = []
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if isinstance(key, yaml.ScalarNode) and not key.tag.endswith(":merge"):
                key.tag = "tag:yaml.org,2002:str"
                children.append((key.value, key, value))
    elif isinstance(node, yaml.SequenceNode):
        children = [(str(i), item, item) for i, item in enumerate(node.value)]
    for name, key, value in children:
        yield (*loc, name), key.start_mark.line + 1
        yield from _locate_keys(value, (*loc, name))


def place(path: Path, lines: Lines, loc: Key) -> str:
    """file:line: key, by the line of the nearest key that is in the file."""
    near = next((loc[:n] for n in range(len(loc), 0, -1) if loc[:n] in lines), None)
    return f"{path}:{lines[near]}: {'.'.join(loc)}" if near else f"{path}: {'.'.join(loc)}"
