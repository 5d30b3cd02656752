"""Tables of the bench where the documentation has them."""

from collections.abc import Iterable, Sequence
from pathlib import Path


def in_markdown(heads: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Cells as Markdown, below their heads."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (heads, *rows)]
    return "\n".join([lines[0], "|---" * len(heads) + "|", *lines[1:]])


def renew(document: str | Path, mark: tuple[str, str], table: str) -> None:
    """Put a table between two marks of a document, in place of what is there."""
    before, rest = Path(document).read_text(encoding="utf-8").split(mark[0])
    after = rest.split(mark[1])[1]
    Path(document).write_text(before + mark[0] + table + mark[1] + after, encoding="utf-8")
