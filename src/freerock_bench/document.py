"""Tables of the bench where the documentation has them."""

from collections.abc import Iterable, Sequence
from pathlib import Path

BEGIN, END = "<!-- {} -->\n\n", "\n\n<!-- end of {} -->"


def in_markdown(heads: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Cells as Markdown, below their heads."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (heads, *rows)]
    return "\n".join([lines[0], "|---" * len(heads) + "|", *lines[1:]])


def marked(document: str | Path, name: str) -> tuple[str, str, str]:
    """What stands in a document before the marks of a table, between them, and after them."""
    before, rest = Path(document).read_text(encoding="utf-8").split(BEGIN.format(name))
    table, after = rest.split(END.format(name))
    return before, table, after


def renew(document: str | Path, name: str, table: str) -> None:
    """Put a table between its marks in a document, in place of what is there."""
    before, _, after = marked(document, name)
    Path(document).write_text(
        before + BEGIN.format(name) + table + END.format(name) + after, encoding="utf-8"
    )
