"""The product of a study, and its table where the documentation has it."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import pandas as pd

from freerock.tables.csvfile import write_csv


def publish(
    run: Callable[[str], pd.DataFrame],
    mark: tuple[str, str],
    markdown: Callable[[pd.DataFrame], str],
    product: str,
    size: str,
    document: str = "",
) -> None:
    """Run a study, write what it measured, and renew its table in a document, where one is named."""
    frame = run(size)
    write_csv(frame, Path(product))
    if document:
        renew(document, mark, markdown(frame))


def in_markdown(heads: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """Cells as Markdown, below their heads."""
    lines = [f"| {' | '.join(map(str, cells))} |" for cells in (heads, *rows)]
    return "\n".join([lines[0], "|---" * len(heads) + "|", *lines[1:]])


def renew(document: str | Path, mark: tuple[str, str], table: str) -> None:
    """Put a table between two marks of a document, in place of what is there."""
    before, rest = Path(document).read_text(encoding="utf-8").split(mark[0])
    after = rest.split(mark[1])[1]
    Path(document).write_text(before + mark[0] + table + mark[1] + after, encoding="utf-8")
