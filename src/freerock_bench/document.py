"""The product of a study, and its table where the documentation has it."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from freerock.tables.csvfile import write_csv


def publish(
    frame: pd.DataFrame,
    product: str,
    document: str,
    mark: tuple[str, str],
    markdown: Callable[[pd.DataFrame], str],
) -> None:
    """Write what a study measured, and renew its table in a document, where one is named."""
    write_csv(frame, Path(product))
    if document:
        renew(document, mark, markdown(frame))


def renew(document: str | Path, mark: tuple[str, str], table: str) -> None:
    """Put a table between two marks of a document, in place of what is there."""
    before, rest = Path(document).read_text(encoding="utf-8").split(mark[0])
    after = rest.split(mark[1])[1]
    Path(document).write_text(before + mark[0] + table + mark[1] + after, encoding="utf-8")
