"""The tables of a campaign as numbers: tidy ones, predictions, and tables 1 to 3."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from freerock.columns import table_of
from freerock.tables.campaign_tables import campaign_tables
from freerock.tables.csvfile import write_csv


def make_tables(
    settings: Mapping[str, Any],
    record_files: Sequence[str | Path],
    fit_files: Sequence[str | Path],
    folder: str | Path,
) -> None:
    """Write the tables of a campaign as CSV into a folder; other arguments as of `campaign_tables`."""
    for name, frame in campaign_tables(settings, record_files, fit_files).items():
        write_csv(table_of(name, frame), Path(folder, f"{name}.csv"))
