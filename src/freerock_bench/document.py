"""Tables of the bench where the documentation has them."""

from collections.abc import Iterable, Sequence
from pathlib import Path

BEGIN, END = "<!-- {} -->\n\n", "\n\n<!-- end of {} -->"


def in_markdown(heads: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Cells as Markdown, below their heads."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (heads, *rows)]
    return "\n".join([lines[0], "|---" * len(heads) + "|", *lines[1:]])


def renew(document: str | Path, name: str, table: str) -> None:
    """Put a table between its marks in a document, in place of what is there."""
    before, rest = Path(document).read_text(encoding="utf-8").split(BEGIN.format(name))
    _, after = rest.split(END.format(name))
    text = before + BEGIN.format(name) + table + END.format(name) + after
    Path(document).write_text(text, encoding="utf-8")
