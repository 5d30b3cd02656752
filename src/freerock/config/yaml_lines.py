"""Text and YAML files, with the line on which each key stands.

YAML is read as its version 1.2, in which numbers are what they look like: 017 is 17, and 1:30 is a text. The
work that a file may require is bounded: its length, and its values after aliases have been followed.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeGuard

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError
from ruamel.yaml.tag import Tag

from freerock import bounds
from freerock.errors import FreerockError
from freerock.files import read_bytes

Key = tuple[str, ...]  # where a value stands: the keys and list positions on the way to it
Lines = dict[Key, int]  # line of each key of a YAML file

TEXT = "tag:yaml.org,2002:str"
MERGE = "tag:yaml.org,2002:merge"
DATE, VALUE = "tag:yaml.org,2002:timestamp", "tag:yaml.org,2002:value"  # of YAML 1.1
NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
CORRECT = "correct the YAML; indent with spaces, not tabs"
PLAIN = "give the value alone, in quotes where it is a text"


def read_text(path: Path, most_bytes: int = bounds.TEXT_BYTES) -> str:
    """The text of a file in UTF-8; raises FreerockError where it can't be read or is longer than that."""
    return text_of(read_bytes(path, most_bytes), path)


def text_of(content: bytes, path: Path) -> str:
    """The text that the bytes of a file are in UTF-8, with plain ends of lines; raises FreerockError."""
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FreerockError(f"{path}:{line}", "is not UTF-8 text", "save the file as UTF-8") from None


def read_yaml(path: Path) -> tuple[dict[str, Any] | None, Lines, list[FreerockError]]:
    """Keys and values (None when unreadable), the line of each key, and the problems met."""
    reader = YAML(typ="safe", pure=True)
    reader.Composer = _Composer
    reader.allow_duplicate_keys = True  # reported here, with both lines
    try:
        root = reader.compose(_plain_text(path))
        lines: Lines = {}
        problems: list[FreerockError] = []
        for loc, line, number in _decimal_commas(root):
            where, remedy = f"{path}:{line}: {'.'.join(loc)}", f"write {number.replace(',', '.')}"
            problems.append(FreerockError(where, f"{number} has a decimal comma", remedy))
        for loc, line in _locate_keys(root):
            if loc in lines:
                where, first = f"{path}:{line}: {'.'.join(loc)}", lines[loc]
                problems.append(FreerockError(where, f"is given twice, first on line {first}", "keep one"))
            lines[loc] = line
        data = reader.constructor.construct_document(root) if root else None
    except FreerockError as error:
        return None, {}, [error]
    except ReaderError as error:
        where = f"{path}:{read_text(path).count(chr(10), 0, error.position) + 1}"
        return None, {}, [FreerockError(where, f"has the character {chr(error.character)!r}", "leave it out")]
    except YAMLError as error:
        return None, {}, [_fault(path, error)]
    if not isinstance(data, dict):
        what = "is empty" if data is None else "is not a list of keys and values"
        return None, {}, [*problems, FreerockError(path, what, "write lines of the form key: value")]
    return data, lines, problems


def _plain_text(path: Path) -> str:
    """The text of a YAML file; refuses directives, with which a file may require another version of YAML."""
    text = read_text(path, bounds.YAML_BYTES)
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("%"):
            raise FreerockError(f"{path}:{number}", "begins with %", "leave the line out")
    return text


class _Refused(MarkedYAMLError):
    """What is YAML and no configuration, with its remedy."""

    def __init__(self, what: str, remedy: str, mark: Any) -> None:
        super().__init__(problem=what, problem_mark=mark)
        self.remedy = remedy


class _Composer(Composer):
    """Composes values without tags, and no more of them than a configuration has."""

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self.warn_double_anchors = False
        self.nodes = 0
        self.nodes_in: dict[int, int] = {}  # of each node with an anchor, what it holds

    def compose_node(self, parent: Any, index: Any) -> Node:
        event, before = self.parser.peek_event(), self.nodes
        if getattr(event, "tag", None) not in (None, "!", TEXT):
            raise _Refused(
                f"the tag {event.tag[: bounds.NUMBER_CHARACTERS]!r} has no meaning here",
                PLAIN,
                event.start_mark,
            )
        if self.depth == bounds.YAML_LEVELS:
            raise _Refused(f"keys are nested more than {bounds.YAML_LEVELS} deep", CORRECT, event.start_mark)
        node: Node = super().compose_node(parent, index)
        if not isinstance(event, AliasEvent):
            self.nodes += 1
            self.nodes_in[id(node)] = self.nodes - before
        elif id(node) in self.nodes_in:
            self.nodes += self.nodes_in[id(node)]
        else:
            raise _Refused(f"*{event.anchor} holds itself", "write the value out", event.start_mark)
        if self.nodes > bounds.YAML_NODES:
            remedy = "split it into several campaigns; write aliases out"
            raise _Refused(f"more than {bounds.YAML_NODES} keys and values", remedy, event.start_mark)
        if isinstance(node, ScalarNode):
            _check_scalar(node)
        return node


def _check_scalar(node: ScalarNode) -> None:
    """Refuse numbers that are not what they look like; read as texts what YAML 1.2 knows as such."""
    if node.tag in NUMBERS and ("_" in node.value or len(node.value) > bounds.NUMBER_CHARACTERS):
        what = f"{node.value[: bounds.NUMBER_CHARACTERS]!r} is not a number"
        raise _Refused(what, "write it shorter, without _", node.start_mark)
    if node.tag in (DATE, VALUE):
        node.ctag = Tag(suffix=TEXT)


def _fault(path: Path, error: YAMLError) -> FreerockError:
    """What the reader found, in one line."""
    mark = getattr(error, "problem_mark", None)
    where = f"{path}:{mark.line + 1}" if mark else str(path)
    what = getattr(error, "problem", None) or "is not YAML"
    remedy = getattr(error, "remedy", CORRECT)
    return FreerockError(where, what, remedy)


def _decimal_commas(node: Node | None, loc: Key = ()) -> Iterator[tuple[Key, int, str]]:
    """Location, line and text of each number that a comma cut in two, as in {a: 0,42}; it is joined."""
    if isinstance(node, SequenceNode):
        for i, item in enumerate(node.value):
            yield from _decimal_commas(item, (*loc, str(i)))
    if not isinstance(node, MappingNode):
        return
    whole: list[tuple[Node, Node]] = []
    for key, value in node.value:
        before = whole[-1][1] if whole else None
        if _is_digits(key) and _is_digits(before) and isinstance(value, ScalarNode) and not value.value:
            number = f"{before.value},{key.value}"
            yield (*loc, str(whole[-1][0].value)), key.start_mark.line + 1, number
            before.value, before.ctag = number.replace(",", "."), Tag(suffix=NUMBERS[1])
        else:
            yield from _decimal_commas(value, (*loc, str(key.value)))
            whole.append((key, value))
    node.value = whole


def _is_digits(node: Node | None) -> TypeGuard[ScalarNode]:
    return isinstance(node, ScalarNode) and node.style is None and node.value.lstrip("+-").isdigit()


def _locate_keys(node: Node | None, loc: Key = ()) -> Iterator[tuple[Key, int]]:
    """Location and line of every key and list item below a YAML node; keys become texts, even no and 1."""
    children: list[tuple[str, Node, Node]] = []
    if isinstance(node, MappingNode):
        for key, value in node.value:
            if not isinstance(key, ScalarNode):
                raise _Refused("a key is no word", "write lines of the form key: value", key.start_mark)
            if key.tag != MERGE:
                key.ctag = Tag(suffix=TEXT)
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
