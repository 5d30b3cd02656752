"""A printed table as GitHub-flavoured Markdown."""

from collections.abc import Sequence

import pandas as pd


def markdown(text: pd.DataFrame, caption: str, notes: Sequence[str] = ()) -> str:
    """A printed table as GitHub-flavoured Markdown; arguments as of `freerock.tables.latex.latex`."""
    rows = [list(text.columns), ["---"] * len(text.columns), *text.values.tolist()]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join([f"**{caption}**", "", *lines, "", *(f"*{note}*  " for note in notes)]).rstrip() + "\n"
