"""A printed table as GitHub-flavoured Markdown."""

from collections.abc import Sequence

import pandas as pd

SIGNS = str.maketrans({sign: f"\\{sign}" for sign in r"\`*[]|~"})
SIGNS |= str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})


def markdown(text: pd.DataFrame, caption: str, notes: Sequence[str] = ()) -> str:
    """A printed table as GitHub-flavoured Markdown; arguments as of `freerock.tables.latex.latex`."""
    rows = [list(text.columns), *text.values.tolist()]
    lines = ["| " + " | ".join(map(_cell, row)) + " |" for row in rows]
    lines.insert(1, "| " + " | ".join(["---"] * len(text.columns)) + " |")
    below = [f"*{_cell(note)}*  " for note in notes]
    return "\n".join([f"**{_cell(caption)}**", "", *lines, "", *below]).rstrip() + "\n"


def _cell(text: str) -> str:
    """A text on one line, in which no sign is Markdown's or HTML's."""
    return " ".join(text.split()).translate(SIGNS).replace("&lt; ", "< ")  # which begins no tag
