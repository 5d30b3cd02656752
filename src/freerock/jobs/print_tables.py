"""Tables as they are printed: Markdown, LaTeX, and the numbers of a text as LaTeX macros."""

from collections.abc import Mapping
from pathlib import Path

from freerock.files import write_text
from freerock.report.printed import printed_tables
from freerock.tables.csvfile import read_csv
from freerock.tables.latex import latex, numbers_tex
from freerock.tables.markdown import markdown


def print_tables(
    files: Mapping[str, str | Path],
    folder: str | Path,
    *,
    origin: str,
    doi: str = "",
    labels: Mapping[str, str] | None = None,
) -> None:
    """Write tables 1 to 3 and r of each impact as Markdown and LaTeX, and numbers.tex.

    Parameters
    ----------
    files : mapping of str to path
        CSV files of the tables runs, epsilon, choice, populations, restitution and table1 to table3.
    folder : path
        Where they are written.
    origin, doi, labels
        As of `freerock.report.printed.printed_tables`.
    """
    tables = {name: read_csv(path) for name, path in files.items()}
    for name, table in printed_tables(tables, origin, doi=doi, labels=labels).items():
        write_text(Path(folder, f"{name}.md"), markdown(*table))
        write_text(Path(folder, f"{name}.tex"), latex(*table, label=f"tab:{name}"))
    write_text(Path(folder, "numbers.tex"), numbers_tex(tables))
