"""The table of a study where the documentation has it."""

from pathlib import Path


def renew(document: str | Path, mark: tuple[str, str], table: str) -> None:
    """Put a table between two marks of a document, in place of what is there."""
    before, rest = Path(document).read_text(encoding="utf-8").split(mark[0])
    after = rest.split(mark[1])[1]
    Path(document).write_text(before + mark[0] + table + mark[1] + after, encoding="utf-8")
